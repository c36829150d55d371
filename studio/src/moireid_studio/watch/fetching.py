"""Addresses of HTTP, read by us for a decoder that reaches no network.

Who gives an address means its host, wherever that is.  What a playlist or a redirect names is a stranger's word: it may
name the same host and port, or a host of the public internet, and nothing within this machine or its network.

Convention: a name is looked up once for each connection, which goes to the address that was checked: a second answer
    could name another.  A host that was public at first must stay so, else its owner could lead us inwards later.
"""

from __future__ import annotations

import base64
import http.client
import ipaddress
import socket
import ssl
import threading
from collections.abc import Mapping
from typing import cast
from urllib.parse import unquote, urljoin, urlsplit

from moireid import __version__
from moireid.errors import MediaError

#: Longest wait for a connection or for bytes, s; redirects that are followed; letters of an address.
WAIT_S, MOST_REDIRECTS, MOST_LETTERS = 10.0, 5, 4096
PORTS = {"http": 80, "https": 443}
REDIRECTS = (301, 302, 303, 307, 308)


class Addresses:
    """The addresses that a stream may be read from.

    Parameters
    ----------
    first
        The address that a user gave. Its password is sent to its own host alone.
    """

    def __init__(self, first: str) -> None:
        self._first, self._origin = first, origin_of(first)
        #: Whether the user's own host was on the public internet as it was first asked.
        self._outside = False

    def open(self, address: str) -> Stream:
        """A stream of bytes.  Raises: MediaError where the address may not be opened, or gives none."""
        for _ in range(MOST_REDIRECTS + 1):
            answer = self.ask("GET", address)
            if answer.status not in REDIRECTS:
                break
            address = urljoin(address, answer.getheader("Location") or "")
            answer.close()
        else:
            raise MediaError(f"{_host(address)} leads on and on; give the last address")
        if answer.status != 200:
            answer.close()
            raise MediaError(f"{_host(address)} answers {answer.status} {answer.reason}"[:200])
        return Stream(answer)

    def ask(
        self, method: str, address: str, body: bytes | None = None, headers: Mapping[str, str] | None = None
    ) -> http.client.HTTPResponse:
        """One request; an answer of any status.  Raises: MediaError where the address may not be asked."""
        parts, own = urlsplit(address), origin_of(address) == self._origin
        if self._origin[0] == "https" and parts.scheme != "https":
            raise MediaError(f"{_host(address)} is named without encryption by an address that has it; that is refused")
        sent = {"User-Agent": f"moireid/{__version__}", "Accept": "*/*", **(headers or {})}
        if own and (secret := _password(self._first)):
            sent.setdefault("Authorization", secret)
        target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        scheme, host, port = origin_of(address)
        try:
            connection = _connection(scheme, host, port, public=not own or self._outside)
            if own and public(connection.sock.getpeername()[0]):
                self._outside = True
            connection.request(method, target, body, sent)
            return connection.getresponse()
        except (OSError, http.client.HTTPException, ValueError) as error:
            words = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise MediaError(f"{_host(address)} cannot be reached ({words})") from error


class Stream:
    """The bytes of an answer."""

    def __init__(self, answer: http.client.HTTPResponse) -> None:
        self._answer, self._lock = answer, threading.Lock()

    def read(self, most: int) -> bytes:
        """The next bytes, as soon as there are some; b"" at the end.  Raises: OSError where it breaks off."""
        try:
            with self._lock:
                return self._answer.read1(most)
        except (http.client.HTTPException, ValueError) as error:
            raise OSError(5, f"it breaks off ({error})") from error

    def close(self) -> None:
        """End the connection."""
        with self._lock:
            self._answer.close()


def origin_of(address: str) -> tuple[str, str, int]:
    """Scheme, host and port.  Raises: MediaError where it is no address of HTTP."""
    try:
        parts = urlsplit(address)
        scheme, host, port = parts.scheme.lower(), parts.hostname, parts.port
    except ValueError as error:
        raise MediaError(f"{address[:80]!r} is no address ({error})") from error
    if scheme not in PORTS or not host or len(address) > MOST_LETTERS or any(ord(letter) <= 32 for letter in address):
        raise MediaError(f"{address[:80]!r} is no address of http or https, and nothing else is opened")
    return scheme, host.lower(), port or PORTS[scheme]


def public(address: str) -> bool:
    """Whether an IP address is one of the public internet."""
    found = ipaddress.ip_address(address.partition("%")[0])
    inner = getattr(found, "ipv4_mapped", None) or getattr(found, "sixtofour", None)
    return found.is_global and not found.is_multicast and (inner is None or public(str(inner)))


def _connection(scheme: str, host: str, port: int, *, public: bool) -> http.client.HTTPConnection:
    """A connection to a host; public: to an address of the public internet alone."""
    connected = _connected(host, port, only_public=public)
    if scheme == "https":
        try:
            connected = ssl.create_default_context().wrap_socket(connected, server_hostname=host)
        except OSError:
            connected.close()
            raise
    connection = http.client.HTTPConnection(host, port, timeout=WAIT_S)
    if scheme == "https":
        # What is said of the host, in its header, leaves out the usual port.
        connection.default_port = PORTS["https"]
    connection.sock = connected
    return connection


def _connected(host: str, port: int, *, only_public: bool) -> socket.socket:
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    error: OSError | None = None
    for family, kind, protocol, _, place in found:
        if only_public and not public(cast(str, place[0])):
            error = error or OSError(1, f"it is at {place[0]}, within this machine or its network")
            continue
        made = socket.socket(family, kind, protocol)
        made.settimeout(WAIT_S)
        try:
            made.connect(place)
        except OSError as refused:
            made.close()
            error = refused
            continue
        return made
    raise error or OSError(2, "it has no address")


def _password(address: str) -> str | None:
    """The header of the name and password that an address holds."""
    parts = urlsplit(address)
    if parts.username is None:
        return None
    pair = f"{unquote(parts.username)}:{unquote(parts.password or '')}"
    return f"Basic {base64.b64encode(pair.encode()).decode()}"


def _host(address: str) -> str:
    """What is shown of an address: no password, and no query, which may be one."""
    parts = urlsplit(address)
    return f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path}"[:200]
