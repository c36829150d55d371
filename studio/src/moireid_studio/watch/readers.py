"""Pictures of a container: a file that may still grow, or a pipe; and the inbox in which pictures wait.

The process that started us reads the bytes of a pipe (`PipeBytes`).  Formats are those of films.
"""

from __future__ import annotations

import math
import os
import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from moireid.errors import MediaError
from moireid.verifier.damage import DAMAGED, REORDERED, DamageWatch
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.picture import Picture
from moireid.verifier.tracks import picture_tracks
from moireid.verifier.video import FORMATS, OPENING, decoded_pictures, picture_of, squared
from moireid_studio.watch.order import LEAST_SIDE, MOST_PIXELS, PIECE, Data, Patience
from moireid_studio.watch.source import Source

if TYPE_CHECKING:
    import av


#: Pictures that wait; with 4K pictures that is 80 MB.
AHEAD = 8


@dataclass(frozen=True)
class TimedPicture:
    """A picture, when it was taken by its own clock, and when it came by ours, s."""

    picture: Picture
    claimed_s: float
    arrival_s: float


class Inbox:
    """Pictures in order, and messages, which come first.

    A source that does not wait for us loses its oldest picture where too many wait; one that does is held up.
    """

    def __init__(self, *, waits: bool) -> None:
        self._waits, self._taken, self._messages = waits, deque[TimedPicture | None](), deque[Any]()
        self._room = threading.Condition()
        #: Pictures that came faster than they could be judged.
        self.lost = 0

    def put(self, message: Any) -> None:
        """Leave a message."""
        with self._room:
            self._messages.append(message)
            self._room.notify_all()

    def put_picture(self, taken: TimedPicture) -> None:
        """Leave a picture; a source that waits does so until there is room."""
        with self._room:
            if self._waits:
                self._room.wait_for(lambda: len(self._taken) < AHEAD)
            elif len(self._taken) >= AHEAD:
                self._taken.popleft()
                self.lost += 1
            self._taken.append(taken)
            self._room.notify_all()

    def put_last(self, message: Any) -> None:
        """Leave a message that counts once the pictures before it are judged."""
        with self._room:
            self._room.wait_for(lambda: not self._taken, timeout=60)
            self._messages.append(message)
            self._room.notify_all()

    def get(self, seconds: float) -> Any:
        """The next message or picture; None where nothing comes for so long."""
        with self._room:
            if not self._room.wait_for(lambda: self._messages or self._taken, timeout=seconds):
                return None
            item = self._messages.popleft() if self._messages else self._taken.popleft()
            self._room.notify_all()
            return item


#: Time between two looks at a file that has come to its end, s.
LOOK_S = 0.1
#: Boxes of an MP4 file that are looked at to see whether it can be read as it grows.
MOST_BOXES = 64


class GrowingFile:
    """A file read on, until it has not grown for some seconds.

    Convention: it has no `seek`, so that the decoder never looks for an end that is not there yet.
    """

    def __init__(self, path: Path, grown_s: float) -> None:
        self._stream, self.name = path.open("rb", buffering=0), str(path)
        self._grown_s, self._whole = grown_s, False

    def read(self, count: int) -> bytes:
        """The next bytes; b"" at the end."""
        last_s = time.monotonic() + self._grown_s
        while not self._whole:
            if piece := self._stream.read(count):
                return piece
            # An older file was not written to for a while.
            age_s = time.time() - os.fstat(self._stream.fileno()).st_mtime
            self._whole = age_s > self._grown_s or time.monotonic() > last_s
            time.sleep(LOOK_S)
        return b""


def is_closed(path: Path) -> bool:
    """Whether a file can only be read once it is whole: an MP4 file whose table of frames is behind its pictures.

    Source: ISO/IEC 14496-12, section 4.2: each box is its size (four bytes, big endian; 1: eight bytes follow its name)
        and its name.
    """
    with path.open("rb") as stream:
        for _ in range(MOST_BOXES):
            head = stream.read(8)
            if len(head) < 8 or head[4:] in (b"moov", b"moof"):
                return False
            if head[4:] == b"mdat":
                return True
            size = int.from_bytes(head[:4], "big")
            size, read = (int.from_bytes(stream.read(8), "big"), 16) if size == 1 else (size, 8)
            if size < read:
                return False
            stream.seek(size - read, os.SEEK_CUR)
    return False


class BytesRefusal(OSError):
    """Bytes that the process which started us does not give, with its reason."""


class PipeBytes:
    """The pipe's bytes, which the process that started us reads, with what the decoder's library expects of a file.

    The decoder's thread asks and waits; another thread hands on what comes (`give`).
    """

    name = "-"

    def __init__(self, send: Callable[[dict[str, Any]], None]) -> None:
        self._send, self._answers = send, queue.SimpleQueue[Data]()
        #: When the last bytes came, by our clock, s; and how many came in all.
        self.arrival_s, self.count = time.monotonic(), 0

    def read(self, count: int) -> bytes:
        """The next bytes; b"" at the end.  Raises: BytesRefusal where they cannot be read."""
        self._send({"want": min(count, PIECE)})
        answer = self._answers.get()
        if answer.error is not None:
            raise BytesRefusal(5, answer.error)
        self.arrival_s, self.count = answer.arrival_s, self.count + len(answer.content)
        return answer.content

    def give(self, data: Data) -> None:
        """Hand on what came."""
        self._answers.put(data)


