"""The registry that a badge is issued in, and notes to the issuer about its name."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING

from moireid.errors import RegistryError

if TYPE_CHECKING:
    from moireid.badge import Badge
    from moireid.issuing import HolderOf
    from moireid.registry import Registry

#: At most this many entries of a list are named; the rest are counted.
NAMED = 5


@contextmanager
def known_holders(registry_url: str | None) -> Iterator[HolderOf | None]:
    """Who holds an identity in a registry as it is now, None without one; a registry that is absent has no one yet."""
    if registry_url is None:
        yield None
        return
    from moireid.registry import open_registry

    try:
        registry = open_registry(registry_url, create=False)
    except RegistryError:
        # What else is wrong with it is said when it is opened to issue the badge.
        yield lambda badge_id: None
        return
    with registry:
        yield registry.by_id


def opened(registry_url: str | None) -> AbstractContextManager[Registry | None]:
    """The registry that badges are issued in, made where it is absent; None without one."""
    if registry_url is None:
        return nullcontext()
    from moireid.registry import open_registry

    return open_registry(registry_url, create=True, actor=os.environ.get("MOIREID_ACTOR"))


def namesake_notes(badges: Sequence[Badge], registry: Registry) -> list[str]:
    """A sentence for each badge whose name is that of another badge that is enrolled."""
    notes = []
    for badge in badges:
        same = [one.id for one in registry.named(badge.name) if one.id != badge.id]
        if same:
            verb = "is" if len(same) == 1 else "are"
            notes.append(
                f"{_listed(same)} in the registry {verb} of {badge.name!r} too, so a claim must give the id; a name "
                "with their work would distinguish them"
            )
    return notes


def look_alike_notes(badges: Sequence[Badge], registry: Registry) -> list[str]:
    """A sentence for each name that looks like another one which is enrolled."""
    return [
        f"the name {name!r} looks like {_listed([f'{one.name} ({one.id})' for one in alike])}, who is enrolled, and is "
        "written in other letters or case"
        for name, alike in registry.look_alikes(badge.name for badge in badges).items()
    ]


def alike_in_list_notes(badges: Sequence[Badge]) -> list[str]:
    """A sentence for each name of a list that looks like another one in it."""
    from moireid.registry.look_alikes import alike_within

    return [
        f"the names {name!r} and {other!r} are both in the list, look alike, and are written in other letters or case"
        for name, other in alike_within(badge.name for badge in badges)
    ]


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return ", ".join(names[:NAMED]) + more
