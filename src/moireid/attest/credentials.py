"""The verdict on a film as content credentials (C2PA).

c2pa-python reads and writes films in processes that never have the key.  The first one writes, and
gets one signature, for the one claim that it makes.  The second one has received nothing from the first but the file,
and reads that back.
Convention: the assertion `credentials_work.LABEL` holds the report, as `statement.attested` gives it.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from securesystemslib.signer import CryptoSigner

from moireid.attest.credentials_work import CredentialRequest
from moireid.attest.signing_keys import SigningKey, certificate_pem, holder
from moireid.errors import MediaError, SpecError
from moireid.extras import missing_extra
from moireid.files import whole_file
from moireid.reading.film_reader import converse, limits_of
from moireid.sandbox.file_access import reach
from moireid.sandbox.process import start

Form = Literal["sidecar", "embed"]
#: Most that content credentials add to a film: a report, certificates and hashes of the film's parts.
REPORT_BYTES = 64 << 20
#: How COSE begins what is signed (RFC 9052, 4.4): an array of four, the first of which is this text.
TO_BE_SIGNED = b"\x84\x6aSignature1"
#: States of credentials that hold, by c2pa.
SOUND = ("Valid", "Trusted")
UNTRUSTED = (
    "the certificate of {holder!r} is on no trust list that is known here. Programs will say that its signer is "
    "unknown: the holder of that key signed this verdict, and its issuer alone can say who that is"
)


def talk_with(
    work: str,
    message: object,
    film: Path,
    answer: Callable[[dict[str, Any]], object],
    written: Sequence[Path] = (),
    read: Sequence[Path] = (),
) -> None:
    """Start a sealed process for some work on a film, and answer its messages until it has ended.

    Parameters: work: `module:function`; answer: returns what is sent back, None for nothing; written: existing files
        that it may write; read: files that it may read apart from the film.
    Raises: MoireIdError that the work raised; MediaError where the process fails, is silent, or takes too long.
    """
    if os.name == "nt":
        raise SpecError(
            "verdicts are not signed on Windows, as films cannot be judged apart from the key there; sign "
            "on Linux or macOS"
        )
    # The library copies the film, to add to it.
    most = film.stat().st_size + REPORT_BYTES if written and film.is_file() else 0
    limits, seconds = limits_of([film], written_bytes=most)
    child = start(work, limits, within=reach(read=[film, *read], write=written))
    try:
        converse(child, message, answer, [film], seconds)
    finally:
        child.kill()


def credentials_path(film: Path, form: Form) -> Path:
    """Where credentials are written: next to the film, and never over it."""
    return film.with_suffix(".c2pa") if form == "sidecar" else film.with_name(f"{film.stem}.c2pa{film.suffix}")


def check_credentials_key(key: SigningKey) -> None:
    """Check that a key can sign content credentials.

    Raises: MissingExtraError without c2pa-python; SpecError where the key has no certificate of an authority.
    """
    if find_spec("c2pa") is None:
        raise missing_extra("content credentials", "c2pa-python", "c2pa")
    if not key.chain or key.chain[0].issuer == key.chain[0].subject:
        raise SpecError(
            "content credentials need a certificate that an authority issued for the signing key; append it, and "
            "those above it, to the key's file"
        )


def write_credentials(report: dict[str, Any], film: Path, form: Form, key: SigningKey) -> str:
    """Write a report as content credentials, and read them back.

    Parameters: report: as `statement.attested` gives it; key: `check_credentials_key` lets it pass.
    Returns: what a reader will make of the certificate, in words.
    Raises: MediaError where they cannot be written, or do not hold when they are read again; nothing is left then.
    """
    found = dict[str, Any]()
    algorithm = "ED25519" if isinstance(key.private, Ed25519PrivateKey) else "ES256"
    chain = "".join(certificate_pem(one) for one in key.chain)

    with whole_file(credentials_path(film, form)) as output:
        asked = CredentialRequest(film, output, form, report, algorithm, chain)
        talk_with("moireid.attest.credentials_work:write", asked, film, _one_signature(film, key), [output])
        talk_with("moireid.attest.credentials_work:read_back", asked, film, found.update, read=[output])
        if found.get("state") not in SOUND or found.get("verdict") != report:
            raise MediaError(f"the content credentials of {film} do not hold when they are read again; none are kept")
    trusted = found["state"] == "Trusted"
    return "the certificate is trusted" if trusted else UNTRUSTED.format(holder=holder(key.chain[0]))


def _one_signature(film: Path, key: SigningKey) -> Callable[[dict[str, Any]], bytes | None]:
    """Signs the first claim that a process asks for.

    A process that an attacker controls could ask for a signature under a false verdict.  It gets one signature at most,
    and that is kept only if another process reads the true verdict in the signed file.
    """
    asked: list[object] = []

    def answer(message: dict[str, Any]) -> bytes | None:
        if "sign" not in message:
            return None
        asked.append(message["sign"])
        try:
            claim = base64.b64decode(message["sign"])
        except (TypeError, ValueError):
            claim = b""
        if len(asked) > 1 or not claim.startswith(TO_BE_SIGNED):
            raise MediaError(f"the process that read {film} asks for another signature than one of its credentials")
        return bytes.fromhex(CryptoSigner(key.private).sign(claim).signature)

    return answer
