"""Recognises badges whose identity was made from the name, as early versions did, and not drawn at random.

Such an identity is no secret: anyone who knows the name can print the badge byte for byte, without its file.
"""

from __future__ import annotations

import hashlib
import unicodedata

from moireid.badge import Badge

#: Payload bytes of each code family that were derived; 16 bytes never were.
DERIVED_BYTES = {"spacing": 8, "pitch": 3}
#: A name's next identity was tried where a registry had given the one before to another person.
ATTEMPTS = 64


def is_name_derived(badge: Badge) -> bool:
    """Check whether a badge's identity was made from its name.

    Parameters
    ----------
    badge : Badge
        As its file or the registry has it.

    Returns
    -------
    bool
        False for a board without an identity.

    Notes
    -----
    Convention: the name in Unicode NFC without surrounding space.  By chance an identity of 64 bits is taken for one in
    3e17 badges, and one of the pitch family's 24 bits in 260,000.
    Source: the derivation of early versions, with every attempt that they made.
    """
    families = {grating.family for grating in badge.gratings if grating.code}
    name = unicodedata.normalize("NFC", badge.name).strip()
    return badge.id is not None and any(
        badge.id == _derived(name, attempt, family).hex()
        for family in families & DERIVED_BYTES.keys()
        for attempt in range(ATTEMPTS)
    )


def _derived(name: str, attempt: int, family: str) -> bytes:
    """Source: the first bytes of SHA-256 over family, attempt and name."""
    return hashlib.sha256(f"moireid/{family}/{attempt}/{name}".encode()).digest()[: DERIVED_BYTES[family]]
