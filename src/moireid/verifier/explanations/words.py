"""What the fringes do by each explanation, in words; the only place where they are written.

Findings ("fringes that …"), headlines ("they …") and the table ("the fringes would …") end with the same words.  A
film's own figures are put in where they are known.

Convention: a verb in the plural, without its subject; a remedy is an order to the person who films.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

#: Parameters of an explanation by name, as in a report; a figure that is not known is None or missing.
Parameters = Mapping[str, float | None]


@dataclass(frozen=True)
class Words:
    """What the fringes do, and what would exclude that; "" for the law."""

    does: str
    remedy: str = ""


WORDS = {
    "law": Words("follow the law of optics, with errors that every film has"),
    "still": Words("stay still while the badge moves", "move the badge or the camera sideways"),
    "drift": Words("drift at a constant speed", "move to and fro instead of steadily one way"),
    "late": Words("come late or early", "change speed and direction more often"),
    "place": Words("go with the badge's place in the picture", "turn the badge as well, or walk around it"),
    "another_gain": Words("move too far, not far enough, or the wrong way", "film with more motion, or from nearer"),
    "own_motion": Words("move by themselves", "film from nearer, for longer, with more motion"),
    "spell": Words("leave the law for a while", "film the badge throughout, in even light"),
}
#: Ranges of the motion over the expected one that have words of their own.
SHARES = ((-0.12, 0.12, "hardly move where"), (0.45, 0.55, "move half as far as"), (1.9, 2.1, "move twice as far as"))


def does(name: str, parameters: Parameters) -> str:
    """What the fringes do by an explanation, with the parameters that fit a film best."""
    late_s, gain, start_s, end_s, share = (
        parameters.get(one) for one in ("late_s", "gain", "start_s", "end_s", "motion_share")
    )
    words = WORDS[name].does if name in WORDS else name.replace("_", " ")
    if name == "late" and late_s:
        return f"come {abs(late_s):.2g} s {'late' if late_s > 0 else 'early'}"
    if name == "another_gain" and gain is not None:
        return how_far(gain)
    if name == "spell" and start_s is not None and end_s is not None:
        return f"leave the law from {start_s:.1f} to {end_s:.1f} s"
    if share is not None:
        size = f"by {100 * share:.0f} % of" if share < 1 else f"by {share:.1f} times"
        when = "" if start_s is None or end_s is None else f", most from {start_s:.1f} to {end_s:.1f} s"
        return f"differ from the law ({size} its motion{when})"
    return words


def how_far(gain: float) -> str:
    """How far the fringes move, over what is expected."""
    named = next((words for low, high, words in SHARES if low <= gain <= high), None)
    if named is None:
        named = "go the other way than" if gain < 0 else f"move {'only ' if gain < 1 else ''}{gain:.2g} times as far as"
    return f"{named} they should"