LIMITS = {"max_pixels": str(MOST_PIXELS)}
#: As a film's file: nothing is opened by the decoder's library itself.
CLOSED = OPENING | LIMITS


def pictures(source: Source, piped: PipeBytes, inbox: Inbox, patience: Patience) -> None:
    """Decode a source into the inbox, until it ends.

    Raises: MediaError in a sentence where it cannot be opened, or breaks off.
    """
    import av

    try:
        with _opened(source, piped, patience) as container:
            _check(source, container)
            _decode(container, inbox, _clock(source, piped))
    except BytesRefusal as error:
        raise MediaError(f"{error.strerror}; {_advice(source)}") from error
    except (av.error.FFmpegError, OSError, ValueError) as error:
        if source.kind == "pipe" and not piped.count:
            raise MediaError(f"{source.shown} ended before anything came; {_advice(source)}") from error
        raise MediaError(f"{source.shown} cannot be read ({_reason(error)}); {_advice(source)}") from error


def _opened(source: Source, piped: PipeBytes, patience: Patience) -> av.container.InputContainer:
    import av

    if source.kind == "pipe":
        return av.open(piped, options=CLOSED)
    path = Path(source.text)
    if is_closed(path):
        return av.open(OpenedFile(path).reading(), options=CLOSED)
    return av.open(GrowingFile(path, patience.grown_s), options=CLOSED)


def _check(source: Source, container: av.container.InputContainer) -> None:
    if not FORMATS & set(container.format.name.split(",")):
        raise MediaError(f"{source.shown} is read as {container.format.name}, which is no film; {_advice(source)}")
    count = len(picture_tracks(container))
    if count > 1:
        shown = f"{source.shown} has {count} video tracks, and players differ in which one they show"
        raise MediaError(f"{shown}; give it with one, or judge the file with track=")
    if not count:
        raise MediaError(f"{source.shown} holds no video stream; {_advice(source)}")


def _decode(container: av.container.InputContainer, inbox: Inbox, arrival: Callable[[], float]) -> None:
    (stream,) = picture_tracks(container)
    if stream.codec_context is None:
        raise MediaError("it is coded in a way that no decoder here knows")
    stream.codec_context.options = LIMITS
    fps, damage = float(stream.average_rate or stream.guessed_rate or 30), DamageWatch(stream.codec_context.name)
    timed = seen = False
    for count, decoded in enumerate(decoded_pictures(container, stream, damage)):
        seen = True
        # As in a film, what the decoder found damaged is not judged; a stream may be endless, so few marks are kept.
        del damage.marks[:-REORDERED]
        if damage.marks[-1] == DAMAGED:
            continue
        # Where none has a time, as in a bare stream of H.264, they are counted; a single one without is left out.
        timed = timed or decoded.time is not None
        claimed_s = float(decoded.time) if decoded.time is not None else math.nan if timed else count / fps
        inbox.put_picture(TimedPicture(small_enough(decoded, stream.sample_aspect_ratio), claimed_s, arrival()))
    if damage.pending and not seen:
        raise MediaError("none of its pictures can be decoded; it cannot be read as a video")


def small_enough(decoded: Any, aspect: Any = None) -> Picture:
    """A decoded picture with square pixels.  Raises: MediaError where it is too large or too small."""
    if decoded.width * decoded.height > MOST_PIXELS:
        raise MediaError(f"pictures of {decoded.width} x {decoded.height} are larger than 4K; send smaller ones")
    if min(decoded.width, decoded.height) < LEAST_SIDE:
        raise MediaError(
            f"pictures of {decoded.width} x {decoded.height} are too small; {LEAST_SIDE} px a side are needed"
        )
    picture, coded = picture_of(decoded), (decoded.width, decoded.height)
    whole = squared(coded, aspect)
    if whole == coded:
        return picture
    if whole[0] * whole[1] > MOST_PIXELS:
        raise MediaError(f"pictures of {whole[0]} x {whole[1]} are larger than 4K; send smaller ones")
    return Picture(np.asarray(cv2.resize(picture.whole, whole), np.uint8))


def _clock(source: Source, piped: PipeBytes) -> Callable[[], float]:
    """When the picture that was just decoded came: with the last bytes that were read for it."""
    return (lambda: piped.arrival_s) if source.kind == "pipe" else time.monotonic


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).split("\n")[0][:160]


def _advice(source: Source) -> str:
    if source.kind == "file":
        return "give a film of at most 4K that plays; one that is still recorded must be .mkv, .ts or fragmented .mp4"
    return "send MPEG-TS, Matroska or another format that needs no turning back, with pictures of at most 4K"
