"""The payload of a badge: given, or drawn at random.

Everyone who knows a payload can print its pattern.  So where none is given, the payload comes from the system's random
source alone: no name, no seed and no clock enters it.
"""

from __future__ import annotations

import hashlib
import secrets
from pathlib import Path

from moireid.errors import CodeError, SpecError

KEY_FILE_LIMIT = 65536
#: Payload bytes of each code family, the usual one first.
FAMILY_BYTES = {"spacing": (8, 16), "pitch": (3,)}


def random_payload(size_bytes: int = 8) -> bytes:
    """Draw an identity that no one can guess.

    Parameters
    ----------
    size_bytes : int
        8 or 16, or 3 for the pitch family's code.

    Returns
    -------
    bytes
        From the system's random source; no seed reproduces it.

    Raises
    ------
    CodeError
        Where no code family carries so many bytes.

    Notes
    -----
    Convention: `size_bytes` are whole bytes of a payload, as `FAMILY_BYTES` lists them.
    Source: `secrets.token_bytes`.
    """
    sizes = sorted(size for family in FAMILY_BYTES.values() for size in family)
    if size_bytes not in sizes:
        raise CodeError(f"a payload of {size_bytes!r} bytes is not possible; codes carry {', '.join(map(str, sizes))}")
    return secrets.token_bytes(size_bytes)


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
