"""Films judged in a process without the signing key, and the verdict as content credentials (C2PA).

Judging: the process decodes an untrusted film.  The signing process starts it, receives its report as JSON, ends it,
and only then signs.

Writing credentials: c2pa-python reads and writes films in processes that never have the key.  The first one writes, and
gets one signature, for the one claim that it makes.  The second one has received nothing from the first but the file,
and reads that back.
Convention: the assertion `credentials_work.LABEL` holds the report, as `statement.attested` gives it.
"""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from securesystemslib.signer import CryptoSigner

from moireid import errors
from moireid.attest.credentials_work import CredentialRequest
from moireid.attest.film_credentials import with_carried
from moireid.attest.signing_keys import SigningKey, certificate_pem, holder
from moireid.errors import MediaError, MoireIdError, SpecError
from moireid.extras import missing_extra
from moireid.files import whole_file
from moireid.provenance import Exclusion
from moireid.sandbox.child import Talk
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import ProcessEnd, start
from moireid.sandbox.seal import ProcessLimits
from moireid.verifier.report.report_page import NAME, Pictures, pictures_of
from moireid.verifier.session.claim import Claim
from moireid.verifier.video import OpenedFile

#: Six times what a 1080p film takes, so that one of 4K passes.
MEMORY_BYTES = 4 << 30
#: Greatest size of one answer: a report's pictures, or its signals as text.  A signing process judges one film only.
ANSWER_BYTES = 32 << 20
#: Least time between two reports of progress, s.
PROGRESS_S = 0.1


@dataclass(frozen=True)
class JudgingOrder:
    """What to judge, as the arguments of `verifier.verify`; pictures: whether the report's pictures are drawn too."""

    video: Path
    claim: Claim
    barred: Exclusion | None = None
    overlap: bool = False
    detectors: tuple[tuple[str, float], ...] = ()
    pictures: bool = False


@dataclass(frozen=True)
class JudgedReport:
    """A report as JSON; with the pictures and the signals of its page where they were asked for.

    sealed: the parts of the seal that held for the process that judged, as in `sandbox.seal.MEANS`.
    """

    report: dict[str, Any]
    pictures: Pictures
    signals: str
    sealed: tuple[str, ...] = ()


def judged_apart(order: JudgingOrder, progress: Callable[[int, int | None], None]) -> JudgedReport:
    """The report of a film, judged in another process.

    Raises: MoireIdError as `verifier.verify` does; MediaError where the process fails, or the film changed meanwhile.
    """
    # By this process, as an attacker may control the other one.
    try:
        before = OpenedFile(order.video).sha256()
    except OSError as error:
        raise MediaError(f"film {order.video} cannot be read ({error.strerror}); check its name and rights") from error
    found: dict[str, Any] = {}

    def receive(message: dict[str, Any]) -> None:
        if "progress" in message:
            progress(*message["progress"])
        found.update(message)

    sealed = talk_with("moireid.attest.credentials:judge", order, order.video, receive)
    report = found["result"] if isinstance(found.get("result"), dict) else {}
    if not isinstance(report.get("input"), dict) or report["input"].get("sha256") != before:
        raise MediaError(f"{order.video} changed while it was judged; give a film that no program writes to any more")
    if report.get("level") == "live":
        raise MediaError(f"the process that read {order.video} calls a film a live check; judge it by another moireid")
    return JudgedReport(report, _pictures(found), str(found.get("signals", "")), sealed)


