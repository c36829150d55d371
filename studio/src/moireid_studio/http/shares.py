"""Who may take how many of the places for films: a token leaves some to others, and verifiers leave some to issuers."""

from __future__ import annotations

from collections.abc import Iterable

from moireid_studio.settings import Limits
from moireid_studio.store.job import Held

#: Of all places: what one token may take, and what all verifiers together may.
OF_ONE, OF_VERIFIERS = 0.5, 0.75
#: An upload on its way takes no work yet, so a token may have fewer of them.
RECEIVED_OF_ONE = 0.25


def fits(held: Iterable[Held], owner: str, role: str, limits: Limits) -> bool:
    """Whether one more film of this token may come.

    A film on its way counts among `limits.uploads`, so a slow one takes no place in the queue from a film that is
    there.
    """
    every = list(held)
    queued = [one for one in every if not one.receiving]
    coming = [one for one in every if one.receiving]
    places = limits.workers + limits.waiting
    return _room(queued, owner, role, places, OF_ONE) and _room(coming, owner, role, limits.uploads, RECEIVED_OF_ONE)


def _room(held: list[Held], owner: str, role: str, places: int, of_one: float) -> bool:
    """Whether a place is left, of all, of the token's share, and of the verifiers' share."""
    all_of = sum(one.count for one in held)
    own = sum(one.count for one in held if one.owner == owner)
    verifiers = sum(one.count for one in held if one.role == "verifier")
    if all_of >= places or own >= max(int(places * of_one), 1):
        return False
    return role != "verifier" or verifiers < max(int(places * OF_VERIFIERS), 1)
