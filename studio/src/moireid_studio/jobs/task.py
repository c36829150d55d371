"""A piece of work that a process is given, and what that process may ask of the registry.

It loads none of the packages that the work needs, so that the server does not pay for them.  The process may be in a
stranger's hands: it gets an answer to two questions, and never the registry.  The name in a result is the server's own
word (`with_name`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid.badge import Lens
from moireid.lenticule import ViewLaw
from moireid.registry import People

#: The signals of a film that was verified, in the folder of its job.
SIGNALS = "signals.csv"
#: What was made of an order, there too.
PACKAGE = "package.zip"
#: In the archive of an order: one badge as JSON; or a list of people.
ORDER, PEOPLE = "order.json", "people.csv"
#: A lens, a pitch (mm) and their law.
Law = tuple[Lens, float, ViewLaw]
#: Callbacks: how far a job is (done, of how many); a message to the server; a question that the server answers.
Progress = Callable[[int, int | None], None]
Send = Callable[[dict[str, Any]], None]
Ask = Callable[[dict[str, Any]], Any]


@dataclass(frozen=True)
class Task:
    """What to do (a key of `work.WORK`, or of `issue_work.WORK`), with the film of that name in its folder."""

    kind: str
    folder: Path
    video: str
    arguments: dict[str, Any] = field(default_factory=dict)


_ID, _PART = re.compile("[0-9a-f]{1,64}"), re.compile("[0-9a-f]{4}")
PLACES = ("0", "1", "2", "3")
#: An honest film asks, for each layout: is the id that was read enrolled?  Or: which ids are alike, and is the one that
#: agrees enrolled (`verifier.session.identify`).  More questions would list the registry's ids.
MOST_OF_A_LAYOUT = 2


def answer_to(question: object, people: People | None) -> object:
    """The answer to `holds` (an id) or `alike` (parts by their place); an empty one to anything else.

    Raises: RegistryError where the registry fails.
    """
    asked = question if isinstance(question, dict) and people is not None else {}
    badge_id, parts = asked.get("holds"), asked.get("alike")
    if people is not None and isinstance(badge_id, str) and _ID.fullmatch(badge_id):
        return people.holds(badge_id)
    if people is not None and isinstance(parts, dict):
        right = {
            int(place): part
            for place, part in parts.items()
            if place in PLACES and isinstance(part, str) and _PART.fullmatch(part)
        }
        return people.alike(right)
    return []


def with_name(result: dict[str, Any], people: People) -> dict[str, Any]:
    """A result of identification with the name of the one who was found.  Raises: RegistryError."""
    found = result.get("found_id")
    return result | {"found_name": people.name(found) if isinstance(found, str) else None}