def talk_with(
    work: str,
    message: object,
    film: Path,
    answer: Callable[[dict[str, Any]], object],
    written: Sequence[Path] = (),
    read: Sequence[Path] = (),
) -> tuple[str, ...]:
    """Start a sealed process for some work on a film, and answer its messages until it has ended.

    Parameters: work: `module:function`; answer: returns what is sent back, None for nothing; written: existing files
        that it may write; read: files that it may read apart from the film.
    Returns: the parts of the seal that held.
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
            if (message := child.hear()) is not None and (back := answer(message)) is not None:
                child.send(back)
    except ProcessEnd as ended:
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
    from moireid.verifier.report.report_page import signals_csv
    from moireid.verifier.session.film import verify

    order: JudgingOrder = talk.next()
    sent_s = 0.0

    def progress(done: int, of: int | None) -> None:
        nonlocal sent_s
        if time.monotonic() - sent_s >= PROGRESS_S:
            sent_s = time.monotonic()
            talk.send({"progress": [done, of]})

    made = verify(order.video, order.claim, barred=order.barred, overlap=order.overlap, progress=progress)
    report = replace(with_carried(made, order.video), detectors=order.detectors)
    talk.send({"result": report.to_json()})
    if order.pictures:
        drawn = pictures_of(report)
        files = {name: base64.b64encode(content).decode() for name, content in drawn.files.items()}
        talk.send({"files": files, "plots": list(drawn.plots), "frame_s": drawn.frame_s})
        talk.send({"signals": signals_csv(report)})


def _pictures(found: dict[str, Any]) -> Pictures:
    """The pictures that a process drew; names are among ours."""
    files, frame_s = found.get("files", {}), found.get("frame_s")
    named = {name: base64.b64decode(text) for name, text in files.items() if NAME.fullmatch(name)}
    return Pictures(named, tuple(map(str, found.get("plots", []))), frame_s if isinstance(frame_s, float) else None)


def _ours(ended: ProcessEnd) -> MoireIdError:
    """The error that the work raised on purpose, of its own kind."""
    kind: type[MoireIdError] = getattr(errors, ended.kind) if ended.kind in errors.__all__ else MediaError
    return kind(ended.words)


Form = Literal["sidecar", "embed"]
#: How COSE begins what is signed (RFC 9052, 4.4): an array of four, the first of which is this text.
TO_BE_SIGNED = b"\x84\x6aSignature1"
#: States of credentials that hold, by c2pa.
SOUND = ("Valid", "Trusted")
UNTRUSTED = (
    "the certificate of {holder!r} is on no trust list that is known here. Programs will say that its signer is "
    "unknown: the holder of that key signed this verdict, and its issuer alone can say who that is"
)


def credentials_path(film: Path, form: Form) -> Path:
    """Where credentials are written: next to the film, and never over it."""
    return film.with_suffix(".c2pa") if form == "sidecar" else film.with_name(f"{film.stem}.c2pa{film.suffix}")


def check_credentials_key(key: SigningKey) -> None:
    """Check that a key can sign content credentials.

    Raises: MissingExtraError without c2pa-python; SpecError where the key has no certificate of an authority.
    """
    if find_spec("c2pa") is None:
        raise missing_extra("--c2pa", "c2pa-python", "c2pa")
    if not key.chain or key.chain[0].issuer == key.chain[0].subject:
        raise SpecError(
            "content credentials need a certificate that an authority issued for the key of --sign; append it, and "
            "those above it, to that file"
        )


def write_credentials(report: dict[str, Any], film: Path, form: Form, key: SigningKey) -> str:
    """Write a report as content credentials, and read them back.

    Parameters: report: as `statement.attested` gives it; key: `check_credentials_key` lets it pass.
    Returns: what a reader will make of the certificate, in words.
    Raises: MediaError where they cannot be written, or do not hold when they are read again; nothing is left then.
    """
    found = dict[str, Any]()
    algorithm = "ED25519" if isinstance(key.private, Ed25519PrivateKey) else "ES256"
    chain = "".join(certificate_pem(one) for one in key.chain)

    with whole_file(credentials_path(film, form)) as output:
        asked = CredentialRequest(film, output, form, report, algorithm, chain)
        talk_with("moireid.attest.credentials_work:write", asked, film, _one_signature(film, key), [output])
        talk_with("moireid.attest.credentials_work:read_back", asked, film, found.update, read=[output])
        if found.get("state") not in SOUND or found.get("verdict") != report:
            raise MediaError(f"the content credentials of {film} do not hold when they are read again; none are kept")
    trusted = found["state"] == "Trusted"
    return "the certificate is trusted" if trusted else UNTRUSTED.format(holder=holder(key.chain[0]))


def _one_signature(film: Path, key: SigningKey) -> Callable[[dict[str, Any]], bytes | None]:
    """Signs the first claim that a process asks for.

    A process that an attacker controls could ask for a signature under a false verdict.  It gets one signature at most,
    and that is kept only if another process reads the true verdict in the signed file.
    """
    asked: list[object] = []

    def answer(message: dict[str, Any]) -> bytes | None:
        if "sign" not in message:
            return None
        asked.append(message["sign"])
        claim = _claim(message["sign"])
        if len(asked) > 1 or not claim.startswith(TO_BE_SIGNED):
            raise MediaError(f"the process that read {film} asks for another signature than one of its credentials")
        return bytes.fromhex(CryptoSigner(key.private).sign(claim).signature)

    return answer


def _claim(said: object) -> bytes:
    """The claim that a process wants signed; empty where its message cannot be read."""
    try:
        return base64.b64decode(said) if isinstance(said, str) else b""
    except ValueError:
        return b""
