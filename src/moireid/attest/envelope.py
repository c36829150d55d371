"""The signed statement as a DSSE envelope, made with one signature.

Next to the signature the envelope has the public key and its certificates.
These are not signed, so they prove nothing.  They allow a check without a key at hand.
Source: DSSE v1 (https://github.com/secure-systems-lab/dsse), by securesystemslib.
"""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import serialization
from securesystemslib.dsse import Envelope
from securesystemslib.exceptions import UnverifiedSignatureError, VerificationError
from securesystemslib.signer import CryptoSigner, Signature, SSlibKey

from moireid.attest.signing_keys import (
    PublicKey,
    SigningKey,
    certificate_pem,
    is_known,
    public_pem,
)
from moireid.errors import SpecError
from moireid.files import read_regular

PAYLOAD_TYPE = "application/vnd.in-toto+json"
#: Largest envelope, bytes: a hundred times the report of an hour of film.
MOST_BYTES = 16 << 20


class Broken(Exception):
    """An envelope does not hold: the part that is wrong, and a sentence.

    part: "envelope", "report", "signature", "key", "certificate", "identity", "film", "badge" or
    "registry".
    """

    def __init__(self, part: str, text: str) -> None:
        super().__init__(text)
        self.part, self.text = part, text


@dataclass(frozen=True)
class EnvelopeParts:
    """An envelope's parts, each well-formed; the signature is not checked yet.

    payload: the signed bytes; signature: over them; key: the public key next to it; certificates: the key's own, then
    those above.
    """

    payload: bytes
    signature: bytes
    key: PublicKey
    certificates: tuple[x509.Certificate, ...]

    def signed_by(self, key: PublicKey) -> bool:
        """Whether the signature is that key's over the payload."""
        wanted = SSlibKey.from_crypto(key)
        pae = Envelope(self.payload, PAYLOAD_TYPE, {}).pae()
        try:
            wanted.verify_signature(Signature(wanted.keyid, self.signature.hex()), pae)
        except (UnverifiedSignatureError, VerificationError):
            return False
        return True


def signed_envelope(payload: bytes, key: SigningKey) -> str:
    """Sign a statement.

    Parameters
    ----------
    payload : bytes
        The statement, as `statement.statement` gives it.
    key : SigningKey
        The private key; its public half and its certificates go into the envelope.

    Returns
    -------
    str
        The envelope as JSON.  Who writes it checks it.
    """
    envelope = Envelope(payload, PAYLOAD_TYPE, {})
    signature = envelope.sign(CryptoSigner(key.private))
    unsigned: dict[str, Any] = {
        "sig": base64.b64encode(bytes.fromhex(signature.signature)).decode(),
        "publicKey": public_pem(key.public),
        "certificates": [certificate_pem(one) for one in key.chain],
    }
    document = envelope.to_dict()
    document["signatures"][0] |= unsigned
    return json.dumps(document, indent=1) + "\n"


def read_envelope(path: Path) -> bytes:
    """An envelope's file.  Raises: SpecError where it cannot be read, or is too long for one."""
    try:
        return read_regular(path, MOST_BYTES)
    except OSError as error:
        raise SpecError(f"envelope {path} cannot be read ({error.strerror}); check its name and rights") from error


def opened(content: bytes) -> EnvelopeParts:
    """The parts of an envelope.  Raises: Broken where it is none."""
    try:
        document = json.loads(content)
        kind, (signature,) = document["payloadType"], document["signatures"]
        payload, signed = (base64.b64decode(one, validate=True) for one in (document["payload"], signature["sig"]))
        key = serialization.load_pem_public_key(signature["publicKey"].encode())
        certificates = tuple(x509.load_pem_x509_certificate(one.encode()) for one in signature.get("certificates", ()))
        named = signature["keyid"]
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError, UnsupportedAlgorithm) as error:
        raise Broken("envelope", "The file is no signed verdict, or was cut or changed.") from error
    if kind != PAYLOAD_TYPE:
        raise Broken("envelope", f"The envelope's payload type is not {PAYLOAD_TYPE}, so it holds no signed verdict.")
    if not is_known(key):
        raise Broken("signature", "The public key next to the signature is neither Ed25519 nor ECDSA on P-256.")
    if named != SSlibKey.from_crypto(key).keyid:
        raise Broken("signature", "The key's name next to the signature is not that of the key there.")
    return EnvelopeParts(payload, signed, key, certificates)
