"""A witness's server: HTTP, one request to answer, and little that a stranger can use up.

A connection may last so long and send so much, and there are so many at one time; the oldest makes room for another.
There is no TLS: what is signed needs none, and a proxy can add it.
"""

from __future__ import annotations

import contextlib
import io
import socket
import sqlite3
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from moireid.errors import SpecError
from moireid.registry.witness.request import MOST_BYTES, PATH
from moireid.registry.witness.state import Answer, Witness

#: How long a connection lasts, seconds; what it may send, bytes: two requests and their headers; most at one time.
LASTS_S, MOST_SENT, MOST_CLIENTS = 20.0, 3 * MOST_BYTES, 64
#: How soon a connection that was ended gives its place to another, seconds; else that one is closed.
ROOM_S = 1.0


class WitnessServer(ThreadingHTTPServer):
    """Answers for a witness at an address, until `shutdown`.

    Parameters: host, port: where it listens; port 0: any that is free.
    Raises: SpecError if it cannot listen there.
    """

    daemon_threads, request_queue_size = True, MOST_CLIENTS

    def __init__(self, witness: Witness, host: str, port: int) -> None:
        self.witness, self._places = witness, threading.BoundedSemaphore(MOST_CLIENTS)
        #: Connections that are served, the oldest first.
        self._served, self._lock = dict[Any, None](), threading.Lock()
        if ":" in host:
            self.address_family = socket.AF_INET6
        try:
            super().__init__((host, port), _Handler)
        except (OSError, OverflowError) as error:
            raise SpecError(f"no witness can listen at {host}:{port} ({error}); give another address") from error

    def server_bind(self) -> None:
        """Listen, without a look-up of this machine's name, which may take long."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    @property
    def address(self) -> str:
        """Where it listens."""
        host = f"[{self.server_name}]" if ":" in self.server_name else self.server_name
        return f"http://{host}:{self.server_port}"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a client; where all places are taken, the oldest connection ends."""
        if not self._places.acquire(blocking=False):
            self._end_oldest()
            if not self._places.acquire(timeout=ROOM_S):
                self.shutdown_request(request)
                return
        with self._lock:
            self._served[request] = None
        try:
            super().process_request(request, client_address)
        except RuntimeError:
            # No thread could be started, so none gives the place back.
            self._give_place_back(request)
            raise

    def _end_oldest(self) -> None:
        with self._lock, contextlib.suppress(OSError, StopIteration):
            next(iter(self._served)).shutdown(socket.SHUT_RDWR)

    def _give_place_back(self, request: Any) -> None:
        with self._lock:
            del self._served[request]
        self._places.release()

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a client, then give its place back."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._give_place_back(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say why a client was not served, on one line; none where it went away, as a stranger could fill the disk."""
        if isinstance(sys.exception(), OSError):
            return
        print(f"witness: a connection ended early ({sys.exception()!r:.200})", file=sys.stderr)  # noqa: T201


class _Incoming(io.RawIOBase):
    """What a client sends: no more than it may, and not after its time is over."""

    def __init__(self, line: socket.socket) -> None:
        self._line, self._left, self._until = line, MOST_SENT, time.monotonic() + LASTS_S

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        wait_s = self._until - time.monotonic()
        if wait_s <= 0 or self._left <= 0:
            raise TimeoutError("its time is over, or it sent too much")
        self._line.settimeout(wait_s)
        count = self._line.recv_into(memoryview(buffer)[: self._left])
        self._left -= count
        return count


class _Handler(BaseHTTPRequestHandler):
    server: WitnessServer
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "moireid-witness", ""
    error_message_format, error_content_type = "%(message)s\n", "text/plain; charset=utf-8"

    def setup(self) -> None:
        """Read from the client through the limits."""
        super().setup()
        self.rfile = io.BufferedReader(_Incoming(self.connection), 8192)

    def do_POST(self) -> None:
        """Answer a request; a body that is not read ends the connection."""
        length, self.close_connection = self.headers.get("Content-Length", ""), True
        if self.path != PATH:
            return self._send(Answer(404, "a witness answers at /add-checkpoint alone\n"))
        if "Transfer-Encoding" in self.headers or not (length.isascii() and length.isdecimal()):
            return self._send(Answer(411, "the request must state its length\n"))
        if len(length) > 9 or int(length) > MOST_BYTES:
            return self._send(Answer(413, f"the request is longer than {MOST_BYTES} bytes\n"))
        content = self.rfile.read(int(length))
        if len(content) < int(length):
            return None
        try:
            answer = self.server.witness.answer(content)
        except sqlite3.Error as error:
            # A full disk, or a file that is gone: without its state a witness must not sign.
            print(f"witness: the state cannot be kept ({error})", file=sys.stderr)  # noqa: T201
            return self._send(Answer(503, "the witness cannot keep its state at present\n"))
        self.close_connection = self.headers.get("Connection", "").lower() == "close"
        return self._send(answer)

    def _send(self, answer: Answer) -> None:
        content = answer.text.encode()
        self.send_response(answer.status)
        self.send_header("Content-Type", answer.kind)
        self.send_header("Content-Length", str(len(content)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        """No line for each request: a stranger could fill the disk."""
