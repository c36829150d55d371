"""The verdict as content credentials (C2PA).

All reading and writing of films is done by c2pa-python in a process that never has the key: it asks for the signature
of the one claim that it makes.
Convention: the assertion `credentials_work.LABEL` holds the report, as `statement.attested` gives it.
"""

from __future__ import annotations

import base64
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from securesystemslib.signer import CryptoSigner

from moireid.attest.apart import talk_with
from moireid.attest.credentials_work import Asked
from moireid.attest.keys import SigningKey, certificate_pem, holder
from moireid.errors import MediaError, MissingExtraError, SpecError
from moireid.files import whole_file

Form = Literal["sidecar", "embed"]
#: How COSE begins what is signed (RFC 9052, 4.4): an array of four, the first of which is this text.
TO_BE_SIGNED = b"\x84\x6aSignature1"
#: States of credentials that hold, by c2pa.
SOUND = ("Valid", "Trusted")
UNTRUSTED = (
    "the certificate of {holder!r} is on no trust list that is known here. Programs will say that its signer is "
    "unknown: whoever has that key signed this verdict, and its issuer alone can say who that is"
)


def credentials_path(film: Path, form: Form) -> Path:
    """Where credentials are written: beside the film, and never over it."""
    return film.with_suffix(".c2pa") if form == "sidecar" else film.with_name(f"{film.stem}.c2pa{film.suffix}")


def check_credentials_key(key: SigningKey) -> None:
    """Raise where a key cannot sign content credentials.

    Raises: MissingExtraError without c2pa-python; SpecError where the key has no certificate of an authority.
    """
    if find_spec("c2pa") is None:
        raise MissingExtraError("content credentials need c2pa-python; install it with: pip install 'moireid[c2pa]'")
    if not key.chain or key.chain[0].issuer == key.chain[0].subject:
        raise SpecError(
            "content credentials need a certificate that an authority issued for the key of --sign; append it, and "
            "those above it, to that file"
        )


def write_credentials(report: dict[str, Any], film: Path, form: Form, key: SigningKey) -> str:
    """Write a report as content credentials, and read them back.

    Parameters: report: as `statement.attested` gives it; key: `check_credentials_key` lets it pass.
    Returns: what a reader will make of the certificate, in words.
    Raises: MediaError where they cannot be written, or do not hold when they are read again; nothing is left then.
    """
    signer, found = CryptoSigner(key.private), dict[str, Any]()
    algorithm = "ED25519" if isinstance(key.private, Ed25519PrivateKey) else "ES256"
    chain = "".join(certificate_pem(one) for one in key.chain)

    def answer(told: dict[str, Any]) -> bytes | None:
        if "sign" not in told:
            found.update(told)
            return None
        claim = base64.b64decode(told["sign"])
        if not claim.startswith(TO_BE_SIGNED):
            # A process in a stranger's hands could ask for a signature under a verdict of its own.
            raise MediaError(f"the process that read {film} asks for another signature than one of its credentials")
        return bytes.fromhex(signer.sign(claim).signature)

    with whole_file(credentials_path(film, form)) as output:
        asked = Asked(film, output, form, report, algorithm, chain)
        talk_with("moireid.attest.credentials_work:write", asked, film, answer, [output])
        if found.get("state") not in SOUND or found.get("verdict") != report:
            raise MediaError(f"the content credentials of {film} do not hold when they are read again; none are kept")
    trusted = found["state"] == "Trusted"
    return "the certificate is trusted" if trusted else UNTRUSTED.format(holder=holder(key.chain[0]))
