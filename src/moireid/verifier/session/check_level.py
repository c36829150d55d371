"""How much a check shows, in three levels, and the finding where less is shown than was asked for.

record    the film by itself agrees with the badge's design and the claimed identity
enrolled  its figures also are those measured at enrolment
live      a live check with prompts was passed: no film made before can show that

What a forger needs to pass each is the table "What it takes to pass" in THREATS.md.
"""

from __future__ import annotations

from typing import get_args

from moireid.question import CheckLevel
from moireid.verifier.reasons import Reason, Verdict

LEVELS: tuple[CheckLevel, ...] = get_args(CheckLevel)
#: What to do where a level is not reached.
MISSING: dict[CheckLevel, str] = {
    "record": "the film itself is not accepted",
    "enrolled": (
        "the film does not show the figures of an enrolment. Enroll the badge with a film of it, or film it nearer and "
        "with more motion"
    ),
    "live": (
        "a film made before shows no one who answers now. Make a live check with prompts, in the "
        "studio or by moireid watch"
    ),
}


def level_reached(verdict: Verdict, built: str, *, challenged: bool = False) -> CheckLevel | None:
    """The level that a check reached; None if it was not accepted.

    Parameters: verdict: of all findings but the one on the level; built: as `Identity.built`; challenged: whether
        prompts were answered.
    """
    if verdict != "accept":
        return None
    return "live" if challenged else "enrolled" if built == "agrees" else "record"


def level_finding(asked: CheckLevel | None, reached: CheckLevel | None, built: str) -> tuple[Reason, ...]:
    """A finding if more was asked for than was reached; a level that is always reached asks for nothing.

    Parameters: built: as in `level_reached`.  A live check of a printed copy does not reach what enrolment would show.
    """
    if asked in (None, "record"):
        return ()
    rank = -1 if reached is None else LEVELS.index(reached)
    if rank >= LEVELS.index(asked) and (asked == "live" or built == "agrees"):
        return (Reason("level", "pass", reached, asked, "", f"The level {reached!r} was asked for, and is reached."),)
    got = "none" if reached is None else repr(reached)
    text = f"The level {asked!r} was asked for, and {got} is reached: {MISSING[asked if rank >= 0 else 'record']}."
    return (Reason("level", "undecided", reached, asked, "", text),)
