"""Where a claim comes from: a registry vouches for a name, a file vouches for nothing."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Literal

from moireid.names import name_with_line

Source = Literal["registry", "file", "bundle"]
#: Rounds of PBKDF2 behind a seal: each guess costs 0.4 ms of processor time, on any side.
SEAL_ROUNDS = 1000


@dataclass(frozen=True)
class Standing:
    """A registry as a check found it.

    fingerprint: of its authority, 32 hex digits; head: the end of its log, NUMBER:ROOT; expires: until when a
    bundle of it counts, None for the registry itself; new: nothing of this authority was seen before, and no one
    confirmed that it is the right one; remembered: this state could be kept, so that an earlier one will be noticed.
    """

    fingerprint: str
    head: str
    expires: str | None = None
    new: bool = False
    remembered: bool = True

    def to_json(self) -> dict[str, Any]:
        """As the `registry` object of `verify --json`."""
        return {"fingerprint": self.fingerprint, "head": self.head, "expires": self.expires}


@dataclass(frozen=True)
class Seal:
    """An identity that can be recognised but not read: a reader of a film can check that its identity is this one.

    salt: 16 bytes, drawn for this seal alone; digest: 32 bytes.
    Source: PBKDF2 with HMAC-SHA256 (RFC 8018, section 5.2) of the identity's bytes.
    """

    salt: bytes
    digest: bytes

    @classmethod
    def of(cls, badge_id: str, salt: bytes) -> Seal:
        """The seal of an identity, in hex digits."""
        return cls(salt, hashlib.pbkdf2_hmac("sha256", bytes.fromhex(badge_id), salt, SEAL_ROUNDS))

    def holds(self, badge_id: str) -> bool:
        """Whether it was made of this identity."""
        return Seal.of(badge_id, self.salt) == self


@dataclass(frozen=True)
class Provenance:
    """Where the claimed badge and its name come from.

    source: None where a program makes the claim by itself; "registry" where an authority signed them, "bundle" where it
    signed them in a bundle, "file" where a person handed them over; file_name: the name in such a file, where the
    registry holds its identity under another one; alike: name and id of enrolled people whose names are others and look
    like the claimed one; standing: of the registry, None where none was asked.
    """

    source: Source | None = None
    file_name: str | None = None
    alike: tuple[str, ...] = ()
    standing: Standing | None = None


#: Of a badge.json that a user supplies, and of a claim that a program makes by itself.
FROM_FILE, OWN_CLAIM = Provenance("file"), Provenance()


@dataclass(frozen=True)
class Revocation:
    """Why a badge does not count.

    at: since when, UTC, ISO 8601; reason: as the registry has it.
    """

    at: str
    reason: str

    @property
    def text(self) -> str:
        """In a sentence, of the claimed badge."""
        return f"The claimed badge was revoked: {self.reason}."


@dataclass(frozen=True)
class BadgeHolder:
    """Who holds a badge, as a registry says: the name, and the line below it.

    barred: why it does not count, None where it does; erased: the registry no longer knows the name.
    """

    name: str
    barred: Revocation | None = None
    line: str | None = None
    erased: bool = False

    @property
    def with_line(self) -> str:
        """The name and the line."""
        return name_with_line(self.name, self.line)
