"""The payload of a badge: given, or derived from the name.

A derived payload gives the same badge for the same name, byte for byte.  It is not secret: everyone who knows a name
can print its pattern, and only a registry knows which badge was issued.  `attempt` chooses the next payload where a
registry has given the first one to somebody else.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from moireid.designer.request import clean_name
from moireid.errors import CodeError, SpecError

#: Payload bytes of each code family, the usual one first.
KEY_FILE_LIMIT = 65536
FAMILY_BYTES = {"spacing": (8, 16), "pitch": (3,)}


def payload_for_name(name: str, *, attempt: int = 0, family: str = "spacing") -> bytes:
    """Derive a payload from a name: the same name gives the same badge.

    Parameters
    ----------
    name : str
        In any Unicode form, with or without space around it.
    attempt : int
        Counts on where a registry has given the first choice to somebody else.
    family : {"spacing", "pitch"}
        The code family, which sets the length.

    Returns
    -------
    bytes
        8 bytes for the spacing family, 3 for the pitch family.

    Raises
    ------
    SpecError
        Where the name is empty, too long, or holds control characters.

    Notes
    -----
    Convention: this is no secret.  Whoever knows the name can derive it; only a registry says which badge was issued.
    Source: the first bytes of SHA-256 over family, attempt and the name in Unicode NFC.
    """
    seed = f"moireid/{family}/{attempt}/{clean_name(name)}"
    return hashlib.sha256(seed.encode()).digest()[: FAMILY_BYTES[family][0]]


def payload_from_hex(text: str, *, family: str = "spacing") -> bytes:
    """Read a payload from hex digits.

    Parameters
    ----------
    text : str
        16 or 32 digits for the spacing family, 6 for the pitch family; of any case, without spaces.
    family : {"spacing", "pitch"}
        The code family.

    Returns
    -------
    bytes
        8 or 16 bytes, or 3.

    Raises
    ------
    CodeError
        Where the text is not so many hex digits.

    Notes
    -----
    Convention: the first two digits are the first byte.
    Source: `moireid.designer.payload.FAMILY_BYTES`.
    """
    allowed = [2 * count for count in FAMILY_BYTES[family]]
    try:
        payload = bytes.fromhex(text) if len(text) in allowed else b""
    except ValueError:
        payload = b""
    # bytes.fromhex lets spaces pass, which would make a shorter payload.
    if 2 * len(payload) not in allowed:
        digits = " or ".join(map(str, allowed))
        raise CodeError(
            f"payload {text[:40]!r} is not possible; the {family} code takes {digits} hex digits such as "
            f"{hashlib.sha256(b'example').hexdigest()[: allowed[0]]}"
        )
    return payload


def payload_from_key(path: Path) -> bytes:
    """Make the fingerprint of a public key a payload, so that the badge names its key.

    Parameters
    ----------
    path : Path
        A public key in PEM.

    Returns
    -------
    bytes
        16 bytes.

    Raises
    ------
    SpecError
        Where the file is no public key in PEM.

    Notes
    -----
    Convention: only the spacing family carries so many bytes.
    Source: first 16 bytes of SHA-256 over the key's DER SubjectPublicKeyInfo (RFC 5280, section 4.1).
    """
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat, load_pem_public_key

    try:
        if not path.is_file():
            raise ValueError("no file")
        with path.open("rb") as stream:
            key = load_pem_public_key(stream.read(KEY_FILE_LIMIT))
    except (OSError, ValueError) as error:
        raise SpecError(f"{path} is no public key in PEM; make one with: openssl pkey -in KEY.pem -pubout") from error
    return hashlib.sha256(key.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)).digest()[:16]
