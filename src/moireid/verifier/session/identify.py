"""Identification without a claim: which enrolled person's badge does a film show, if any?

The film is read once for each layout among the enrolled badges, usually one.  The payload is decoded without using any
person's pitches, and then looked up.  A film whose fringes break the motion law shows no enrolled badge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

from moireid.badge import Badge
from moireid.errors import CodeError, SpecError
from moireid.files import AnyPath
from moireid.question import KnownCamera, Question
from moireid.verifier.identity.decode import Identity
from moireid.verifier.reasons import Reason, worst
from moireid.verifier.session.film import verify
from moireid.verifier.session.result import Report
from moireid.verifier.video import Film, Progress

Finding = Literal["found", "nobody", "inconclusive"]


@dataclass(frozen=True)
class Identification:
    """Whose badge a film shows.

    Attributes
    ----------
    finding : {"found", "nobody", "inconclusive"}
        "found" needs an enrolled id and a motion that obeys the optics.
    found_id : str or None
        The id that was read, lower-case hex digits; None if no one was found.  The finding holds if it is enrolled
        (`of_enrolled`).
    reasons : tuple of Reason
        What the finding is based on.
    report : Report or None
        Of the layout with the most definite finding; None if no one is enrolled or that layout cannot be checked.
    """

    finding: Finding
    found_id: str | None
    reasons: tuple[Reason, ...]
    report: Report | None

    def to_json(self) -> dict[str, Any]:
        """Give the object that ``identify --json`` prints.

        Returns
        -------
        dict
            With the keys of ``verify --json`` if there is a report.
        """
        document: dict[str, Any] = self.report.to_json() if self.report else {}
        return document | {
            "finding": self.finding,
            "found_id": self.found_id,
            "reasons": [r.to_json() for r in self.reasons],
        }


def identify(
    video: AnyPath,
    layouts: Iterable[Badge],
    *,
    camera: KnownCamera | None = None,
    track: int | None = None,
    progress: Progress | None = None,
) -> Identification:
    """Find the badge that a film shows, of those that may be enrolled.

    Parameters
    ----------
    video : str or Path
        The film.
    layouts : iterable of Badge
        One badge of each layout that is enrolled.
    camera : KnownCamera, optional
        What is known of the film's camera.
    track : int, optional
        The video track to judge, as in `verify`.
    progress : callable, optional
        Called with the number of frames read, and the number expected (None if the file does not state it).

    Returns
    -------
    Identification
        Of the layout with the most definite finding.

    Raises
    ------
    MediaError
        If the film cannot be read.

    Notes
    -----
    Convention: "found" needs an id that is decoded, *and* all that `verify` needs of a film without a question.
    "nobody" is fringes that break the law, or a code that they do not confirm.  Whether the id is enrolled is for
    `of_enrolled`.
    Source: `verify` without a question, once for each layout.
    """
    order = {"found": 0, "nobody": 1, "inconclusive": 2}
    outcomes = []
    if camera is not None:
        film = Film(video, track=track)
        camera.check_size((film.width, film.height))
    for layout in layouts:
        try:
            report = verify(video, Question(layout, camera=camera, track=track), progress=progress)
        except (SpecError, CodeError) as error:
            # One unreadable badge in the registry must not hide all others.
            text = f"One badge layout in the registry cannot be checked: {error}."
            reason = Reason("layout", "undecided", None, None, "", text)
            outcomes.append(Identification("inconclusive", None, (reason,), None))
            continue
        outcomes.append(judge(report))
        if outcomes[-1].finding == "found":
            break
    if not outcomes:
        reason = Reason("enrolled", "fail", 0.0, 1.0, "badges", "No one is enrolled in this registry yet.")
        return Identification("nobody", None, (reason,), None)
    # An id that was read may turn out not to be enrolled, which is more definite than none that was read.
    return min(outcomes, key=lambda outcome: (order[outcome.finding], outcome.found_id is None))


def of_enrolled(document: dict[str, Any], enrolled: Callable[[str], bool]) -> dict[str, Any]:
    """An identification's JSON, where the id that was read must be enrolled, and its badge count at present.

    Parameters: enrolled: from an id to whether that is so, as `moireid.registry.holds`.
    """
    read = document["found_id"]
    if read is None or enrolled(read):
        return document
    text = (
        "No one in this registry holds the badge that is shown: it was never issued here, was revoked, or its "
        "holder was erased."
    )
    # The last reason is what was made of the id.
    reasons = [*document["reasons"][:-1], Reason("enrolled", "fail", read, None, "", text).to_json()]
    return document | {"finding": "nobody", "found_id": None, "reasons": reasons}


def judge(report: Report) -> Identification:
    """The finding of one layout's report, made without a question."""
    invariant = report.invariant
    if invariant.verdict == "reject":
        text = "The fringes do not move as a real badge's do, so the film shows no enrolled badge."
        reason = Reason("genuine", "fail", None, None, "", text)
        return Identification("nobody", None, (*invariant.reasons, reason), report)
    unsure = tuple(one for one in report.reasons if one.code in ("tracks", "damaged") and one.level == "undecided")
    if unsure:
        return Identification("inconclusive", None, unsure, report)
    found, reason = _whose(report.identity)
    reasons = (*report.reasons, reason)
    if reason.level == "fail":
        return Identification("nobody", None, reasons, report)
    clear = invariant.verdict == worst(list(reasons)) == "accept"
    return Identification("found" if clear else "inconclusive", found, reasons, report)


def _whose(identity: Identity) -> tuple[str | None, Reason]:
    """The id that was read, if any, and the reason."""
    read = identity.decoded_id
    if read is None:
        return None, Reason("identity", "undecided", None, None, "", "No identity can be read from the badge.")
    if identity.beats_agree is False:
        text = "The badge's code is that of one badge, and the fringes of its rows are those of another."
        return None, Reason("beats", "fail", read, None, "", text)
    if identity.beats_agree is None:
        text = "The badge's code can be read, but no row's fringes are clear enough to confirm it."
        return read, Reason("beats", "undecided", read, None, "", text)
    for reason in identity.reasons:
        if reason.code == "cells_move" and reason.level != "pass":
            return None, reason
    return read, Reason("enrolled", "pass", read, None, "", "The badge's code is that of an enrolled badge.")
