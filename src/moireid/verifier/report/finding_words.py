"""The findings of a report in the order in which people need them: failures, what is inconclusive, warnings, passes.

For each code that can make a film inconclusive: the reason in a few words, and what to do next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from moireid.verifier.explanations.words import WORDS, Parameters, does

#: One finding, as in the JSON of a report.
Finding = Mapping[str, Any]
#: The most important codes come first; all others follow in the order in which they were found.
WEIGHTIEST = (
    "revoked",
    *("name", "identities", "identity", "beats", "enrolled", "genuine", "built", "cells_move"),
    # Rivals of the law that name a motion of the fringes; the last but one only says that they move otherwise.
    *("explanations", "still", "drift", "late", "place", "another_gain", "own_motion", "spell"),
    *("gain", "parts", "residual", "spacing"),
)
#: A cause that makes other findings inconclusive comes before them.
CAUSES = (
    *("tracks", "damaged", "badge_absent", "fringes", "page_scale", "lens"),
    *("camera", "mixed_frames", "small", "covered"),
    *("motion_gaps", "motion"),
)
#: Notes that warn; all others are for experts.
WARNINGS = (
    *("claim_source", "look_alike", "hidden_letters", "copyable"),
    *("as_built_earlier", "others", "times", "covered", "pose_outliers", "challenge", "tracks", "damaged"),
)


@dataclass(frozen=True)
class Findings:
    """Findings by their meaning: they fail, make the film inconclusive, warn, or hold; the rest is for experts."""

    fail: tuple[Finding, ...]
    open: tuple[Finding, ...]
    warn: tuple[Finding, ...]
    hold: tuple[Finding, ...]
    rest: tuple[Finding, ...]

    @property
    def first(self) -> tuple[Finding, ...]:
        """What is shown unfolded, failures first."""
        return self.fail + self.open + self.warn

    @property
    def failed(self) -> dict[str, Finding]:
        """The first failure of each code."""
        return {finding["code"]: finding for finding in reversed(self.fail)}


def sorted_findings(reasons: Sequence[Finding]) -> Findings:
    """Sort the findings of a report, as in its JSON."""

    def of(*levels: str) -> list[Finding]:
        order = CAUSES + WEIGHTIEST if levels == ("undecided",) else WEIGHTIEST
        return sorted((one for one in reasons if one["level"] in levels), key=lambda one: _rank(one["code"], order))

    notes = of("note")
    return Findings(
        tuple(of("fail")),
        tuple(of("undecided")),
        tuple(note for note in notes if note["code"] in WARNINGS),
        tuple(of("pass")),
        tuple(note for note in notes if note["code"] not in WARNINGS),
    )


def _rank(code: str, order: Sequence[str]) -> int:
    return order.index(code) if code in order else len(order)


NEARER = "Ask for another film: the whole badge from nearer, in even light, moved sideways several times."
ORIGINAL = "Ask for the file as the camera made it, or for another film with such functions switched off."
MOVE = "Ask for another film in which badge or camera moves sideways by 20 cm or more, several times."
SHOW = (
    "Begin again: hold the badge with its four corner markers, or its frame, in the picture, near the face, in good "
    "light."
)


#: Why a film is inconclusive, for the headline, and a sentence on what to do.
Reason = tuple[str, str]
GENERAL = ("the film shows too little", NEARER)
#: Rivals of the law that may remain.
RIVALS = {name: words for name, words in WORDS.items() if words.remedy}
#: Too few frames show the badge: because none does, or because the film has too few.
NO_BADGE = (
    "no badge was found in the film",
    "Ask for a film that shows the whole badge with its four corner markers or its frame, near and in even light. "
    "Check too that it is a badge of the kind that was claimed.",
)
TOO_SHORT = (
    "the film is too short",
    "Ask for a longer film, of ten seconds or more, in which badge or camera moves sideways several times.",
)
OPEN: dict[str, Reason] = {
    "badge_absent": (
        "the badge can hardly be seen",
        "Ask for another film that shows the whole badge throughout, from nearer, in even light.",
    ),
    "fringes": ("no fringes could be read", NEARER),
    "motion": ("the badge hardly moved", MOVE),
    "motion_gaps": (
        "the badge moved only where pictures are missing",
        "Ask for another film in one piece; in a call, for a faster connection.",
    ),
    "gain": (
        "how far the fringes move does not decide it",
        "The issuer of the badge can enroll it with a film of it; then it is known how far its fringes move.",
    ),
    "lens": (
        "the film does not show which lens took it",
        "State the camera's lens, or ask for another film with the badge tilted by 15 to 25 degrees.",
    ),
    "page_scale": (
        "the badge's page or its lens sheet is off its size",
        "Measure the bars on the page and the pitch of the sheet, and print the page at 100 %.",
    ),
    "residual": ("the fringes leave the law, perhaps by errors of the film", NEARER),
    "parts": ("parts of the badge do not quite agree", NEARER),
    "spacing": ("the fringes do not follow the distance, as after a zoom", ORIGINAL),
    "third_harmonic": (
        "the fringes look soft, and the page does not",
        "Ask for another film from nearer. A sheet that does not lie flat makes soft fringes.",
    ),
    "cross_fade": (
        "the fringes change as those of a few photographs do",
        "Ask for another film in even light, in which the badge keeps moving.",
    ),
    "focal": ("the picture looks stretched or cut out", ORIGINAL),
    "camera": ("the picture may have been zoomed, reframed or stabilised", ORIGINAL),
    "mixed_frames": ("frames are mixed with their neighbours", ORIGINAL),
    "small": ("the badge is too small in the picture", NEARER),
    "covered": ("something covers the badge", "Ask for another film in which no hand, caption or glare covers it."),
    "pose_outliers": ("the badge does not look flat in too many frames", NEARER),
    "tracks": (
        "players may show other pictures than those judged",
        "Ask for the film with one video track, without crops, edit lists and subtitles; or say which track is meant.",
    ),
    "damaged": ("too many pictures are damaged", ORIGINAL),
    "flicker": (
        "the badge is missing in too many frames",
        "Ask for another film, in better light and with slower moves, that shows the badge in every frame.",
    ),
    "unsearched": (
        "the badge may have been in view where the film was not searched",
        "Ask for another film, before a plainer background, that shows the badge throughout.",
    ),
    "cover": (
        "the badge is judged in too few of the film's seconds",
        "Look at the bar of seconds: judge only those, or ask for a film that shows the badge throughout.",
    ),
    "corners": ("the badge's markers are hidden", NEARER),
    "piece": ("the film is in pieces that are too short", "Check the pieces one by one, or ask for a longer film."),
    "identity": ("whose badge it is cannot be read", NEARER),
    "beats": ("the badge's code could not be confirmed", NEARER),
    "cells_move": ("the badge's code does not quite move with its rows", NEARER),
    "built": (
        "it may be a copy that was built anew",
        "Ask for another film, from nearer and with more motion; or do not ask for the figures of enrolment.",
    ),
    "others_break": (
        "another badge in the film breaks the law",
        "Look at both badges, or ask for a film of one: the finding says where or when.",
    ),
    "layout": ("one kind of badge in the registry cannot be checked", "Inform the operator of the registry."),
    "level": (
        "less is shown than was asked for",
        "Ask the person for a live check with prompts, or enroll the badge with a film of it: the finding says which.",
    ),
    "face": ("no face was found", "Ask for another film with the face from the front, well lit."),
    "overlap": ("the badge is not before the face long enough", "Ask that it be held across the face for 2 s."),
    "overlap_law": ("the badge before the face cannot be read", NEARER),
    "challenge": ("the challenge was not finished", SHOW),
    "prompt": ("a prompt could not be judged", SHOW),
    "unbroken": ("the badge, or the picture, was lost during the moves", SHOW),
    "window_correlation": ("nothing moved", MOVE),
}


def words_of(finding: Finding, frames_read: int | None = None, parameters: Parameters | None = None) -> Reason:
    """Why an undecided finding makes a film inconclusive, and what to do.

    Parameters: frames_read: of the film, None where that is not known; parameters: of a rival, as in the table.
    """
    code = finding["code"]
    if code == "badge_absent" and finding["measured"] == 0:
        return NO_BADGE
    if code == "badge_absent" and frames_read is not None and frames_read < (finding["limit"] or 0):
        return TOO_SHORT
    if code not in RIVALS:
        return OPEN.get(code, GENERAL)
    advice = f"Ask for another film; to exclude such fringes, {RIVALS[code].remedy}."
    if finding["unit"] == "log10":
        return (f"fringes that {does(code, parameters or {})} would explain it better", advice)
    return (f"fringes that {RIVALS[code].does} would look the same", advice)


def first_open(findings: Sequence[Finding]) -> Finding | None:
    """The undecided finding that is named: the first; of several rivals, the likeliest."""
    first = next(iter(findings), None)
    if first is None or first["code"] not in RIVALS:
        return first
    remaining = [one for one in findings if one["code"] in RIVALS]
    better = [one for one in remaining if one["unit"] == "log10"]
    if better:
        return min(better, key=lambda one: float(one["measured"]))
    return max(remaining, key=lambda one: float(one["measured"]))
