"""Media, links and devices made to harm their reader, each by name; `crafted_films.py` has those of lists and streams.

Each is made in a folder of its own, and gives the path to verify and what ends it.
"""

from __future__ import annotations

import os
import socket
import struct
import threading
import zlib
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np

from kit.coded_films import first_frames
from kit.crafted_films import LISTS, list_of, streams_of
from kit.places import FILMS

Crafted = tuple[Path, Callable[[], object]]
Craft = Callable[[Path], Crafted]
TRUE = FILMS / "genuine_1.0m.mp4"


def _nothing() -> None:
    pass


def _lists(kind: str) -> Craft:
    return lambda folder: (list_of(kind, folder)[0], _nothing)


def _streams(name: str, count: int, size: tuple[int, int]) -> Craft:
    return lambda folder: (streams_of(folder / name, count, size), _nothing)


def _link(target: str) -> Craft:
    def craft(folder: Path) -> Crafted:
        (folder / "film.mp4").symlink_to(target)
        return folder / "film.mp4", _nothing

    return craft


def _content(name: str, make: Callable[[], bytes]) -> Craft:
    def craft(folder: Path) -> Crafted:
        (folder / name).write_bytes(make())
        return folder / name, _nothing

    return craft


def _coded(name: str, codec: str, size: tuple[int, int], frames: int, **options: str) -> Craft:
    """Pictures of one grey each."""

    def craft(folder: Path) -> Crafted:
        with av.open(str(folder / name), "w") as container:
            stream = container.add_stream(codec, rate=30)
            stream.width, stream.height = size
            stream.pix_fmt = "yuv420p"
            stream.options = {"preset": "ultrafast", "threads": "2", **options}
            for number in range(frames):
                grey = np.full((size[1] * 3 // 2, size[0]), 40 + number % 200, np.uint8)
                frame = av.VideoFrame.from_ndarray(grey, format=stream.pix_fmt)
                frame.pts = number
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
        return folder / name, _nothing

    return craft


def _pipe(folder: Path) -> Crafted:
    os.mkfifo(folder / "film.mp4")
    return folder / "film.mp4", _nothing


def _socket(folder: Path) -> Crafted:
    # A path of a socket is short.
    made = socket.socket(socket.AF_UNIX)
    before = os.getcwd()
    os.chdir(folder)
    try:
        made.bind("film.mp4")
    finally:
        os.chdir(before)
    return folder / "film.mp4", made.close


def _folder(folder: Path) -> Crafted:
    (folder / "film.mp4").mkdir()
    return folder / "film.mp4", _nothing


def _sparse(folder: Path) -> Crafted:
    """A film of 3 GB, nearly all of it a hole."""
    path = first_frames(TRUE, folder / "film.mp4", 5)
    os.truncate(path, 3 << 30)
    return path, _nothing


def _growing(folder: Path) -> Crafted:
    path, done = first_frames(TRUE, folder / "film.ts", 20), threading.Event()

    def grow() -> None:
        with path.open("ab") as film:
            while not done.wait(0.01):
                film.write(bytes(188))

    thread = threading.Thread(target=grow)
    thread.start()

    def end() -> None:
        done.set()
        thread.join()

    return path, end


def _box(kind: bytes, body: bytes = b"") -> bytes:
    return struct.pack(">I", 8 + len(body)) + kind + body


def _nested_boxes() -> bytes:
    body = b""
    for _ in range(20_000):
        body = struct.pack(">I", 8 + len(body)) + b"moov" + body if len(body) < 200_000 else body
    return _box(b"ftyp", b"isom\0\0\2\0isom") + body


def _with_box(kind: bytes, change: Callable[[bytes], bytes]) -> Callable[[], bytes]:
    """The true film, with the content of one box of its header changed at its own length."""

    def make() -> bytes:
        data = bytearray(TRUE.read_bytes())
        at = data.index(kind)
        length = int.from_bytes(data[at - 4 : at]) - 8
        data[at + 4 : at + 4 + length] = change(bytes(data[at + 4 : at + 4 + length]))[:length].ljust(length, b"\0")
        return bytes(data)

    return make


def _external_media() -> bytes:
    """The true film, whose data reference names another file in place of itself."""
    data = TRUE.read_bytes()
    own = _box(b"url ", b"\0\0\0\1")
    assert own in data
    return data.replace(own, _box(b"url ", b"\0\0\0\0"), 1).replace(b"url \0\0\0\0", b"alis\0\0\0\0", 1)


def _reference_movie() -> bytes:
    there = b"\0\0\0\0url " + struct.pack(">I", 10) + b"other.mp4\0"
    return _box(b"ftyp", b"qt  \0\0\0\0qt  ") + _box(b"moov", _box(b"rmra", _box(b"rmda", _box(b"rdrf", there))))


def _y4m(width: int, height: int, frames: int) -> Callable[[], bytes]:
    return lambda: b"YUV4MPEG2 W%d H%d F30:1 C420jpeg\n" % (width, height) + (b"FRAME\n" + bytes(500)) * frames


def _gif(width: int, height: int, frames: int) -> Callable[[], bytes]:
    drawn = b"\x21\xf9\x04\0\x05\0\0\0\x2c" + struct.pack("<HHHHB", 0, 0, 4, 4, 0) + b"\x02\x03\x84\x8f\x09\0"
    head = b"GIF89a" + struct.pack("<HHBBB", width, height, 0x80, 0, 0) + bytes(6)
    return lambda: head + drawn * frames + b"\x3b"


def _chunk(tag: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + tag + body + struct.pack(">I", zlib.crc32(tag + body))


def _apng(width: int, height: int, frames: int) -> Callable[[], bytes]:
    """Rows of zeros, which shrink a thousandfold."""

    def make() -> bytes:
        rows = zlib.compress(bytes((width * 4 + 1) * height), 9)
        head = _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
        drawn = b"".join(
            _chunk(b"fcTL", struct.pack(">IIIIIHHBB", 2 * k, width, height, 0, 0, 1, 30, 0, 0))
            + (_chunk(b"fdAT", struct.pack(">I", 2 * k + 1) + rows) if k else _chunk(b"IDAT", rows))
            for k in range(frames)
        )
        actl = _chunk(b"acTL", struct.pack(">II", frames, 0))
        return b"\x89PNG\r\n\x1a\n" + head + actl + drawn + _chunk(b"IEND", b"")

    return make


def _ebml() -> bytes:
    """Matroska whose first element says that it has 2^56 bytes."""
    head = b"\x1a\x45\xdf\xa3\x8fB\x86\x81\x01B\x82\x88matroska\x18\x53\x80\x67\x01"
    return head + b"\xff" * 6 + b"\xfe" + bytes(999)


CRAFTED: dict[str, Craft] = {
    **{f"list {kind}": _lists(kind) for kind in LISTS},
    "64 streams of 8K (mkv)": _streams("film.mkv", 64, (7680, 4320)),
    "4 streams of 8K (mkv)": _streams("film.mkv", 4, (7680, 4320)),
    "8K with 16 references (mkv)": _coded("film.mkv", "libx264", (7680, 4320), 24, refs="16", bf="0"),
    "beyond 8K (h264)": _coded("film.mkv", "libx264", (12288, 6912), 2),
    "huge pictures (y4m)": _content("film.y4m", _y4m(65_535, 65_535, 40)),
    "huge pictures (gif)": _content("film.gif", _gif(65_535, 65_535, 40)),
    "huge pictures (apng)": _content("film.apng", _apng(16_000, 16_000, 2)),
    "boxes in boxes (mp4)": _content("film.mp4", _nested_boxes),
    "data elsewhere (mp4)": _content("film.mp4", _external_media),
    "reference movie (mov)": _content("film.mov", _reference_movie),
    "2^32 samples (mp4)": _content("film.mp4", _with_box(b"stsz", lambda body: body[:8] + b"\xff" * 4 + body[12:])),
    "2^32 times (mp4)": _content("film.mp4", _with_box(b"stts", lambda body: b"\0\0\0\0" + b"\xff" * (len(body) - 4))),
    "2^56 bytes (mkv)": _content("film.mkv", _ebml),
    "empty": _content("film.mp4", bytes),
    "text": _content("film.mp4", lambda: b"a film\n" * 1000),
    "3 GB, a hole": _sparse,
    "written to without end": _growing,
    "folder": _folder,
    "pipe": _pipe,
    "socket": _socket,
    "link to nothing": _link("none.mp4"),
    "link to itself": _link("film.mp4"),
    "link to /dev/zero": _link("/dev/zero"),
    "link to its own memory": _link("/proc/self/mem"),
    "link to a pipe": _link("other.mp4"),
}
