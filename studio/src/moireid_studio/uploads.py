"""A form with a film, written to the disk as it arrives, and never whole in memory.

The file gets a name of ours, with a suffix that its first bytes decide; the visitor's name of it is only shown.  Only
containers of films pass, so FFmpeg never gets a playlist or a script that names other files.
"""

from __future__ import annotations

import asyncio
import hashlib
import time
import unicodedata
from collections.abc import AsyncIterator, Callable, Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header
from starlette.requests import ClientDisconnect, Request
from starlette.types import Message

from moireid_studio.problems import Refusal
from moireid_studio.settings import Limits

#: The type of a file is decided by this many first bytes.
HEAD_BYTES = 512
ALLOWED = "MP4, MOV, 3GP, WebM, MKV, AVI, MPEG-TS or MPEG-PS"
NO_FILM = f"This file is none of the films that are taken: {ALLOWED}."
#: Letters of a film's name that are shown.
LONGEST_NAME = 120
#: After a refusal the rest is read and dropped for this long: a browser reads no answer before it has sent all.
DRAIN_S = 5.0
#: Least mean rate of an upload, bytes a second, once it has lasted so long, s; a poor line is ten times as fast.
LEAST_RATE, GRACE_S = 16_000.0, 10.0


@dataclass
class Form:
    """What a visitor sent: the film and its digest, where there is one; the other fields; what they call the film.

    That name is for people alone: no path is ever made of it.
    """

    video: Path | None = None
    fields: dict[str, str] = field(default_factory=dict)
    name: str = ""
    sha256: str | None = None


def sniff(head: bytes) -> str | None:
    """The suffix for the container that a file's first bytes show, or None where it is not an accepted film."""
    if head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"):
        return ".mp4"
    if head[:4] == b"\x1a\x45\xdf\xa3":
        return ".mkv"
    if head[:4] == b"RIFF" and head[8:12] == b"AVI ":
        return ".avi"
    if head[:4] == b"\x00\x00\x01\xba":
        return ".mpg"
    # Packets of a transport stream are 188 bytes long and begin with the same byte; on discs 4 more bytes come first.
    if any(head[at : at + 2 * step + 1 : step] == b"GGG" for at, step in ((0, 188), (4, 192))):
        return ".ts"
    return None


async def receive(
    request: Request,
    folder: Path,
    limits: Limits,
    *,
    fields: Collection[str],
    stored: Callable[[int], None] = lambda _: None,
) -> Form:
    """Read a form: the file `video` into `folder`, and these other fields.

    stored: called with how many bytes of the film were written so far; it may refuse more.
    Raises: Refusal 400 where it is no whole form, 408 where it stops, 413 where it is too large, 415 where it is
        no form at all, or the file is no film, 422 where a field is unknown, given twice, or no text.
    """
    form, options = parse_options_header(request.headers.get("content-type"))
    boundary = options.get(b"boundary", b"")
    if form != b"multipart/form-data" or not 0 < len(boundary) <= 200:
        raise Refusal(415, "form", "Send a form (multipart/form-data) with the film as the file `video`.")
    most = limits.upload_bytes + limits.form_bytes
    length = request.headers.get("content-length", "")
    reader = _Reader(boundary, folder, limits, fields)
    body = in_time(request, limits).stream()
    try:
        if length.isdecimal() and int(length) > most:
            raise _too_large(limits)
        async for chunk in body:
            reader.feed(chunk)
            stored(reader.written)
        return reader.finish()
    except FormParserError as error:
        raise Refusal(400, "form", "The form cannot be read; send it again.") from error
    except TimeoutError as error:
        text = "The upload stopped, or came too slowly; send it again, over a faster connection if you can."
        raise Refusal(408, "slow", text) from error
    except OSError as error:
        raise Refusal(503, "disk", f"The film cannot be stored ({error.strerror}); try again later.") from error
    except Refusal:
        # A client that waits for "100 Continue" gets the refusal at once.
        if "expect" not in request.headers:
            await _drain(body, most)
        raise
    finally:
        reader.close()


def called(name: str) -> str:
    """A file's name as a page may show it: without folders and without letters that are not to be seen."""
    seen = "".join(letter for letter in name if unicodedata.category(letter)[0] != "C")
    return seen.replace("\\", "/").rpartition("/")[2].strip()[:LONGEST_NAME]


