"""A film judged by a reader, and what is checked of its answer: it may be in a stranger's hands."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from moireid import __version__
from moireid.errors import MediaError
from moireid.reading.film_orders import JudgingOrder
from moireid.reading.film_reader import Reader
from moireid.verifier.reasons import json_number
from moireid.verifier.report.report_page import NAME, Pictures
from moireid.verifier.video import OpenedFile


@dataclass(frozen=True)
class JudgedReport:
    """A report as JSON; with the pictures and the signals of its page where they were asked for."""

    report: dict[str, Any]
    pictures: Pictures
    signals: str


def judged_film(order: JudgingOrder, reader: Reader, progress: Callable[[int, int | None], None]) -> JudgedReport:
    """The report of a film, with the parts of the seal under which it was read.

    Raises: MoireIdError as `verifier.verify` does; MediaError where the reader fails, or the film changed meanwhile.
    """
    # By this process, as an attacker may control the other one.
    try:
        before = OpenedFile(order.video).sha256()
    except OSError as error:
        raise MediaError(f"film {order.video} cannot be read ({error.strerror}); check its name and rights") from error
    found = reader.read(order, progress)
    report = found["result"] if isinstance(found.get("result"), dict) else {}
    if not isinstance(report.get("input"), dict) or report["input"].get("sha256") != before:
        raise MediaError(f"{order.video} changed while it was judged; give a film that no program writes to any more")
    if report.get("level") == "live":
        raise MediaError(f"the process that read {order.video} calls a film a live check; judge it by another moireid")
    if order.barred is not None and report.get("verdict") == "accept":
        raise MediaError(f"the process that read {order.video} accepts a badge that no longer counts; do not trust it")
    # These are no finding of the film; who has receipts of live checks adds them afterwards.
    report.pop("live_checks", None)
    detectors = [{"name": name, "score": json_number(score)} for name, score in order.detectors]
    own = {"sealed": list(reader.sealed), "moireid": __version__, "detectors": detectors}
    return JudgedReport(report | own, _pictures(found), str(found.get("signals", "")))


def _pictures(found: dict[str, Any]) -> Pictures:
    """The pictures that a process drew; names are among ours."""
    files, frame_s = found.get("files", {}), found.get("frame_s")
    named = {name: base64.b64decode(text) for name, text in files.items() if NAME.fullmatch(name)}
    return Pictures(named, tuple(map(str, found.get("plots", []))), frame_s if isinstance(frame_s, float) else None)
