"""Films coded anew, joined to others, or damaged: packets lost or zeroed, and flags that say so of whole ones."""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av

#: Size of a packet of a transport stream, and its identifier of the first pictures that FFmpeg writes.
TS, PICTURES = 188, 0x100
#: Encoders, each as fast as it can be without visible loss; what x264 writes depends on the number of threads.
CODECS = {
    "libx264": {"preset": "veryfast", "crf": "20", "threads": "2"},
    "libx265": {"preset": "ultrafast", "crf": "18"},
    "libvpx-vp9": {"deadline": "realtime", "cpu-used": "8", "b": "4M"},
    "mjpeg": {"qmin": "2", "qmax": "4"},
}


def recoded(source: Path, target: Path, codec: str, *, gop: int = 30, frames: int = 120) -> Path:
    """The beginning of a film, at 1280 x 720 and 30 frames a second, with a key picture each `gop` frames."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        stream = made.add_stream(codec, rate=30)
        stream.width, stream.height, stream.gop_size = 1280, 720, gop
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        only = f"log-level=none:keyint={gop}:min-keyint={gop}:pools=1"
        stream.options = CODECS[codec] | ({"x265-params": only} if codec == "libx265" else {})
        for number, picture in enumerate(given.decode(video=0)):
            if number == frames:
                break
            frame = picture.reformat(1280, 720, stream.pix_fmt)
            frame.pts, frame.time_base, frame.pict_type = number, Fraction(1, 30), 0
            made.mux(stream.encode(frame))
        made.mux(stream.encode(None))
    return target


@dataclass(frozen=True)
class Part:
    """A track of a file to be made: where it comes from, and its flags in the file."""

    source: Path
    flags: int = 0


def joined(parts: Sequence[Part], target: Path) -> Path:
    """A file of the first streams of several, as they are coded."""
    given = [av.open(str(part.source)) for part in parts]
    with av.open(str(target), "w") as made:
        tracks = []
        for part, container in zip(parts, given, strict=True):
            track = made.add_stream_from_template(container.streams[0])
            track.disposition = part.flags
            tracks.append(track)
        packets = [
            (float(packet.dts * packet.time_base), number, packet)
            for number, container in enumerate(given)
            for packet in container.demux(container.streams[0])
            if packet.dts is not None
        ]
        for _, number, packet in sorted(packets, key=lambda one: one[:2]):
            packet.stream = tracks[number]
            made.mux(packet)
    for container in given:
        container.close()
    return target


def with_packets(source: Path, target: Path, change: Callable[[int, bytes], bytes | None]) -> Path:
    """A film whose packets are changed, by their number in the order of decoding; None leaves one out."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        for number, packet in enumerate(given.demux(video=0)):
            content = None if packet.dts is None else change(number, bytes(packet))
            if content is None:
                continue
            copied = av.Packet(content)
            copied.pts, copied.dts, copied.time_base = packet.pts, packet.dts, packet.time_base
            copied.duration, copied.is_keyframe, copied.stream = packet.duration, packet.is_keyframe, stream
            made.mux(copied)
    return target


def zeroed(source: Path, target: Path, number: int) -> Path:
    """A film of which one packet is zeros, by its bytes in the file."""
    with av.open(str(source)) as given:
        packets = [bytes(packet) for packet in given.demux(video=0) if packet.size]
    data = source.read_bytes()
    assert data.count(packets[number]) == 1
    target.write_bytes(data.replace(packets[number], bytes(len(packets[number]))))
    return target


def lost(source: Path, target: Path, places: Collection[int]) -> Path:
    """A transport stream without some of its packets."""
    data = source.read_bytes()
    kept = (data[place : place + TS] for place in range(0, len(data), TS) if place // TS not in places)
    target.write_bytes(b"".join(kept))
    return target


def flagged(source: Path, target: Path, share: tuple[float, float] = (0.0, 1.0), *, counters: bool = False) -> Path:
    """A transport stream whose packets are whole, but flagged as damaged, or counted as though one were missing."""
    data, count = bytearray(source.read_bytes()), 0
    size = len(data) // TS
    for number, place in enumerate(range(0, len(data), TS)):
        if (data[place + 1] & 0x1F) << 8 | data[place + 2] != PICTURES:
            continue
        chosen = share[0] <= number / size <= share[1]
        if counters:
            count += chosen and number % 16 == 0
            data[place + 3] = data[place + 3] & 0xF0 | (data[place + 3] + count) & 0x0F
        elif chosen:
            data[place + 1] |= 0x80
    target.write_bytes(data)
    return target


def with_box(source: Path, target: Path, path: Sequence[bytes], box: bytes) -> Path:
    """An MP4 whose index is at its end, with a box at the end of another, which the boxes around it name."""
    data, place = bytearray(source.read_bytes()), 0
    sizes = []
    for name in path:
        place = data.index(name, place)
        sizes.append(place - 4)
    end = sizes[-1] + int.from_bytes(data[sizes[-1] : place], "big")
    for size in sizes:
        data[size : size + 4] = (int.from_bytes(data[size : size + 4], "big") + len(box)).to_bytes(4, "big")
    data[end:end] = box
    target.write_bytes(data)
    return target


def with_edits(source: Path, target: Path, edits: Sequence[tuple[float, float]]) -> Path:
    """An MP4 with another edit list; edits: first second in the film, below 0 for a pause, and length, s."""
    data = bytearray(source.read_bytes())
    movie, media = (data.index(name) for name in (b"mvhd", b"mdhd"))
    scale, ticks = (int.from_bytes(data[place + 16 : place + 20], "big") for place in (movie, media))
    place = data.index(b"elst") - 4
    end = place + int.from_bytes(data[place : place + 4], "big")
    first = int.from_bytes(data[end - 8 : end - 4], "big")
    entries = [(round(length * scale), -1 if at < 0 else round(at * ticks) + first, 1 << 16) for at, length in edits]
    box = struct.pack(">I4sII", 16 + 12 * len(edits), b"elst", 0, len(edits))
    box += b"".join(struct.pack(">Iii", *entry) for entry in entries)
    for name in (b"moov", b"trak", b"edts"):
        size = data.index(name) - 4
        grown = int.from_bytes(data[size : size + 4], "big") + len(box) - (end - place)
        data[size : size + 4] = grown.to_bytes(4, "big")
    data[place:end] = box
    target.write_bytes(data)
    return target