class _Reader:
    """Takes the bytes of a form; the parser calls back for each part."""

    def __init__(self, boundary: bytes, folder: Path, limits: Limits, names: Collection[str]) -> None:
        calls = {
            name: getattr(self, f"_{name}")
            for name in ("part_begin", "part_data", "header_field", "header_value", "header_end", "headers_finished")
        }
        calls |= {"part_end": self._part_end, "end": self._end}
        self._parser = MultipartParser(boundary, {f"on_{name}": call for name, call in calls.items()})  # type: ignore[arg-type]
        self._folder, self._limits, self._names = folder, limits, names
        self._texts: dict[str, bytearray] = {}
        self._file: BinaryIO | None = None
        self._head, self.written, self._outside_film, self._ended = bytearray(), 0, 0, False
        self._header, self._value, self._disposition, self._name = bytearray(), bytearray(), b"", ""
        self._called = ""
        self._digest = hashlib.sha256()

    def feed(self, chunk: bytes) -> None:
        """Take the next bytes.  Raises: Refusal; FormParserError.

        All bytes outside the film count for the limit: fields, headers of parts, and bytes after the form's end.
        """
        before = self.written
        self._parser.write(chunk)
        self._outside_film += len(chunk) - (self.written - before)
        if self._outside_film > self._limits.form_bytes:
            most = self._limits.form_bytes // 1024
            raise Refusal(413, "too_large", f"Without the film the form is larger than the {most} kB that are taken.")

    def finish(self) -> Form:
        """The form, once all has come."""
        if not self._ended:
            raise Refusal(400, "form", "The form ends before its end; send it again.")
        try:
            texts = {name: bytes(text).decode() for name, text in self._texts.items()}
        except UnicodeDecodeError as error:
            raise Refusal(422, "fields", "A field of the form is no text in UTF-8.") from error
        if self._file is None:
            return Form(None, texts)
        self.close()
        if (suffix := sniff(bytes(self._head))) is None:
            raise Refusal(415, "no_film", NO_FILM)
        return Form(
            (self._folder / "upload").rename(self._folder / f"film{suffix}"),
            texts,
            self._called,
            self._digest.hexdigest(),
        )

    def close(self) -> None:
        if self._file is not None:
            self._file.close()

    def _part_begin(self) -> None:
        self._disposition, self._name = b"", ""

    def _header_field(self, data: bytes, start: int, end: int) -> None:
        self._header += data[start:end]

    def _header_value(self, data: bytes, start: int, end: int) -> None:
        self._value += data[start:end]

    def _header_end(self) -> None:
        if self._header.lower() == b"content-disposition":
            self._disposition = bytes(self._value)
        self._header.clear()
        self._value.clear()

    def _headers_finished(self) -> None:
        options = parse_options_header(self._disposition)[1]
        name = options.get(b"name", b"").decode("utf-8", "replace")
        if name == "video" and self._file is None:
            self._called = called(options.get(b"filename", b"").decode("utf-8", "replace"))
            self._file = (self._folder / "upload").open("xb")
        elif name == "video" or name in self._texts:
            raise Refusal(422, "fields", "A field of the form is given twice.")
        elif name in self._names:
            self._texts[name] = bytearray()
        else:
            raise Refusal(422, "fields", f"The form may have the fields video, {', '.join(self._names)}, and no other.")
        self._name = name

    def _part_data(self, data: bytes, start: int, end: int) -> None:
        piece = data[start:end]
        if self._name == "video":
            assert self._file is not None
            if len(self._head) < HEAD_BYTES:
                self._head += piece[: HEAD_BYTES - len(self._head)]
                if len(self._head) == HEAD_BYTES and sniff(bytes(self._head)) is None:
                    raise Refusal(415, "no_film", NO_FILM)
            self.written += len(piece)
            if self.written > self._limits.upload_bytes:
                raise _too_large(self._limits)
            self._file.write(piece)
            self._digest.update(piece)
            return
        self._texts[self._name] += piece

    def _part_end(self) -> None:
        # A browser sends a file that was not chosen as an empty one.
        if self._name == "video" and self.written == 0 and self._file is not None:
            self.close()
            self._file = None
            (self._folder / "upload").unlink()

    def _end(self) -> None:
        self._ended = True


def _too_large(limits: Limits) -> Refusal:
    return Refusal(413, "too_large", f"The film is larger than the {limits.upload_bytes >> 20} MB that are taken.")


def in_time(request: Request, limits: Limits) -> Request:
    """The same request, whose body must keep coming.

    Reading on raises TimeoutError where nothing comes for `Limits.idle_s`, where all takes longer than `upload_s`, or
    where the mean rate falls below `LEAST_RATE` after the first `GRACE_S`.
    """
    begun, got = time.monotonic(), 0

    async def receive() -> Message:
        nonlocal got
        last_s = min(GRACE_S + got / LEAST_RATE, limits.upload_s) - (time.monotonic() - begun)
        async with asyncio.timeout(max(min(limits.idle_s, last_s), 0.0)):
            message = await request.receive()
        got += len(message.get("body", b""))
        return message

    return Request(request.scope, receive)


async def _drain(body: AsyncIterator[bytes], most: int) -> None:
    """Read the rest and drop it, for a limited time and at most a whole upload."""
    try:
        async with asyncio.timeout(DRAIN_S):
            async for chunk in body:
                most -= len(chunk)
                if most < 0:
                    return
    except (TimeoutError, ClientDisconnect):
        return
