"""Video in: grey frames with their times, by PyAV.

Colour is not used: fringes and markers are grey, and so is the luma plane of the decoder.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from fractions import Fraction
from itertools import islice
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError
from moireid.files import AnyPath, as_path
from moireid.verifier.damage import DamageWatch
from moireid.verifier.opened_file import OpenedFile
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.reasons import Reason
from moireid.verifier.tracks import early_findings, listed_places, read_findings, tracks_of

if TYPE_CHECKING:
    import av


#: Demuxers of films.  FFmpeg reads playlists, text and pictures as "video" too, and a playlist may name other files.
FORMATS = frozenset(
    {"mov", "mp4", "m4a", "3gp", "3g2", "mj2", "matroska", "webm", "avi", "mpegts", "mpeg", "mpegvideo", "ogg", "flv"}
    | {"asf", "gif", "mxf", "nut", "h264", "hevc", "ivf", "obu", "yuv4mpegpipe", "mjpeg", "apng", "dv", "wtv", "rm"}
)
#: A 4K picture; larger ones are refused, as a badge that is in view as a whole has pixels enough then.
MOST_PIXELS = 4096 * 2304
#: An 8K picture.  A tiny file can claim 16000 x 16000 pixels in its header, and decoders hold many pictures at once.
MOST_CODED_PIXELS = 8192 * 4608
LIMITS = {"max_pixels": str(MOST_CODED_PIXELS)}
#: Streams of a film: pictures (of several lenses, or a cover), and all, such as sounds, subtitles and positions.
MOST_PICTURE_STREAMS, MOST_STREAMS = 4, 32
#: FFmpeg must open nothing but what it is given, must not even begin to read another format, as a playlist names other
#: files, and stops at the first stream too many.
OPENING = {
    "format_whitelist": ",".join(sorted(FORMATS)),
    "protocol_whitelist": "none",
    "max_streams": str(MOST_STREAMS + 1),
    **LIMITS,
}
#: A stream without a decoder costs nothing: FFmpeg would decode pictures of each one to describe it.
UNDECODED = {"codec_whitelist": "none"}
ADVICE = "give a film that a video player can play, such as an .mp4"
#: Formats whose first plane is the luma, and its bits; other pictures are converted to grey.
PLANAR_DEPTH = {
    **dict.fromkeys(("yuv420p", "yuv422p", "yuv444p", "yuvj420p", "yuvj422p", "yuvj444p", "nv12", "nv21"), 8),
    **dict.fromkeys(("yuv420p10le", "yuv422p10le", "yuv444p10le"), 10),
    **dict.fromkeys(("yuv420p12le", "yuv422p12le", "yuv444p12le"), 12),
}
#: Luma runs from 16 to 235 in video (ITU-R BT.601 and 709), unless the file says that it uses the full range.
VIDEO_CONTRAST = 219 / 255
VIDEO_RANGE = np.clip(np.rint((np.arange(256) - 16) / VIDEO_CONTRAST), 0, 255).astype(np.uint8)
FULL_RANGE = 2
#: Pixels further from square than this are a fault of the file, and nearer ones make no difference of a pixel.
MOST_ASPECT, LEAST_ASPECT = 4.0, 2e-4
#: Frames that the decoding thread hands over at a time, while it decodes as many more: 25 MB at 1080p.  Threads that
#: wait for each other at every frame take a tenth more processor time for decoding.
HANDED_OVER = 4
#: Times that differ by less than this are those of one frame.
SAME_S = 1e-4
#: Called while a film is read: frames read, and frames expected (None if the file does not say).
Progress = Callable[[int, int | None], None]


class Film:
    """A video file, opened.

    Parameters
    ----------
    path : str or Path
        The file.
    track : int, optional
        Number of the video track to read, as in `described`; None for the first one that is no cover picture.

    Raises
    ------
    MediaError
        Where it is absent, empty or no film that can be read, has no such track, or its pictures are larger than 4K.

    Notes
    -----
    Convention: the file is opened once; all results are of that file, even if its path names another one later.  Rows
    stay as they were coded: a phone's rotation flag is not followed.  Pixels that the file calls wide or tall are made
    square, as a player shows them; width and height are those of the square ones.
    Source: FFmpeg by PyAV.
    """

    def __init__(self, path: AnyPath, *, track: int | None = None) -> None:
        """Open the file and look at its tracks.  Raises: MediaError where there is none."""
        import av

        self.path = path = as_path(path)
        if not path.is_file():
            raise MediaError(f"video {path} does not exist or is no file; {ADVICE}")
        try:
            self._file = OpenedFile(path)
        except OSError as error:
            raise MediaError(f"video {path} cannot be read ({_reason(error)}); {ADVICE}") from error
        if self._file.size == 0:
            raise MediaError(f"video {path} is empty; {ADVICE}")
        try:
            self._by_stream = self._look_at_streams(track)
            with self._open() as container:
                stream = self._stream(container)
                if stream.codec_context is None:
                    raise MediaError(f"{path} is coded in a way that no decoder here knows; {ADVICE}")
                self._coded = stream.codec_context.width, stream.codec_context.height
                self.width, self.height = squared(self._coded, stream.sample_aspect_ratio)
                self.fps = float(stream.average_rate or stream.guessed_rate or 30)
                self.frames_expected = self.tracks.pictures
                self._codec = stream.codec_context.name
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise MediaError(f"{path} cannot be read as a video ({_reason(error)}); {ADVICE}") from error
        self._check_size()
        #: Which frames are damaged, as far as they were decoded.
        self.damage, self._turned = DamageWatch(self._codec), 0
        self._asked, self._met, self._early = track is not None, tuple[Reason, ...](), 0

    def _check_size(self) -> None:
        """Raise MediaError where the pictures are too large, or have no size."""
        pixels = self.width * self.height
        if pixels > MOST_PIXELS:
            raise MediaError(
                f"{self.path} has pictures of {self.width} x {self.height}, at most {MOST_PIXELS} pixels are read "
                "(4K); export it at 4K or less"
            )
        if not pixels:
            raise MediaError(f"{self.path} says nothing of its picture size, or that it is beyond 8K; {ADVICE}")

    def _look_at_streams(self, track: int | None) -> list[dict[str, str]]:
        """List the tracks, and give FFmpeg's options for each stream: only the track that is read is decoded.

        Raises: MediaError where there are too many streams, or none of pictures.
        """
        import av

        try:
            with av.open(self._file.reading(), options=OPENING | UNDECODED) as container:
                pictures, count = len(container.streams.video), len(container.streams)
                if pictures > MOST_PICTURE_STREAMS or count > MOST_STREAMS:
                    raise MediaError(
                        f"{self.path} has {pictures} streams of pictures, and {count} in all; at most "
                        f"{MOST_PICTURE_STREAMS} and {MOST_STREAMS} are read; export the pictures of the badge alone"
                    )
                #: Its video tracks, and what players may show other than the one that is read.
                self.tracks = tracks_of(container, self._unedited, self._file, track)
        except av.error.MemoryError as error:
            words = f"has more than {MOST_STREAMS} streams, or asks for more memory than there is"
            raise MediaError(f"{self.path} {words}; {ADVICE}") from error
        return [{} if number == self.tracks.chosen else UNDECODED for number in range(count)]

    def _unedited(self) -> av.container.InputContainer:
        """The file with all its pictures, also those that its edit lists hide.  Raises: FFmpegError."""
        import av

        return av.open(self._file.reading(), options=OPENING | UNDECODED | {"ignore_editlist": "1"})

    def _stream(self, container: av.container.InputContainer) -> av.VideoStream:
        """The track that is read."""
        return next(one for one in container.streams.video if one.index == self.tracks.chosen)

    def _open(self) -> av.container.InputContainer:
        """The file with its streams described.  Raises: FFmpegError."""
        import av

        try:
            return av.open(self._file.reading(), options=OPENING, stream_options=self._by_stream)
        except ValueError:
            # In formats without a header, as MPEG-TS, no stream is known before they are read.
            return av.open(self._file.reading(), options=OPENING)

    def described(self) -> dict[str, Any]:
        """Describe the film as the `input` object of ``verify --json`` does.

        Returns
        -------
        dict
            Path, SHA-256 of the file that was read, the decoder's version, width and height of its pictures in px, and
            frames a second; its tracks; and of the pictures read by now, how many are interlaced, and the quarter
            turns, anticlockwise, by which players turn them.

        Raises
        ------
        MediaError
            Where the file changed since it was opened.
        """
        sha256, decoder = self._file.sha256(), decoder_version()
        size = {"width": self.width, "height": self.height, "fps": self.fps}
        shown = {"tracks": self.tracks.tracks, "interlaced": self.damage.interlaced, "quarter_turns": self._turned}
        return {"path": str(self.path), "sha256": sha256, "decoder": decoder, **size, **shown}

    def findings(self) -> tuple[Reason, ...]:
        """Findings on its tracks, and on damage in the one that was judged, once it was read."""
        read = self._met + early_findings(self._early, len(self.damage.marks))
        read += self.damage.findings(self.frames_expected)
        return self.tracks.findings + (read if self.tracks.judged else ())

    def frames(self) -> Generator[Frame, None, None]:
        """Decode frame by frame, from the beginning, one frame in memory at a time.

        Yields
        ------
        Frame
            In the file's order.

        Raises
        ------
        MediaError
            Where nothing at all decodes, or where the pictures change their size.

        Notes
        -----
        Convention: an error of the decoder ends nothing; it is noted in `damage`, as is where the file breaks off.
        """
        import av

        self.damage.marks.clear()
        self.damage = damage = DamageWatch(self._codec, self.damage.marks)
        self._early = count = 0
        try:
            with closing(self._decoded(damage=damage)) as pictures:
                for picture in pictures:
                    time_s = float(picture.time) if picture.time is not None else count / self.fps
                    self._early += time_s < 0
                    if (picture.width, picture.height) != self._coded:
                        raise MediaError(
                            f"{self.path} changes its picture size from {self._coded[0]} x {self._coded[1]} to "
                            f"{picture.width} x {picture.height} at frame {count}; export it anew at one size"
                        )
                    seen = picture_of(picture)
                    if count == 0:
                        self._turned = round(picture.rotation / 90) % 4
                    if self._coded != (self.width, self.height):
                        seen = Picture(self._sized(seen.whole))
                    yield Frame(count, time_s, seen)
                    count += 1
        except (av.error.FFmpegError, OSError, ValueError) as error:
            if not (count and isinstance(error, av.error.InvalidDataError)):
                why = _reason(error)
                raise MediaError(f"{self.path} cannot be decoded after frame {count} ({why}); {ADVICE}") from error
            damage.breaks_off = True
        if count == 0:
            raise MediaError(f"{self.path} holds no picture that decodes; {ADVICE}")

    def picture(self, index: int, time_s: float | None = None) -> tuple[NDArray[np.uint8], int]:
        """Decode one frame in colour, for people to look at.

        Parameters
        ----------
        index : int
            Its number, from 0.
        time_s : float, optional
            Its time in the file, s; it is sought by that, and without it by counting from the beginning.

        Returns
        -------
        array (height, width, 3) of uint8
            Red, green, blue; rows as they were coded.
        int
            Quarter turns, anticlockwise, after which it is as a player shows it.

        Raises
        ------
        MediaError
            Where there is no such frame, or it cannot be decoded.
        """
        import av

        try:
            with closing(self._decoded(time_s)) as pictures:
                for count, picture in enumerate(pictures):
                    late = picture.time is not None and time_s is not None and picture.time >= time_s - SAME_S
                    if late or (time_s is None and count == index):
                        if (picture.width, picture.height) != self._coded:
                            break
                        return self._sized(picture.to_ndarray(format="rgb24")), round(picture.rotation / 90) % 4
        except (av.error.FFmpegError, OSError, ValueError) as error:
            raise MediaError(f"{self.path} cannot be decoded at frame {index} ({_reason(error)}); {ADVICE}") from error
        raise MediaError(f"{self.path} has no frame {index}; {ADVICE}")

    def _decoded(self, from_s: float | None = None, damage: DamageWatch | None = None) -> Generator[Any, None, None]:
        """Pictures as FFmpeg has them; from_s: time in the file of one after the first of them, s."""
        damage = damage or DamageWatch(self._codec)
        with self._open() as container:
            stream = self._stream(container)
            if from_s is not None and stream.time_base:
                container.seek(round(from_s / stream.time_base), stream=stream)
            stream.codec_context.options = LIMITS
            listed, read = listed_places(container, stream), set[int]()
            yield from decoded_pictures(container, stream, damage, read if listed else None)
            self._met = read_findings(container, listed, read, asked=self._asked)

    def _sized(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """A coded picture with square pixels."""
        size = self.width, self.height
        return picture if self._coded == size else np.asarray(cv2.resize(picture, size), np.uint8)

    def frames_ahead(self) -> Iterator[Frame]:
        """Decode by a thread of its own, while the caller is busy with the frames before.

        Yields
        ------
        Frame
            As `frames`.

        Raises
        ------
        MediaError
            As `frames`, at the frame where it happened.

        Notes
        -----
        The thread ends with the iterator, also where that is left early, or by an error or an interrupt.
        A process that keeps to one thread decodes in its own.
        """
        frames = self.frames()
        if one_thread():
            yield from frames
            return
        with ThreadPoolExecutor(1, "decode") as worker:
            ahead = worker.submit(_taken, frames)
            try:
                whole = True
                while whole:
                    (taken, error), ahead = ahead.result(), worker.submit(_taken, frames)
                    yield from taken
                    if error is not None:
                        raise error
                    whole = len(taken) == HANDED_OVER
            finally:
                worker.shutdown(wait=True, cancel_futures=True)
                frames.close()


def decoded_pictures(
    container: av.container.InputContainer,
    stream: av.VideoStream,
    damage: DamageWatch,
    places: set[int] | None = None,
) -> Generator[av.VideoFrame, None, None]:
    """Pictures as FFmpeg has them, past errors of the decoder.

    Parameters: damage: takes in each packet and picture; places: takes in those of the packets in the file, bytes.
    """
    import av
    from av.codec.context import Flags

    # Threads of the decoder wait for one another, and hold more pictures in memory (docs/decisions/films.md).
    stream.codec_context.thread_count = 1
    # So that each picture has the number of its packet.
    stream.codec_context.copy_opaque = True
    # Pictures before the first key picture come too, flagged as damaged: many players show them.
    stream.codec_context.flags |= Flags.output_corrupt
    for number, packet in enumerate(_packets(container, stream)):
        packet.opaque = number
        if places is not None and packet.pos is not None:
            places.add(packet.pos)
        damage.packet(number, packet)
        decoded: list[av.VideoFrame] = []
        try:
            decoded = packet.decode()
        except av.error.MemoryError:
            raise
        except av.error.FFmpegError:
            damage.error(number)
        for picture in decoded:
            damage.frame(number if picture.opaque is None else picture.opaque, picture)
            yield picture


def _packets(container: av.container.InputContainer, stream: av.VideoStream) -> Iterator[av.Packet]:
    """The packets of a stream.  At the end PyAV fails at streams that began after it opened the file."""
    with suppress(IndexError):
        yield from container.demux(stream)


def _taken(frames: Iterator[Frame]) -> tuple[list[Frame], MediaError | None]:
    """The next frames, at most `HANDED_OVER`, and the error before which they came."""
    taken: list[Frame] = []
    try:
        taken.extend(islice(frames, HANDED_OVER))
    except MediaError as error:
        return taken, error
    return taken, None


def squared(coded: tuple[int, int], aspect: Fraction | None) -> tuple[int, int]:
    """Width and height of a picture once its pixels are square, none smaller than coded; aspect: width over height."""
    wide = float(aspect) if aspect else 1.0
    if not 1 / MOST_ASPECT <= wide <= MOST_ASPECT or abs(wide - 1) < LEAST_ASPECT:
        return coded
    return (round(coded[0] * wide), coded[1]) if wide > 1 else (coded[0], round(coded[1] / wide))


def one_thread() -> bool:
    """Whether this process is limited to one thread, by `cv2.setNumThreads` or as there is one processor."""
    return bool(cv2.getNumThreads() == 1)


def decoder_version() -> str:
    """The decoder of films, with its version."""
    import av

    return f"FFmpeg {av.ffmpeg_version_info} (PyAV {av.__version__})"


def picture_of(picture: av.VideoFrame) -> Picture:
    """The picture's brightness, for any coded range and depth.

    The luma plane of the decoder is used if there is one: converting a picture costs more than decoding it.  A phone's
    rotation flag is ignored: markers are found at any angle, and the rows stay those of the rolling shutter.
    """
    depth = PLANAR_DEPTH.get(picture.format.name)
    if depth is None:
        return Picture(np.asarray(picture.to_ndarray(format="gray"), np.uint8))
    # The array holds the decoded picture, and the decoder takes other memory for the next one.
    plane = picture.planes[0]
    if depth == 8:
        rows = np.frombuffer(plane, np.uint8).reshape(picture.height, -1)[:, : picture.width]
    else:
        deep = np.frombuffer(plane, np.uint16).reshape(picture.height, -1)[:, : picture.width]
        rows = (deep >> (depth - 8)).astype(np.uint8)
    full = picture.format.name.startswith("yuvj") or picture.color_range == FULL_RANGE
    return Picture(rows) if full else Picture(rows, VIDEO_RANGE, VIDEO_CONTRAST)


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).split("\n")[0][:120]
