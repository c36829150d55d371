"""The video tracks of a file, and what players may show of it other than its one track, picture by picture.

Players differ in which of several tracks they show, in what they crop, and in whether they follow edit lists and
chapters.  A verdict is about what every player shows, so each such thing is a finding, and most leave the film
inconclusive.  Cover pictures count as no track.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from moireid.errors import MediaError
from moireid.verifier.limits import MAX_STRAY_SHARE
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.reasons import Reason

if TYPE_CHECKING:
    import av

#: Subtitles that a player draws in any case: pictures, and text that can draw shapes of any size.
DRAWN = frozenset({"dvbsub", "dvdsub", "pgssub", "xsub", "ass", "ssa"})
#: Boxes of MP4 and elements of Matroska that hold others on the way to those that are read.
BOXES = frozenset({b"moov", b"trak", b"edts", b"mdia", b"minf", b"stbl"})
ELEMENTS = frozenset({0x18538067, 0x1654AE6B, 0xAE, 0xE0, 0x1043A770, 0x45B9})
#: PixelCropBottom, Top, Left and Right of Matroska; and its flag of ordered chapters.
PIXEL_CROPS, ORDERED = frozenset({0x54AA, 0x54BB, 0x54CC, 0x54DD}), 0x45DD
#: Sizes of a transport packet: alone, after a time code, and before bytes that correct errors.
PACKETS, SYNC, SCANNED = (188, 192, 204), 0x47, 1 << 22
CUT = "The file breaks off within a part of it; it was judged as far as it goes."
#: A box of these kinds is small; a larger one is broken.
MOST_BOX = 1 << 20


@dataclass(frozen=True)
class VideoTrack:
    """A track of pictures: FFmpeg's number of it, its codec, its size in px (None where unknown), its default flag."""

    index: int
    codec: str | None
    width: int | None
    height: int | None
    default: bool


@dataclass(frozen=True)
class FilmTracks:
    """The tracks of a file, the one that is read, and findings on what players may show instead.

    judged: whether that one may be judged, as it is the only one or was asked for; pictures: that it shows, as
    the file says.
    """

    tracks: tuple[VideoTrack, ...]
    chosen: int
    judged: bool
    findings: tuple[Reason, ...]
    pictures: int | None

    def to_json(self) -> list[dict[str, Any]]:
        """As `input.tracks` of ``verify --json``."""
        return [vars(track) | {"chosen": self.judged and track.index == self.chosen} for track in self.tracks]


def tracks_of(
    container: av.container.InputContainer, unedited: av.container.InputContainer, file: OpenedFile, wanted: int | None
) -> FilmTracks:
    """List the tracks of a file.

    Parameters: container, unedited: the file as opened with and without its edit lists; wanted: the track asked for.
    Raises: MediaError where there is no track, or none of that number.
    """
    # A track of chapters' pictures has the flag of a cover too, but is a track that players may show.
    found = [s for s in container.streams.video if not _is_cover(s)]
    if not found:
        raise MediaError(f"{file.path} holds no video stream; give a film that a video player can play")
    tracks = tuple(_track(stream) for stream in found)
    indices = [track.index for track in tracks]
    if wanted is not None and wanted not in indices:
        named = ", ".join(f"{track.index} ({_words(track)})" for track in tracks)
        raise MediaError(f"{file.path} has no video track {wanted}; its tracks are {named}")
    chosen = indices[0] if wanted is None else wanted
    doubts = [_subtitles(container)] if container.streams.subtitles else []
    formats, late = set(container.format.name.split(",")), 0
    pictures = container.streams[chosen].frames or None
    if "mov" in formats:
        stored, edited = (list(c.streams[chosen].index_entries) for c in (unedited, container))
        doubts += [*_edits(stored, edited), *_boxes(file)]
        pictures = pictures and sum(not entry.is_discard for entry in edited)
    elif "matroska" in formats:
        doubts += _elements(file)
    elif "mpegts" in formats:
        late = len(_picture_ids(file) - {stream.id for stream in container.streams})
    count = len(tracks) + late
    reasons = [Reason("tracks", "undecided", None, None, "", doubt) for doubt in doubts if doubt not in ("", CUT)]
    reasons += [Reason("damaged", "note", None, None, "", CUT)] if CUT in doubts else []
    if count > 1 and wanted is None:
        named = "; ".join(f"track {track.index}: {_words(track)}" for track in tracks)
        text = (
            f"The file has {count} video tracks ({named}{'; one begins later' if late else ''}), and players differ in "
            "which one they show. Nothing was judged: say which track is meant, or give a file with one."
        )
        reasons.insert(0, Reason("tracks", "undecided", float(count), 1.0, "tracks", text))
    elif count > 1:
        text = f"Track {chosen} of the file's {count} video tracks is judged, as asked; players may show another one."
        reasons.insert(0, Reason("tracks", "note", float(count), 1.0, "tracks", text))
    return FilmTracks(tracks, chosen, count == 1 or wanted is not None, tuple(reasons), pictures)


def _is_cover(stream: Any) -> bool:
    flags = type(stream.disposition)
    return bool(stream.disposition & flags.attached_pic) and not stream.disposition & flags.timed_thumbnails


def _track(stream: Any) -> VideoTrack:
    coded = stream.codec_context
    default = bool(stream.disposition & type(stream.disposition).default)
    if coded is None:
        return VideoTrack(stream.index, None, None, None, default)
    return VideoTrack(stream.index, coded.name, coded.width or None, coded.height or None, default)


def _words(track: VideoTrack) -> str:
    size = f" {track.width} x {track.height}" if track.width else ""
    return f"{track.codec or 'unknown codec'}{size}{', default' if track.default else ''}"


