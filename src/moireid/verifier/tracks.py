"""The video tracks of a file, and what players may show of it other than its one track, picture by picture.

Players differ in which of several tracks they show, in what they crop, and in whether they follow edit lists and
chapters.  A verdict is about what every player shows, so each such thing is a finding, and most leave the film
inconclusive.  Cover pictures count as no track.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from threading import Lock
from typing import TYPE_CHECKING, Any

from moireid.errors import MediaError
from moireid.verifier.limits import MAX_STRAY_SHARE
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.reasons import Reason

if TYPE_CHECKING:
    import av

#: Subtitles that a player draws in any case: pictures, and text that can draw shapes of any size.
DRAWN = frozenset({"dvbsub", "dvdsub", "pgssub", "xsub", "ass", "ssa"})
#: Elements of Matroska: that which holds all others; chapters, in which an edition comes first but for a checksum or a
#: filler; an edition's flag that they are ordered.
SEGMENT = b"\x18\x53\x80\x67"
CHAPTERS_BEGIN = re.compile(rb"\x10\x43\xa7\x70(?=.{1,64}\x45\xb9)", re.DOTALL)
ORDERED = re.compile(rb"\x45\xdd")
#: Bytes of chapters in which that flag is looked for.
MOST_CHAPTERS = 1 << 20
#: Bytes of a file that are looked at together.
SCANNED = 1 << 22
#: Bytes of a chunk's name and size, before its content; an AVI's index gives the places of the names.
CHUNK = 8
AGAIN = "An edit list shows pictures again, or in another order, and players differ in following it."
CROPPED = "The file asks players to crop its pictures, and some do; the whole pictures were judged."
LISTED = "The file's index lists other pictures than those judged, which follow one another; some players show those."
CHAPTERS = "Ordered chapters show the film's parts in another order, and players differ in following them."
CUT = "The file breaks off within a part of it; it was judged as far as it goes."
#: FFmpeg's log has one level for all threads.
LOG = Lock()


@dataclass(frozen=True)
class FilmTracks:
    """The tracks of a file as in `input.tracks`, the number of the one that is read, and findings on what players may
    show instead.

    judged: whether it may be judged, as it is the only one or was asked for; pictures: that it has, as the file says.
    """

    tracks: list[dict[str, Any]]
    chosen: int
    judged: bool
    findings: tuple[Reason, ...]
    pictures: int | None


def tracks_of(
    container: av.container.InputContainer,
    unedited: Callable[[], av.container.InputContainer],
    file: OpenedFile,
    wanted: int | None,
) -> FilmTracks:
    """List the tracks of a file.

    Parameters: container: the opened file; unedited: opens it without its edit lists; wanted: the track asked for.
    Raises: MediaError where there is no track, or none of that number.
    """
    found = picture_tracks(container)
    if not found:
        raise MediaError(f"{file.path} holds no video stream; give a film that a video player can play")
    tracks = [_track(stream) for stream in found]
    named = "; ".join(f"track {one['index']}: {one['codec']} {one['width']} x {one['height']}" for one in tracks)
    stream = next((one for one in found if wanted in (None, one.index)), None)
    if stream is None:
        raise MediaError(f"{file.path} has no video track {wanted}; give one of these: {named}")
    doubts, pictures = [_subtitles(container), _crop(container)], stream.frames or None
    formats = container.format.name.split(",")
    if "mov" in formats:
        # An entry is no longer valid once its file is closed.
        with unedited() as whole:
            stored = [entry.pos for entry in whole.streams[stream.index].index_entries]
        shown = [entry.pos for entry in stream.index_entries if not entry.is_discard]
        doubts.append(_edits(stored, shown))
        pictures = pictures and len(shown)
    elif "matroska" in formats:
        doubts += _elements(file)
    reasons = [Reason("tracks", "undecided", None, None, "", doubt) for doubt in doubts if doubt not in ("", CUT)]
    reasons += [Reason("damaged", "note", None, None, "", CUT)] if CUT in doubts else []
    count = len(tracks)
    if count > 1 and wanted is None:
        text = (
            f"The file has {count} video tracks ({named}), and players differ in which one they show. Nothing was "
            "judged: say which track is meant, or give a file with one."
        )
        reasons.insert(0, Reason("tracks", "undecided", float(count), 1.0, "tracks", text))
    elif count > 1:
        text = f"Track {wanted} of the file's {count} video tracks is judged, as asked; players may show another one."
        reasons.insert(0, Reason("tracks", "note", float(count), 1.0, "tracks", text))
    judged = count == 1 or wanted is not None
    for track in tracks:
        track["chosen"] = judged and track["index"] == stream.index
    return FilmTracks(tracks, stream.index, judged, tuple(reasons), pictures)


def picture_tracks(container: av.container.InputContainer) -> list[av.VideoStream]:
    """The video tracks that are no cover pictures."""
    # A track of chapters' pictures has the flag of a cover too, but is a track that players may show.
    return [s for s in container.streams.video if "attached_pic" not in _flags(s) or "timed_thumbnails" in _flags(s)]


def _flags(stream: Any) -> set[str]:
    return {flag.name for flag in stream.disposition}


def _track(stream: Any) -> dict[str, Any]:
    coded = stream.codec_context
    size = {"width": (coded and coded.width) or None, "height": (coded and coded.height) or None}
    return {"index": stream.index, "codec": coded and coded.name, **size, "default": "default" in _flags(stream)}


def _subtitles(container: av.container.InputContainer) -> str:
    """A sentence on subtitles that players draw onto the pictures; empty where there are none."""
    for stream in container.streams.subtitles:
        codec = stream.codec_context.name if stream.codec_context else None
        if codec is None or codec in DRAWN or _flags(stream) & {"forced", "default"}:
            return (
                f"Players draw the subtitles of track {stream.index} ({codec}) onto the pictures, and they were not "
                "judged. Give the film without them."
            )
    return ""


def _crop(container: av.container.InputContainer) -> str:
    """A sentence on crops by the container: `clap` of MP4, PixelCrop of Matroska."""
    return CROPPED if re.search(r"Frame Cropping: [0/]*[1-9]", _described(container)) else ""


def _described(container: av.container.InputContainer) -> str:
    """FFmpeg's own description of a file.  Only that has crops, and streams that begin after the file was opened."""
    import av

    with LOG:
        level = av.logging.get_level()
        av.logging.set_level(av.logging.INFO)
        described: str = container.dumps_format()
        av.logging.set_level(level)
    return described


