"""Time stamps: an authority's statement that a signature existed at some moment (RFC 3161).

Convention: what is stamped is the signature's bytes.  A stamp is trusted only if its authority is known: the checker
must give the authority's root certificate, as anyone can run an authority with a clock of their own.
Source: RFC 3161, by rfc3161-client.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from datetime import datetime
from urllib.error import URLError
from urllib.request import Request, urlopen

from cryptography import x509
from rfc3161_client import (
    PKIStatus,
    TimestampRequestBuilder,
    TimeStampResponse,
    VerificationError,
    VerifierBuilder,
    decode_timestamp_response,
)

from moireid.errors import SpecError

#: Longest answer that is read, bytes, and longest wait for it, s.
MOST_BYTES, WAIT_S = 1 << 20, 30.0
IMPRINTS = {"2.16.840.1.101.3.4.2.1": "sha256", "2.16.840.1.101.3.4.2.2": "sha384", "2.16.840.1.101.3.4.2.3": "sha512"}


@dataclass(frozen=True)
class Stamp:
    """A time stamp: its moment, and whether a known authority gave it."""

    at: datetime
    trusted: bool


def ask_for_stamp(url: str, content: bytes) -> bytes:
    """Have `content` stamped.  Returns: the authority's response (DER).

    Raises: SpecError where there is no answer, or none that stamps this content now.
    """
    if not url.startswith(("http://", "https://")):
        raise SpecError(f"time authority {url!r} is no address; give one such as https://timestamp.example/")
    request = TimestampRequestBuilder().data(content).nonce(nonce=True).cert_request(cert_request=True).build()
    headers = {"Content-Type": "application/timestamp-query", "Accept": "application/timestamp-reply"}
    try:
        with urlopen(Request(url, request.as_bytes(), headers), timeout=WAIT_S) as answer:
            given: bytes = answer.read(MOST_BYTES + 1)
    except (URLError, OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        raise SpecError(f"time authority {url} gives no time stamp ({reason}); try again, or name another") from error
    response = _decoded(given)
    if response is None or PKIStatus(response.status) != PKIStatus.GRANTED or not _is_of(response, content):
        raise SpecError(f"what time authority {url} answers is no time stamp of this signature; name another")
    if response.tst_info.nonce != request.nonce:
        raise SpecError(f"time authority {url} answers with the time stamp of another request; name another")
    return given


def read_stamp(given: bytes, content: bytes, authorities: tuple[x509.Certificate, ...]) -> Stamp | None:
    """A response read back; None where it does not stamp `content`, or not by one of the authorities.

    Parameters: authorities: trusted certificates, the root among them; if empty, the stamp is read but not trusted.
    """
    response = _decoded(given)
    if response is None or not _is_of(response, content):
        return None
    if not authorities:
        return Stamp(response.tst_info.gen_time, trusted=False)
    try:
        VerifierBuilder(roots=list(authorities)).build().verify_message(response, content)
    except (VerificationError, ValueError):
        return None
    return Stamp(response.tst_info.gen_time, trusted=True)


def _decoded(given: bytes) -> TimeStampResponse | None:
    if len(given) > MOST_BYTES:
        return None
    try:
        response = decode_timestamp_response(given)
        # A refusal holds no token, and says so only when it is looked at.
        _ = response.tst_info
    except ValueError:
        return None
    return response


def _is_of(response: TimeStampResponse, content: bytes) -> bool:
    imprint = response.tst_info.message_imprint
    name = IMPRINTS.get(imprint.hash_algorithm.dotted_string)
    return name is not None and hashlib.new(name, content).digest() == imprint.message
