"""The badge of one person: with a given identity, or with a random one that no one else holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from moireid.badge import Badge
from moireid.designer.design import design_badge
from moireid.designer.reach import link_budgets
from moireid.designer.request import FAMILY_BYTES, Request, random_payload
from moireid.errors import DesignError, RegistryError

#: Where half of all identities are issued, so many draws fail once in 1e19 times; of 64 bits the first is free.
DRAWS = 64
#: A long identity is taken where at both ends of the range it is read from so many of eight-second films.
LEAST_READ = 0.999


class KnownHolder(Protocol):
    """The holder of an identity: the fields of a registry's record that are needed here."""

    @property
    def name(self) -> str: ...
    @property
    def badge(self) -> Badge: ...
    @property
    def issued_at(self) -> str: ...
    @property
    def revoked_at(self) -> str | None: ...
    @property
    def revoked_reason(self) -> str | None: ...


HolderOf = Callable[[str], KnownHolder | None]


def no_holder(badge_id: str) -> None:
    """The holder of an identity in a registry that does not exist yet: none."""
    return


@dataclass(frozen=True)
class DrawnBadge:
    """A badge; who holds this very badge already; and a sentence where its identity is shorter than wished."""

    badge: Badge
    holder: KnownHolder | None = None
    note: str | None = None


def drawn_badge(request: Request, payload: bytes | None, holder_of: HolderOf | None) -> DrawnBadge:
    """The badge for the request: with `payload`, or with an identity from the system's random source.

    Parameters: holder_of: returns the holder of an id, None where it has none.  Without a registry to ask, 128 bits are
        drawn if board and range carry them, so that no two badges anywhere are alike; with one, 64 bits are enough.
    Raises: as `design_badge`; RegistryError where the payload was revoked, or no identity that was drawn is free.
    """
    if payload is not None:
        badge = design_badge(request, payload)
        return DrawnBadge(badge, _holder(badge, holder_of) if holder_of else None)
    sizes = FAMILY_BYTES[request.family or "spacing"]
    if holder_of is not None or len(sizes) == 1:
        return DrawnBadge(_free(request, sizes[0], holder_of))
    long = _long(request, sizes[1])
    if long is not None:
        return DrawnBadge(long)
    note = (
        f"a board of this size does not carry {8 * sizes[1]} bits over this range, so one of {8 * sizes[0]} bits was "
        "drawn; a registry (--registry) makes sure that no one else holds it"
    )
    return DrawnBadge(_free(request, sizes[0], None), note=note)


def _holder(badge: Badge, holder_of: HolderOf) -> KnownHolder | None:
    """The holder of this very badge.  Raises: RegistryError where its identity was revoked."""
    holder = holder_of(badge.id or "")
    if holder is not None and holder.revoked_at is not None:
        raise RegistryError(
            f"badge {badge.id} of {holder.name!r} was revoked ({holder.revoked_reason}); give another identity"
        )
    return holder if holder is not None and holder.badge == badge else None


def _free(request: Request, size_bytes: int, holder_of: HolderOf | None) -> Badge:
    for _ in range(DRAWS):
        payload = random_payload(size_bytes)
        if holder_of is None or holder_of(payload.hex()) is None:
            return design_badge(request, payload)
    raise RegistryError(
        f"{DRAWS} identities of {8 * size_bytes} bits were drawn, and all are issued already; use the spacing code"
    )


def _long(request: Request, size_bytes: int) -> Badge | None:
    """A badge of a long identity, None where board and range do not carry one."""
    try:
        badge = design_badge(request, random_payload(size_bytes))
    except DesignError:
        # If a short identity does not help either, its own design raises the error.
        return None
    return badge if all(link.decode_probability >= LEAST_READ for _, link in link_budgets(badge)) else None
