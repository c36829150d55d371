"""A person's badge with an identity that nobody else has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from moireid.badge import Badge
from moireid.designer.design import design_badge
from moireid.designer.payload import payload_for_name
from moireid.designer.request import Request
from moireid.errors import RegistryError

#: So many identities are derived from a name, one after the other, until one is free.
ATTEMPTS = 64


class Holder(Protocol):
    """Who has an identity: the fields of a registry's record that are needed here."""

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


def free_badge(
    request: Request, payload: bytes | None, holder_of: Callable[[str], Holder | None]
) -> tuple[Badge, Holder | None]:
    """The badge for the request: with `payload`, or with the first free identity derived from the name.

    Parameters: holder_of: who holds an id, None where nobody does.
    Returns: the badge, and who holds this very badge already.
    Raises: as `design_badge`; RegistryError where the payload was revoked, or no derived identity is free.
    """
    if payload is not None:
        badge = design_badge(request, payload)
        holder = holder_of(badge.id or "")
        if holder is not None and holder.revoked_at is not None:
            raise RegistryError(
                f"badge {badge.id} of {holder.name!r} was revoked ({holder.revoked_reason}); give another --payload"
            )
        return badge, holder if holder is not None and holder.badge == badge else None
    for attempt in range(ATTEMPTS):
        family = request.family or "spacing"
        badge = design_badge(request, payload_for_name(request.name, attempt=attempt, family=family))
        holder = holder_of(badge.id or "")
        if holder is None:
            return badge, None
        if holder.badge == badge and holder.revoked_at is None:
            return badge, holder
    raise RegistryError(f"the first {ATTEMPTS} identities derived from {request.name!r} are all issued; give --payload")