def _subtitles(container: av.container.InputContainer) -> str:
    """A sentence on subtitles that players draw onto the pictures; empty where there are none."""
    for stream in container.streams.subtitles:
        flags, codec = stream.disposition, stream.codec_context.name if stream.codec_context else None
        shown = flags & type(flags).forced or flags & type(flags).default
        if codec in DRAWN or codec is None or shown:
            return (
                f"Players draw the subtitles of track {stream.index} ({codec or 'unknown codec'}) onto the pictures, "
                "and they were not judged. Give the film without them."
            )
    return ""


def _edits(stored: Sequence[Any], edited: Sequence[Any]) -> list[str]:
    """Sentences on an edit list that repeats or hides pictures; entries of the file's index, without it and with it."""
    shown = [entry.pos for entry in edited if not entry.is_discard]
    order = {entry.pos: place for place, entry in enumerate(stored)}
    places = [order.get(pos, -1) for pos in shown]
    if any(after <= before for before, after in pairwise(places)):
        return ["An edit list shows pictures again, or in another order, and players differ in following it."]
    hidden = len(stored) - len(shown)
    if hidden <= MAX_STRAY_SHARE * len(stored):
        return []
    return [
        f"An edit list hides {hidden} of the {len(stored)} pictures, as trimming does; these were not judged, and some "
        "players show them. Export the film anew."
    ]


def _boxes(file: OpenedFile) -> Iterator[str]:
    """Sentences on edits that change the speed, and on crops (`clap`), of an MP4 or MOV."""
    place = 0
    while len(head := file.read_at(place, 16)) >= 8:
        size, kind, start = int.from_bytes(head[:4], "big"), head[4:8], 8
        if size == 1 and len(head) == 16:
            size, start = int.from_bytes(head[8:], "big"), 16
        size = size or file.size - place
        if size < start:
            return
        body = file.read_at(place + start, min(size - start, MOST_BOX)) if kind in (b"elst", b"stsd") else b""
        if kind == b"elst" and any(media >= 0 and rate != 1 << 16 for media, rate in _edit_rates(body)):
            yield "An edit list changes the film's speed, and players differ in following it."
        if kind == b"stsd" and _is_cropped(body):
            yield "The file asks players to crop its pictures (clap), and some do; the whole pictures were judged."
        place += start if kind in BOXES else size


def _edit_rates(body: bytes) -> Iterator[tuple[int, int]]:
    """Start in the media, -1 for none, and rate in units of 2^-16, of each edit."""
    kind = ">Qqi" if body[:1] == b"\1" else ">Iii"
    whole = body[8 : 8 + (len(body) - 8) // struct.calcsize(kind) * struct.calcsize(kind)]
    return ((media, rate) for _, media, rate in struct.iter_unpack(kind, whole))


def _is_cropped(body: bytes) -> bool:
    """Whether a sample description has a clean aperture other than its whole picture."""
    place = body.find(b"clap")
    if place < 0 or len(body) < place + 36:
        return False
    width, width_of, height, height_of, x, _, y, _ = struct.unpack(">8i", body[place + 4 : place + 36])
    # The first entry begins at 8; its width and height are 32 bytes into it.
    coded = struct.unpack(">HH", body[40:44])
    return bool(x or y or (width, height) != (coded[0] * width_of, coded[1] * height_of))


def _elements(file: OpenedFile) -> Iterator[str]:
    """Sentences on crops and ordered chapters of a Matroska or WebM file."""
    place, seen = 0, set()
    while len(head := file.read_at(place, 12)) >= 2 and head[0]:
        width = 9 - head[0].bit_length()
        kind = int.from_bytes(head[:width], "big")
        if len(head) <= width or not head[width]:
            return
        size_width = 9 - head[width].bit_length()
        most = (1 << 7 * size_width) - 1
        size = int.from_bytes(head[width : width + size_width], "big") & most
        start = place + width + size_width
        if kind in (*PIXEL_CROPS, ORDERED) and any(file.read_at(start, min(size, 8))):
            seen.add(kind == ORDERED)
        # Of unknown size are elements that hold others.
        place = start if kind in ELEMENTS or size == most else start + size
    if False in seen:
        yield "The file asks players to crop its pictures (PixelCrop), and some do; the whole pictures were judged."
    if True in seen:
        yield "Ordered chapters show the film's parts in another order, and players differ in following them."
    if place > file.size:
        yield CUT


def _picture_ids(file: OpenedFile) -> set[int]:
    """Identifiers of the streams of pictures in a transport stream, also of those that begin late."""
    found: set[int] = set()
    first = np.frombuffer(file.read_at(0, SCANNED), np.uint8)
    size = max(PACKETS, key=lambda size: int(_packets(first, size).size))
    for place in range(0, file.size, SCANNED):
        # Packets that cross the border are seen once more.
        piece = np.frombuffer(file.read_at(place, SCANNED + 2 * size), np.uint8)
        packets = _packets(piece, size)
        begins = packets[(piece[packets + 1] & 0x40 > 0) & (piece[packets + 3] & 0x10 > 0)]
        body = begins + 4 + np.where(piece[begins + 3] & 0x20, 1 + piece[begins + 4].astype(int), 0)
        begins, body = begins[body < begins + 184], body[body < begins + 184]
        prefix = (piece[body] == 0) & (piece[body + 1] == 0) & (piece[body + 2] == 1) & (piece[body + 3] >> 4 == 0xE)
        ids = (piece[begins + 1].astype(int) & 0x1F) << 8 | piece[begins + 2]
        found |= set(ids[prefix].tolist())
    return found


def _packets(piece: np.ndarray[Any, np.dtype[np.uint8]], size: int) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Where packets begin whose next one begins in time."""
    return np.flatnonzero((piece[:-size] == SYNC) & (piece[size:] == SYNC))