def listed_places(container: av.container.InputContainer, stream: av.VideoStream) -> set[int]:
    """Where the file's index says that pictures are, in a format in which some players follow it and FFmpeg does not;
    empty where there is none.  To be asked before the file is read.
    """
    return {entry.pos + CHUNK for entry in stream.index_entries} if container.format.name == "avi" else set()


def read_findings(
    container: av.container.InputContainer, listed: set[int], read: set[int], *, asked: bool
) -> tuple[Reason, ...]:
    """Findings on what FFmpeg met only while it read the file, once it read all of it: more video tracks, and an index
    that lists other pictures than those that follow one another in the file.

    Parameters: listed: as `listed_places`; read: places of the pictures that were read; asked: whether their track was
    asked for.
    """
    found = re.findall(r"Stream #0:(\d+).*?: Video:", _described(container))
    late = sum(int(number) >= len(container.streams) for number in found)
    reasons: tuple[Reason, ...] = ()
    if late:
        text = f"Where the file goes on, it has more video tracks ({late}), and players may show those."
        reasons = (Reason("tracks", "note" if asked else "undecided", float(late), 0.0, "tracks", text),)
    if len(listed - read) > MAX_STRAY_SHARE * len(listed):
        reasons += (Reason("tracks", "undecided", None, None, "", LISTED),)
    return reasons


def early_findings(early: int, count: int) -> tuple[Reason, ...]:
    """The finding on pictures before the film's time 0, where an edit list of an MP4 in fragments puts what it hides.

    Parameters: early: number of such pictures; count: of all.
    """
    if early <= MAX_STRAY_SHARE * count:
        return ()
    text = f"{early} of {count} pictures come before the film's time 0; they were judged, and some players hide them."
    return (Reason("tracks", "undecided", early / count, MAX_STRAY_SHARE, "share", text),)


def _edits(stored: Sequence[int], shown: Sequence[int]) -> str:
    """A sentence on an edit list that repeats or hides pictures, by the pictures' places in the file."""
    order = {place: number for number, place in enumerate(stored)}
    if any(order.get(after, -1) <= order.get(before, -1) for before, after in pairwise(shown)):
        return AGAIN
    hidden = len(stored) - len(shown)
    if hidden <= MAX_STRAY_SHARE * len(stored):
        return ""
    return (
        f"An edit list hides {hidden} of the {len(stored)} pictures, as trimming does; these were not judged, and some "
        "players show them. Export the film anew."
    )


def _elements(file: OpenedFile) -> list[str]:
    """Sentences on ordered chapters, and on a last element that is not whole, of a Matroska or WebM file."""
    place = 0
    while place < file.size and len(head := file.read_at(place, 12)) == 12 and head[0]:
        width = 9 - head[0].bit_length()
        size, size_width = _size(head[width:])
        start = place + width + size_width
        # Of unknown size are elements that hold others.
        place = start if head[:width] == SEGMENT or size is None else start + size
    return ([CHAPTERS] if _orders(file) else []) + ([CUT] if place > file.size else [])


def _size(head: bytes) -> tuple[int | None, int]:
    """The size of an element, None if unknown, and the number of bytes that state it."""
    width = 9 - max(head[0].bit_length(), 1)
    most = (1 << 7 * width) - 1
    size = int.from_bytes(head[:width], "big") & most
    return (None if size == most else size), width


def _orders(file: OpenedFile) -> bool:
    """Whether any chapters are ordered.  The file's table of contents may name a place within another element, so all
    places are looked at.
    """
    for place in range(0, file.size, SCANNED):
        part = file.read_at(place, SCANNED + MOST_CHAPTERS)
        end = 0
        while found := CHAPTERS_BEGIN.search(part, end):
            size, width = _size(part[found.end() : found.end() + 8])
            start = found.end() + width
            # Each byte is looked at once, however many chapters a file seems to have.
            end = start + min(size or MOST_CHAPTERS, MOST_CHAPTERS)
            for flag in ORDERED.finditer(part, start, end):
                length, width = _size(part[flag.end() : flag.end() + 8] + b"\x81")
                first = flag.end() + width
                if any(part[first : first + min(length or 0, 8)]):
                    return True
    return False
