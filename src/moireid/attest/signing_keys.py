"""Keys: private ones with their certificates, public ones, and how they are named to people.

Ed25519 or ECDSA on P-256, as PEM.  A private key's file may also hold its certificate, followed by those of the
authorities above, each by the issuer of the one before.
Convention: a key's fingerprint is the SHA-256 of its SubjectPublicKeyInfo (DER), 64 hex digits.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TypeGuard

from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric.ec import (
    SECP256R1,
    EllipticCurvePrivateKey,
    EllipticCurvePublicKey,
)
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey
from cryptography.x509.oid import NameOID

from moireid.errors import SpecError
from moireid.files import read_regular

PublicKey = Ed25519PublicKey | EllipticCurvePublicKey
PrivateKey = Ed25519PrivateKey | EllipticCurvePrivateKey

#: Largest file of keys, bytes; chains of certificates have a tenth of it.
MOST_BYTES = 1 << 20
MAKE_ONE = "make one with: openssl genpkey -algorithm ed25519 -out key.pem"
PRIVATE = re.compile(rb"-----BEGIN ((?:EC |ENCRYPTED )?PRIVATE KEY)-----.*?-----END \1-----", re.DOTALL)
CERTIFICATE = re.compile(rb"-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", re.DOTALL)


@dataclass(frozen=True)
class SigningKey:
    """A private key, and the certificates that name its holder.

    Attributes
    ----------
    private : Ed25519PrivateKey or EllipticCurvePrivateKey
        On P-256 in the second case.
    chain : tuple of x509.Certificate
        The key's own certificate first, then those above it; empty where there is none.
    """

    private: PrivateKey
    chain: tuple[x509.Certificate, ...] = ()

    @property
    def public(self) -> PublicKey:
        """The public half."""
        return self.private.public_key()


def load_signing_key(path: Path) -> SigningKey:
    """Read a private key, with its certificates if the file has any.

    Parameters
    ----------
    path : Path
        A PEM file: one private key, unencrypted, and certificates.

    Returns
    -------
    SigningKey
        Its chain begins with the key's own certificate.

    Raises
    ------
    SpecError
        The file cannot be read, holds no such key, or the key's own certificate is missing, out of date or broken.
    """
    content = _content(path)
    blocks = [found[0] for found in PRIVATE.finditer(content)]
    if len(blocks) != 1:
        held = "no private key" if not blocks else f"{len(blocks)} private keys"
        raise SpecError(f"{path} holds {held}, and one is needed, as PEM; {MAKE_ONE}")
    try:
        private = serialization.load_pem_private_key(blocks[0], password=None)
    except TypeError as error:
        raise SpecError(
            f"the private key in {path} is encrypted; write an open copy with: openssl pkey -in FILE -out key.pem"
        ) from error
    except (ValueError, UnsupportedAlgorithm) as error:
        raise SpecError(f"the private key in {path} cannot be read; {MAKE_ONE}") from error
    if not isinstance(private, PrivateKey) or not is_known(private.public_key()):
        raise SpecError(f"the private key in {path} is neither Ed25519 nor ECDSA on P-256; {MAKE_ONE}")
    return SigningKey(private, _own_chain(path, content, private.public_key()))


def load_public_key(path: Path) -> PublicKey:
    """Read a public key, or the public key of a certificate.

    Parameters
    ----------
    path : Path
        A PEM file; of a chain of certificates the first one counts.

    Returns
    -------
    PublicKey
        Ed25519, or ECDSA on P-256.

    Raises
    ------
    SpecError
        The file cannot be read, or holds no such key.
    """
    content = _content(path)
    try:
        certificates = _certificates(content)
        key = certificates[0].public_key() if certificates else serialization.load_pem_public_key(content)
    except (ValueError, UnsupportedAlgorithm) as error:
        raise SpecError(
            f"{path} holds no public key as PEM; write it from the private one: openssl pkey -in key.pem -pubout"
        ) from error
    if not is_known(key):
        raise SpecError(f"the public key in {path} is neither Ed25519 nor ECDSA on P-256; give the signer's own")
    return key


def load_certificates(path: Path) -> tuple[x509.Certificate, ...]:
    """The certificates of a PEM file.  Raises: SpecError where it cannot be read or holds none."""
    try:
        found = _certificates(_content(path))
    except ValueError as error:
        raise SpecError(f"a certificate in {path} cannot be read; give it as PEM") from error
    if not found:
        raise SpecError(f"{path} holds no certificate as PEM; give the authority's own")
    return found


def is_known(key: object) -> TypeGuard[PublicKey]:
    """Whether something is a public key of a kind that signs verdicts."""
    if isinstance(key, EllipticCurvePublicKey):
        return isinstance(key.curve, SECP256R1)
    return isinstance(key, Ed25519PublicKey)


def algorithm(key: PublicKey) -> str:
    """A key's algorithm, for people."""
    return "Ed25519" if isinstance(key, Ed25519PublicKey) else "ECDSA on P-256"


def public_pem(key: PublicKey) -> str:
    """A public key as PEM text."""
    return key.public_bytes(serialization.Encoding.PEM, serialization.PublicFormat.SubjectPublicKeyInfo).decode()


def certificate_pem(certificate: x509.Certificate) -> str:
    """A certificate as PEM text."""
    return certificate.public_bytes(serialization.Encoding.PEM).decode()


def fingerprint(key: PublicKey) -> str:
    """A key's name: SHA-256 of its SubjectPublicKeyInfo, 64 hex digits."""
    content = key.public_bytes(serialization.Encoding.DER, serialization.PublicFormat.SubjectPublicKeyInfo)
    return hashlib.sha256(content).hexdigest()


def certificate_digest(certificate: x509.Certificate) -> str:
    """SHA-256 of a certificate (DER), 64 hex digits."""
    return hashlib.sha256(certificate.public_bytes(serialization.Encoding.DER)).hexdigest()


def holder(certificate: x509.Certificate) -> str:
    """The holder that a certificate names, as its issuer states it."""
    parts = map(certificate.subject.get_attributes_for_oid, (NameOID.COMMON_NAME, NameOID.ORGANIZATION_NAME))
    words = [str(found[0].value) for found in parts if found]
    return ", ".join(dict.fromkeys(words)) or "nobody"


def fingerprint_of(certificate: x509.Certificate) -> str | None:
    """The fingerprint of a certificate's key; None where it is of a kind that signs no verdicts."""
    try:
        key = certificate.public_key()
    except (ValueError, UnsupportedAlgorithm):
        return None
    return fingerprint(key) if is_known(key) else None


def _own_chain(path: Path, content: bytes, key: PublicKey) -> tuple[x509.Certificate, ...]:
    """The certificates of a private key's file, the key's own first, then each one's issuer."""
    try:
        chain = _certificates(content)
    except ValueError as error:
        raise SpecError(f"a certificate in {path} cannot be read; give it as PEM, or leave it out") from error
    if chain and fingerprint_of(chain[0]) != fingerprint(key):
        raise SpecError(
            f"the first certificate in {path} is of another key; put the key's own there, then its issuer's"
        )
    return chain


def _content(path: Path) -> bytes:
    try:
        return read_regular(path, MOST_BYTES)
    except OSError as error:
        raise SpecError(f"key file {path} cannot be read ({error.strerror}); check its name and rights") from error


def _certificates(content: bytes) -> tuple[x509.Certificate, ...]:
    return tuple(x509.load_pem_x509_certificate(found[0]) for found in CERTIFICATE.finditer(content))
