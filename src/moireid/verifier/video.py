"""Video in: grey frames with their times, by PyAV.

Left out: colour.  Fringes and markers are grey, and the luma plane of the decoder is already that.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError

#: Demuxers of films.  FFmpeg reads playlists, text and pictures as "video" too, and a playlist may name other files.
FORMATS = frozenset(
    {"mov", "mp4", "m4a", "3gp", "3g2", "mj2", "matroska", "webm", "avi", "mpegts", "mpeg", "mpegvideo", "ogg", "flv"}
    | {"asf", "gif", "mxf", "nut", "h264", "hevc", "ivf", "obu", "yuv4mpegpipe", "mjpeg", "apng", "dv", "wtv", "rm"}
)
#: No film may make the reader open an address.
LOCAL = {"protocol_whitelist": "file"}
ADVICE = "give a film that a video player can play, such as an .mp4"


@dataclass(frozen=True)
class Frame:
    """One picture: luma (height, width) uint8, its number from 0, and its time in seconds."""

    index: int
    time_s: float
    luma: NDArray[np.uint8]


class Film:
    """A video file, opened: `frames()` reads it from the beginning, one frame in memory at a time."""

    def __init__(self, path: Path) -> None:
        """Open the file and look at its first video stream.  Raises: MediaError where there is none."""
        import av

        if not path.is_file():
            raise MediaError(f"video {path} does not exist or is no file; {ADVICE}")
        if path.stat().st_size == 0:
            raise MediaError(f"video {path} is empty; {ADVICE}")
        try:
            with av.open(str(path.absolute()), options=LOCAL) as container:
                kinds = set(container.format.name.split(","))
                if not kinds & FORMATS:
                    raise MediaError(f"{path} is read as {container.format.name}, which is no film; {ADVICE}")
                if not container.streams.video:
                    raise MediaError(f"{path} holds no video stream; {ADVICE}")
                stream = container.streams.video[0]
                self.width, self.height = stream.codec_context.width, stream.codec_context.height
                self.fps = float(stream.average_rate or stream.guessed_rate or 30)
                self.frames_expected = int(stream.frames) or None
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise MediaError(f"{path} cannot be read as a video ({_reason(error)}); {ADVICE}") from error
        if not self.width or not self.height:
            raise MediaError(f"{path} says nothing of its picture size; {ADVICE}")
        self.path = path

    def frames(self) -> Iterator[Frame]:
        """Decode frame by frame.

        Raises: MediaError where nothing at all decodes, or where the file breaks off within.
        """
        import av

        count = 0
        try:
            with av.open(str(self.path.absolute()), options=LOCAL) as container:
                stream = container.streams.video[0]
                stream.thread_type = "AUTO"
                for picture in container.decode(stream):
                    time_s = float(picture.time) if picture.time is not None else count / self.fps
                    luma = picture.to_ndarray(format="gray")
                    if luma.shape != (self.height, self.width):
                        raise MediaError(
                            f"{self.path} changes its picture size from {self.width} x {self.height} to "
                            f"{luma.shape[1]} x {luma.shape[0]} at frame {count}; export it anew at one size"
                        )
                    yield Frame(count, time_s, luma)
                    count += 1
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise MediaError(f"{self.path} breaks off after frame {count} ({_reason(error)}); {ADVICE}") from error
        if count == 0:
            raise MediaError(f"{self.path} holds no picture that decodes; {ADVICE}")


def file_sha256(path: Path) -> str:
    """Hex SHA-256 of a file."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).split("\n")[0][:120]
