"""The signed statement as a DSSE envelope: made with one signature, and read strictly.

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
    certificate_of,
    certificate_pem,
    is_known,
    public_pem,
)
from moireid.attest.statement import strict_base64, strict_object
from moireid.errors import SpecError
from moireid.files import open_regular

PAYLOAD_TYPE = "application/vnd.in-toto+json"
#: Largest envelope, bytes: a hundred times the report of an hour of film.
MOST_BYTES = 16 << 20
#: Most certificates of a chain.
MOST_CERTIFICATES = 10


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
        The envelope as JSON, opened again and found sound.

    Raises
    ------
    SpecError
        What was made cannot be opened again.
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
    text = json.dumps(document, indent=1) + "\n"
    if not opened(text.encode()).signed_by(key.public):
        raise SpecError("the envelope that was made does not hold; that is an error of moireid, please report it")
    return text


def read_envelope(path: Path) -> bytes:
    """An envelope's file, as far as one may be long.  Raises: SpecError where it cannot be read."""
    try:
        with open_regular(path) as stream:
            return stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise SpecError(f"envelope {path} cannot be read ({error.strerror}); check its name and rights") from error


def opened(content: bytes) -> EnvelopeParts:
    """The parts of an envelope.  Raises: Broken where it is not spelled as one."""
    if len(content) > MOST_BYTES:
        raise Broken("envelope", f"The file is larger than {MOST_BYTES} bytes, and so no signed verdict of moireid.")
    try:
        document = strict_object(content)
    except ValueError as error:
        raise Broken("envelope", f"The file is no signed verdict: {error}.") from error
    if not isinstance(document.get("signatures"), list) or not {"payload", "payloadType"} <= document.keys():
        raise Broken("envelope", "The file is no signed verdict: it is not a DSSE envelope.")
    if document["payloadType"] != PAYLOAD_TYPE:
        raise Broken("envelope", f"The envelope's payload type is not {PAYLOAD_TYPE}, so it holds no signed verdict.")
    if len(document["signatures"]) != 1 or not isinstance(document["signatures"][0], dict):
        count = len(document["signatures"])
        raise Broken("envelope", f"The envelope holds {count} signatures, and a verdict has exactly one.")
    signature = document["signatures"][0]
    key = _key(signature.get("publicKey"))
    if signature.get("keyid") != SSlibKey.from_crypto(key).keyid:
        raise Broken("signature", "The key's name next to the signature is not that of the key there.")
    return EnvelopeParts(
        _decoded("report", document["payload"], "The report"),
        _decoded("signature", signature.get("sig"), "The signature"),
        key,
        _certificates(signature.get("certificates", [])),
    )


def _decoded(part: str, text: object, name: str) -> bytes:
    try:
        return strict_base64(text)
    except ValueError as error:
        raise Broken(part, f"{name} in the envelope was changed, or cut: {error}.") from error


def _key(text: object) -> PublicKey:
    """The key next to the signature; its text must be as `public_pem` writes it."""
    try:
        if not isinstance(text, str):
            raise ValueError("no text")
        key = serialization.load_pem_public_key(text.encode())
    except (ValueError, UnsupportedAlgorithm) as error:
        raise Broken("signature", "The public key next to the signature was changed, or is missing.") from error
    if not isinstance(key, PublicKey) or not is_known(key):
        raise Broken("signature", "The public key next to the signature is neither Ed25519 nor ECDSA on P-256.")
    return key


def _certificates(texts: object) -> tuple[x509.Certificate, ...]:
    if not isinstance(texts, list) or len(texts) > MOST_CERTIFICATES:
        raise Broken("certificate", f"The certificates are no list of up to {MOST_CERTIFICATES}.")
    try:
        return tuple(certificate_of(str(text)) for text in texts)
    except ValueError as error:
        raise Broken("certificate", "A certificate in the envelope was changed, or cut.") from error
