"""What the process of a film that is to be identified may ask of the registry, and the server's own word in its result.

The process may be in a stranger's hands.  It gets an answer to these two questions, and never the registry.
"""

from __future__ import annotations

import re
from typing import Any

from moireid.registry import People

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
