"""A film judged in a process that never has the signing key.

The process decodes what a stranger sent.  Whoever signs starts it, hears its report as JSON, ends it, and only then
signs.
"""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from moireid import errors
from moireid.attest.carried import with_carried
from moireid.errors import MediaError, MoireIdError, SpecError
from moireid.provenance import Barred
from moireid.sandbox.child import Talk
from moireid.sandbox.limits import ProcessLimits
from moireid.sandbox.process import Ended, start
from moireid.sandbox.reach import reach
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.report.pictures import NAME, Pictures, pictures_of
from moireid.verifier.session.claim import Claim

#: Six times what a 1080p film takes, so that one of 4K passes.
MEMORY_BYTES = 4 << 30
#: Greatest size of one answer: a report's pictures, or its signals as text.  Whoever signs does so for one film.
ANSWER_BYTES = 32 << 20
#: Least time between two reports of progress, s.
TELL_S = 0.1


@dataclass(frozen=True)
class Order:
    """What to judge, as the arguments of `verifier.verify`; pictures: whether the report's pictures are drawn too."""

    video: Path
    claim: Claim
    barred: Barred | None = None
    overlap: bool = False
    detectors: tuple[tuple[str, float], ...] = ()
    pictures: bool = False


@dataclass(frozen=True)
class Judged:
    """A report as JSON; with the pictures and the signals of its page where they were asked for.

    sealed: what held of the seal of the process that judged, as in `sandbox.seal.MEANS`.
    """

    report: dict[str, Any]
    pictures: Pictures
    signals: str
    sealed: tuple[str, ...] = ()


def judged_apart(order: Order, progress: Callable[[int, int | None], None]) -> Judged:
    """The report of a film, judged in another process.

    Raises: MoireIdError as `verifier.verify` does; MediaError where the process fails, or the film changed meanwhile.
    """
    # By this process, as the other one may be in a stranger's hands.
    try:
        before = OpenedFile(order.video).sha256()
    except OSError as error:
        raise MediaError(f"film {order.video} cannot be read ({error.strerror}); check its name and rights") from error
    found: dict[str, Any] = {}

    def hear(told: dict[str, Any]) -> None:
        if "progress" in told:
            progress(*told["progress"])
        found.update(told)

    sealed = talk_with("moireid.attest.apart:judge", order, order.video, hear)
    report = found["result"] if isinstance(found.get("result"), dict) else {}
    if not isinstance(report.get("input"), dict) or report["input"].get("sha256") != before:
        raise MediaError(f"{order.video} changed while it was judged; give a film that nobody writes to any more")
    return Judged(report, _pictures(found), str(found.get("signals", "")), sealed)


def talk_with(
    work: str,
    message: object,
    film: Path,
    answer: Callable[[dict[str, Any]], object],
    written: Sequence[Path] = (),
    read: Sequence[Path] = (),
) -> tuple[str, ...]:
    """Start a sealed process for some work on a film, and answer what it says until it has ended.

    Parameters: work: `module:function`; answer: gives what is sent back, None for nothing; written: files that are
        there, and that it may write; read: that it may read beside the film.
    Returns: what held of the seal.
    Raises: MoireIdError that the work raised; MediaError where the process fails.
    """
    if os.name == "nt":
        raise SpecError(
            "verdicts are not signed on Windows, as films cannot be judged apart from the key there; sign "
            "on Linux or macOS"
        )
    child = start(
        work, ProcessLimits(MEMORY_BYTES, answer_bytes=ANSWER_BYTES), within=reach(read=[film, *read], write=written)
    )
    try:
        child.send(message)
        while True:
            if (told := child.hear()) is not None and (back := answer(told)) is not None:
                child.send(back)
    except Ended as ended:
        if ended.kind == "done":
            return child.sealed or ()
        if ended.kind == "memory":
            raise MediaError(
                f"{film} asks for more memory than the {MEMORY_BYTES >> 30} GiB that one may have"
            ) from ended
        if ended.ours:
            raise _ours(ended) from ended
        how = ended.words if ended.kind == "crash" else f"failed ({ended.kind}: {ended.words[:300]})"
        raise MediaError(f"the process that read {film} {how}; the film may be damaged") from ended
    finally:
        child.kill()


def judge(talk: Talk) -> None:
    """The work of the process: one film."""
    from moireid.verifier.report.page import signals_csv
    from moireid.verifier.session.film import verify

    order: Order = talk.next()
    told_s = 0.0

    def progress(done: int, of: int | None) -> None:
        nonlocal told_s
        if time.monotonic() - told_s >= TELL_S:
            told_s = time.monotonic()
            talk.tell({"progress": [done, of]})

    made = verify(order.video, order.claim, barred=order.barred, overlap=order.overlap, progress=progress)
    report = replace(with_carried(made, order.video), detectors=order.detectors)
    talk.tell({"result": report.to_json()})
    if order.pictures:
        drawn = pictures_of(report)
        files = {name: base64.b64encode(content).decode() for name, content in drawn.files.items()}
        talk.tell({"files": files, "plots": list(drawn.plots), "frame_s": drawn.frame_s})
        talk.tell({"signals": signals_csv(report)})


def _pictures(found: dict[str, Any]) -> Pictures:
    """The pictures that a process drew; names are among ours."""
    files, frame_s = found.get("files", {}), found.get("frame_s")
    named = {name: base64.b64decode(text) for name, text in files.items() if NAME.fullmatch(name)}
    return Pictures(named, tuple(map(str, found.get("plots", []))), frame_s if isinstance(frame_s, float) else None)


def _ours(ended: Ended) -> MoireIdError:
    """The error that the work raised on purpose, of its own kind."""
    kind: type[MoireIdError] = getattr(errors, ended.kind) if ended.kind in errors.__all__ else MediaError
    return kind(ended.words)
