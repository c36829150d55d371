"""What the judge asks of us: bytes of a pipe and of addresses, pictures of this machine's devices, and descriptions of
WebRTC sessions.

The judge is in a stranger's hands once it has read the source.  So it names addresses, and we decide on each; it gets
bytes of these streams alone, so many at a time.
"""

from __future__ import annotations

import hashlib
import os
import queue
import select
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, BinaryIO
from urllib.parse import urljoin, urlsplit, urlunsplit

from moireid.errors import MediaError, MoireIdError
from moireid.sandbox.process import Child, ProcessEnd
from moireid_studio.watch.devices import shots_of
from moireid_studio.watch.fetching import REDIRECTS, Addresses, origin_of
from moireid_studio.watch.order import PIECE, Data, Signal, StreamEnd
from moireid_studio.watch.source import Source

#: Streams that the judge may have open: HLS has a playlist, a picture's and a sound's piece.
MOST_OPEN = 8
#: Time between two looks whether a pipe is still waited for, s.
LOOK_S = 0.25


class Feeder:
    """Answers the judge; each answer that may take long is given by a thread, which ends with this process."""

    def __init__(self, source: Source, child: Child, token: str | None) -> None:
        self._source, self._child, self._token = source, child, token
        self._lock, self._over = threading.Lock(), threading.Event()
        self._digest = hashlib.sha256()
        self._pipe: BinaryIO | None = None
        self._addresses = Addresses(source.text) if source.kind == "http" else None
        self._streams: dict[int, Any] = {}
        self._asking: Asking | None = None
        #: Descriptions of WebRTC sessions that the judge gave to a sender.
        self.described: queue.SimpleQueue[str] = queue.SimpleQueue()

    @property
    def sha256(self) -> str:
        """Of the pipe's bytes that were read."""
        return self._digest.hexdigest()

    def begin(self) -> None:
        """Begin with a source whose pictures are made here.  Raises: MediaError where a pipe cannot be read."""
        if self._source.kind == "pipe":
            self._pipe = _pipe(self._source)
        elif self._source.kind in ("camera", "screen"):
            self._aside(self._shoot)

    def send(self, message: object) -> None:
        """Send the judge a message; where it has gone, the thread that listens to it finds out why."""
        with self._lock, suppress(ProcessEnd):
            self._child.send(message)

    def answer(self, message: dict[str, Any]) -> None:
        """Answer a wish."""
        wish = message.get("want")
        if wish == "open" and self._addresses is not None and len(self._streams) < MOST_OPEN:
            # It counts from now on, so that a judge that was taken over cannot ask for many at once.
            number = int(message["number"])
            self._streams[number] = None
            self._aside(lambda: self._open(number, str(message["address"])))
        elif wish == "read":
            self._aside(lambda: self._read(int(message["number"]), min(int(message["most"]), PIECE)))
        elif wish == "close":
            self._close(int(message["number"]))
        elif wish is not None:
            self.send(Data(int(message.get("number", 0)), b"", time.monotonic(), "it may not be opened"))
        elif isinstance(message.get("answer"), str):
            self.described.put(message["answer"])
        elif isinstance(message.get("offer"), str) and self._source.kind == "whep" and self._asking is None:
            self._asking = Asking(self._source, self._token)
            self._aside(lambda: self._offer(message["offer"]))

    def end(self) -> None:
        """Let go of all that is open."""
        self._over.set()
        if self._asking is not None:
            self._asking.end()
        for number in list(self._streams):
            self._close(number)

    def _aside(self, work: Callable[[], None]) -> None:
        def safely() -> None:
            try:
                work()
            except MoireIdError as error:
                self.send(StreamEnd("failed", " ".join(str(error).split())))

        threading.Thread(target=safely, daemon=True).start()

    def _open(self, number: int, address: str) -> None:
        assert self._addresses is not None
        error = None
        try:
            self._streams[number] = self._addresses.open(address)
        except MediaError as refused:
            self._streams.pop(number, None)
            error = str(refused)
        self.send(Data(number, b"", time.monotonic(), error))

    def _read(self, number: int, most: int) -> None:
        try:
            content = self._some(number, most)
        except (OSError, MediaError) as error:
            self.send(Data(number, b"", time.monotonic(), str(getattr(error, "strerror", None) or error)))
            return
        self.send(Data(number, content, time.monotonic()))

    def _some(self, number: int, most: int) -> bytes:
        if self._pipe is not None:
            # A pipe into which no one has written yet would seem to be at its end; and a read that waits would take
            # what is written for the next reader.
            while not select.select([self._pipe], [], [], LOOK_S)[0]:
                if self._over.is_set():
                    return b""
            content = os.read(self._pipe.fileno(), most)
            self._digest.update(content)
            return content
        stream = self._streams.get(number)
        return b"" if stream is None else stream.read(most)

    def _close(self, number: int) -> None:
        if (stream := self._streams.pop(number, None)) is not None:
            with suppress(OSError):
                stream.close()

    def _shoot(self) -> None:
        for shot in shots_of(self._source):
            if self._over.is_set():
                return
            self.send(shot)
        self.send(StreamEnd("source"))

    def _offer(self, sdp: str) -> None:
        assert self._asking is not None
        self.send(Signal(self._asking.ask(sdp)))


def _pipe(source: Source) -> BinaryIO:
    """The pipe, opened for its bytes."""
    if source.text != "-":
        try:
            # Without waiting: the writer may not be there yet, and the judge decides how long that may take.
            opened = os.open(source.text, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            os.set_blocking(opened, True)
            return open(opened, "rb", buffering=0)
        except OSError as error:
            raise MediaError(f"pipe {source.shown} cannot be read ({error.strerror}); check its rights") from error
    if sys.stdin is None or sys.stdin.buffer.isatty():
        raise MediaError("nothing is piped into this program; give it a stream, such as: cat film.ts | moireid watch -")
    return sys.stdin.buffer


SDP = "application/sdp"
#: Longest description of a session, bytes; a sender with sound and picture needs some thousand.
MOST_SDP_BYTES = 1 << 16


class Asking:
    """One session with a WHEP server: we speak with it, the judge receives the pictures and never learns the token.

    Source: draft-ietf-wish-whep: POST an offer, get an answer and the session's address, DELETE that at the end.
    """

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
