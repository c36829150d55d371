"""What a source is, from what was typed."""

from __future__ import annotations

import re
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit, urlunsplit

from moireid.errors import MediaError, SpecError

Kind = Literal["camera", "screen", "file", "pipe", "http", "rtsp", "whep", "whip"]
#: Addresses by their beginning.  WHEP and WHIP are HTTP; their own beginnings say what is spoken there.
SCHEMES: dict[str, Kind] = {
    "http": "http",
    "https": "http",
    "rtsp": "rtsp",
    "whep": "whep",
    "wheps": "whep",
    "whip": "whip",
}
#: Kinds whose pictures come when they are taken.  HLS sends pieces of seconds; a pipe may be either.
LIVE: frozenset[Kind] = frozenset({"camera", "screen", "rtsp", "whep", "whip"})
#: Kinds through which prompts can be answered in time.
PROMPTED: frozenset[Kind] = LIVE | {"pipe"}
RTSP_PORT = 554
KINDS = (
    "a camera's number, a file, - for a pipe, screen, or an address (http://, https://, rtsp://, whep://, wheps://, "
    "whip://)"
)
SCREEN = re.compile(r"screen(?::(?P<window>0x[0-9a-fA-F]{1,8}|[0-9]{1,10}))?")


@dataclass(frozen=True)
class Source:
    """A source of pictures.

    text: what opens it: a number, a path, an address; shown: the same without a password, for reports.
    """

    kind: Kind
    text: str
    shown: str

    @property
    def ports(self) -> tuple[int, ...] | None:
        """TCP ports that the process which decodes it must reach, apart from UDP; None where it needs no network."""
        if self.kind == "rtsp":
            return (urlsplit(self.text).port or RTSP_PORT,)
        return () if self.kind in ("whep", "whip") else None

    def live(self, *, challenged: bool) -> bool:
        """Whether its times are checked against our clock: pictures of a pipe only where prompts are answered by it."""
        return self.kind in LIVE or (challenged and self.kind == "pipe")


def source_of(text: str) -> Source:
    """The source that was typed.

    Raises: SpecError where it is none; MediaError where a file is not there.
    """
    if text == "-":
        return Source("pipe", text, "standard input")
    if re.fullmatch(r"[0-9]{1,2}", text):
        return Source("camera", text, f"camera {text}")
    if SCREEN.fullmatch(text):
        return Source("screen", text, text)
    if "://" in text:
        return _address(text)
    return _file(text)


def participant(name: str) -> Source:
    """The video of a person in a call, whom a program of its own connects by WebRTC; name: for reports."""
    return Source("whip", "", name)


def _address(text: str) -> Source:
    try:
        parts = urlsplit(text)
        host, _ = parts.hostname, parts.port
    except ValueError as error:
        raise SpecError(f"source {text!r} is no address ({error}); give one such as rtsp://camera.example/1") from error
    kind = SCHEMES.get(parts.scheme.lower())
    if kind is None:
        raise SpecError(f"source {text!r} begins with {parts.scheme}://, which is not read here; give {KINDS}")
    if not host or re.search(r"[\s\x00-\x1f]", text):
        raise SpecError(f"source {text!r} names no host; give one such as {parts.scheme}://camera.example/1")
    place = parts.netloc.rpartition("@")[2]
    return Source(kind, text, urlunsplit(parts._replace(netloc=place, query="…" if parts.query else "", fragment="")))


def _file(text: str) -> Source:
    path = Path(text)
    try:
        found = path.stat()
    except (OSError, ValueError) as error:
        raise MediaError(f"source {text!r} does not exist; give {KINDS}") from error
    if stat.S_ISFIFO(found.st_mode):
        return Source("pipe", text, text)
    if not stat.S_ISREG(found.st_mode):
        raise MediaError(f"source {text!r} is no film and no pipe; give {KINDS}")
    return Source("file", str(path.absolute()), text)


def check_prompts(source: Source) -> None:
    """Raise SpecError where prompts cannot be answered through a source."""
    if source.kind not in PROMPTED:
        why = "is a film, which cannot answer" if source.kind == "file" else "comes in pieces of some seconds, too late"
        raise SpecError(f"--challenge asks for moves, and {source.shown} {why}; leave it out, or use a live source")
