"""A film judged, or identified, by a reader, as far as its answer can be checked.

Convention: this process states what a film cannot show: its path and digest, the seal, and the version.  What the
    fringes show is on the reader's word; an attacker who takes it over can answer any verdict that is spelled as one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from moireid.badge import Badge
from moireid.errors import MediaError
from moireid.files import kind_of_file
from moireid.question import KnownCamera, Question
from moireid.reading.answers import FilmAnswer, checked_identification, checked_report, malformed
from moireid.reading.film_orders import Progress, identify_film, judge_film, published_method
from moireid.reading.film_reader import Reader
from moireid.verifier.opened_file import OpenedFile
from moireid.version import __version__


def judged_film(
    film: Path, question: Question, reader: Reader, progress: Progress, *, pictures: bool = False
) -> FilmAnswer:
    """The report of a film, with the parts of the seal under which it was read, and what was claimed.

    Raises: MoireIdError as `verifier.verify` does; MediaError where the reader fails, or answers what no film shows, or
        the film changed meanwhile.
    """
    if question.published:
        # Where the lab is missing, this is said before the film is read.
        published_method()
    digest = _digest(film)
    order = partial(judge_film, film=film, question=question, pictures=pictures)
    found = reader.read(order, progress)
    report = found.result
    report |= {"sealed": list(reader.sealed), "moireid": __version__}
    checked_report(report, film, question.barred)
    _state_input(report, film, digest)
    if pictures and not found.pictures.signals:
        raise malformed(film, "no pictures")
    report |= question.stated()
    return found


def identified_film(
    film: Path,
    layouts: Sequence[Badge],
    camera: KnownCamera | None,
    track: int | None,
    reader: Reader,
    progress: Progress,
) -> dict[str, Any]:
    """Whose badge a film shows if it is enrolled, as JSON, with the parts of the seal under which it was read.

    Raises: MoireIdError as `verifier.identify` does; MediaError as `judged_film`.
    """
    digest = _digest(film)
    order = partial(identify_film, film=film, layouts=layouts, camera=camera, track=track)
    found = reader.read(order, progress).result
    found |= {"sealed": list(reader.sealed)}
    checked_identification(found, film)
    if "input" in found:
        _state_input(found, film, digest)
    return found


def _digest(film: Path) -> str:
    """SHA-256 of a film, by this process, as an attacker may control the other one."""
    if (kind := kind_of_file(film)) is not None:
        hint = "; a photo shows no motion" if "photo" in kind or "picture" in kind else ""
        raise MediaError(f"{film} is {kind}, and no film{hint}; give one that a video player can play, such as an .mp4")
    try:
        return OpenedFile(film).sha256()
    except OSError as error:
        raise MediaError(f"film {film} cannot be read ({error.strerror}); check its name and rights") from error


def _state_input(report: dict[str, Any], film: Path, digest: str) -> None:
    """State the film's path and digest.  Raises: MediaError where the reader read another content."""
    if report["input"]["sha256"] != digest:
        raise MediaError(f"{film} changed while it was judged; give a film that no program writes to any more")
    report["input"] |= {"path": str(film), "sha256": digest}
