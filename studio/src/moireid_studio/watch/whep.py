"""A WebRTC stream that is asked for by HTTP (WHEP).

We speak with the server; the judge receives the pictures, and never learns the token.
Source: draft-ietf-wish-whep: POST an offer, get an answer and the session's address, DELETE that at the end.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from urllib.parse import urljoin, urlsplit, urlunsplit

from moireid.errors import MediaError
from moireid_studio.watch.fetching import REDIRECTS, Addresses, origin_of
from moireid_studio.watch.source import Source

SDP = "application/sdp"
#: Longest description of a session, bytes; a sender with sound and picture needs some thousand.
MOST_SDP_BYTES = 1 << 16


class Asking:
    """One session with a server."""

    def __init__(self, source: Source, token: str | None) -> None:
        parts = urlsplit(source.text)
        scheme = {"whep": "http", "wheps": "https"}[parts.scheme.lower()]
        self._source, self._address = source, urlunsplit(parts._replace(scheme=scheme))
        self._addresses, self._token = Addresses(self._address), token
        self._session: str | None = None
        self._lock = threading.Lock()

    def ask(self, offer: str) -> str:
        """The server's answer to our offer.  Raises: MediaError where it gives none."""
        answer = self._request("POST", self._address, offer.encode(), {"Content-Type": SDP, "Accept": SDP})
        with self._lock:
            status, place, kind, body = answer
            if status != 201 or kind != SDP or len(body) > MOST_SDP_BYTES:
                raise MediaError(f"{self._source.shown} answers {status} to WHEP, and 201 with {SDP} is its yes")
            self._session = place
        return body.decode("utf-8", "replace")

    def end(self) -> None:
        """End the session on the server."""
        with self._lock:
            session, self._session = self._session, None
        if session is not None:
            # Whether the server takes notice is its own affair.
            with suppress(MediaError):
                self._request("DELETE", session, None, {})

    def _request(
        self, method: str, address: str, body: bytes | None, headers: dict[str, str]
    ) -> tuple[int, str | None, str, bytes]:
        """Status, the address that it names, content type, and content of an answer, after one redirect at most."""
        for _ in range(2):
            own = origin_of(address) == origin_of(self._address)
            secret = {"Authorization": f"Bearer {self._token}"} if self._token and own else {}
            answer = self._addresses.ask(method, address, body, headers | secret)
            try:
                content = answer.read(MOST_SDP_BYTES + 1)
            except (OSError, ValueError) as error:
                raise MediaError(f"{self._source.shown} breaks off in its answer") from error
            finally:
                answer.close()
            place = answer.getheader("Location")
            named = urljoin(address, place) if place else None
            if answer.status not in REDIRECTS or named is None:
                break
            address = named
        kind = (answer.getheader("Content-Type") or "").partition(";")[0].strip().lower()
        return answer.status, named, kind, content
