"""A film judged, or identified, by a reader, as far as its answer can be checked.

Convention: this process states what a film cannot show: its path and digest, the seal, and the version.  What the
    fringes show is on the reader's word; an attacker who takes it over can answer any verdict that is spelled as one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from moireid.errors import MediaError
from moireid.reading.answers import FilmAnswer, checked, checked_identification, checked_report
from moireid.reading.film_orders import FilmOrder, IdentifyingOrder, JudgingOrder
from moireid.reading.film_reader import Answer, Reader
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.report.report_page import Pictures
from moireid.version import __version__

Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class JudgedReport:
    """A report as JSON; with the pictures and the signals of its page where they were asked for."""

    report: dict[str, Any]
    pictures: Pictures
    signals: str


def judged_film(order: JudgingOrder, reader: Reader, progress: Progress) -> JudgedReport:
    """The report of a film, with the parts of the seal under which it was read.

    Raises: MoireIdError as `verifier.verify` does; MediaError where the reader fails, or answers what no film shows, or
        the film changed meanwhile.
    """
    digest = _digest(order.video)
    found = _read(order, order.video, reader, progress)
    report = found.result
    # These are no finding of the film; who has receipts of live checks adds them afterwards.
    report.pop("live_checks", None)
    report |= {"sealed": list(reader.sealed), "moireid": __version__}
    checked_report(report, order.video)
    _state_input(report, order.video, digest)
    if report.get("level") == "live":
        raise MediaError(f"the process that read {order.video} calls a film a live check; judge it by another moireid")
    if order.barred is not None and report["verdict"] == "accept":
        raise MediaError(f"the process that read {order.video} accepts a badge that no longer counts; do not trust it")
    pictures = Pictures(found.files, tuple(found.plots), found.frame_s)
    return JudgedReport(report, pictures, found.signals)


def identified_film(order: IdentifyingOrder, reader: Reader, progress: Progress, answer: Answer) -> dict[str, Any]:
    """Whose badge a film shows, as JSON, with the parts of the seal under which it was read.

    Parameters: answer: to the questions of the reader.
    Raises: MoireIdError as `verifier.identify` does; MediaError as `judged_film`.
    """
    digest = _digest(order.video)
    found = _read(order, order.video, reader, progress, answer).result
    found.pop("live_checks", None)
    found |= {"sealed": list(reader.sealed)}
    checked_identification(found, order.video)
    if "input" in found:
        _state_input(found, order.video, digest)
    return found


def _read(order: FilmOrder, film: Path, reader: Reader, progress: Progress, answer: Answer | None = None) -> FilmAnswer:
    return checked(reader.read(order, progress, answer), FilmAnswer, film)


def _digest(film: Path) -> str:
    """SHA-256 of a film, by this process, as an attacker may control the other one."""
    try:
        return OpenedFile(film).sha256()
    except OSError as error:
        raise MediaError(f"film {film} cannot be read ({error.strerror}); check its name and rights") from error


def _state_input(report: dict[str, Any], film: Path, digest: str) -> None:
    """State the film's path and digest.  Raises: MediaError where the reader read another content."""
    if report["input"]["sha256"] != digest:
        raise MediaError(f"{film} changed while it was judged; give a film that no program writes to any more")
    report["input"] |= {"path": str(film), "sha256": digest}
