"""Video files: codecs, and recipes that worsen a film as chat programs do.

Convention: luma runs from 16 to 235 in the file, a player stretches it back; a frame's number is its time in units of
one over the frame rate, so a dropped frame leaves a gap in time and no other frame moves.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError, SpecError
from moireid.simulate.recording.sensor import CURVES

#: The encoder of each codec: its name, its usual constant rate factor, and options.  What it writes depends on how many
#: frames it codes at once: the number is fixed, so that a film is the same on every machine.  Of x264's fastest preset
#: what makes files small is on again: pixels are as good and files as small as with "veryfast", in 60 % of its time or
#: less.  Fringes come out less even: the gain measured on a mask film is spread by 0.0183, with "veryfast" by 0.0141,
#: where 0.02 is allowed.
X264 = "bframes=1:cabac=1:deblock=1:8x8dct=1:subme=2:aq-mode=1:mbtree=1:rc-lookahead=10"
ENCODERS: dict[str, tuple[str, int, dict[str, str]]] = {
    "h264": ("libx264", 23, {"preset": "ultrafast", "threads": "2", "x264-params": X264}),
    "h265": ("libx265", 28, {"preset": "superfast", "x265-params": "log-level=error"}),
}
#: The colour of a grey picture.
GREY = 128
#: Full-range counts to those of a video file.
TO_VIDEO = np.rint(16 + np.arange(256) * 219 / 255).astype(np.uint8)


@dataclass(frozen=True)
class Pass:
    """One encoding: codec; crf, quality on the encoder's own scale, None for its usual one; or kbps, a bit rate, in
    its place; height: rows to scale down to, None to keep them; turns: rows of spells that take turns, scaled back to
    those of `height`; transfer: of `sensor.CURVES`, with 10 bits; aspect: width of a pixel by its height, for the file.

    Convention: `turns` are for passes before the last; `codec`, `transfer` and `aspect` for the last.
    """

    codec: str = "h264"
    crf: int | None = None
    kbps: int | None = None
    height: int | None = None
    turns: tuple[int, ...] = ()
    transfer: str | None = None
    aspect: Fraction | None = None


@dataclass(frozen=True)
class Recipe:
    """What happens to a film on its way: the share of frames dropped, then encodings one after the other."""

    passes: tuple[Pass, ...]
    dropped: float = 0.0


#: Recipes by name.  The sizes and rates are typical of chat programs, not measured of one.
RECIPES: dict[str, Recipe] = {
    # A clip sent by a chat program.
    "chat": Recipe((Pass(height=360, kbps=700),)),
    # A live call: smaller rate, and frames lost.
    "call": Recipe((Pass(height=360, kbps=350),), dropped=0.15),
    # A meeting's main speaker: 720 rows at the rate that meeting programs ask for, a frame in twenty lost.
    "meeting": Recipe((Pass(height=720, kbps=1200),), dropped=0.05),
    # Full size at a low bit rate.
    "low": Recipe((Pass(kbps=1500),)),
    # Sent, saved and sent on.
    "double": Recipe((Pass(height=720, crf=28), Pass(height=540, kbps=900))),
    # A phone that drops frames and records when the others were taken.
    "vfr": Recipe((Pass(),), dropped=0.25),
}


def recipe_for(name: str | None, crf: int | None) -> Recipe:
    """A recipe by name, or a single pass of a quality.  Raises: SpecError."""
    if crf is not None and not 0 <= crf <= 51:
        raise SpecError(f"crf {crf} is no quality; give 0 (best) to 51", crf=crf)
    if name is None:
        return Recipe((Pass(crf=crf),))
    if name not in RECIPES:
        raise SpecError(f"recipe {name!r} is not known; choose one of {', '.join(RECIPES)}")
    if crf is not None:
        raise SpecError(f"recipe {name} sets its own quality; leave out either recipe or crf")
    return RECIPES[name]


def kept_frames(recipe: Recipe, count: int, seed: int) -> NDArray[np.int64]:
    """Numbers of the frames that reach the file; the first always, and never fewer than two."""
    keep = np.random.default_rng(seed).random(count) >= recipe.dropped
    keep[:1] = True
    if keep.sum() < 2:
        keep[:2] = True
    return np.flatnonzero(keep)


class FilmWriter:
    """A video file, frame by frame, through every pass of a recipe; a context manager that closes what it opened."""

    def __init__(self, path: Path, name: str, size: tuple[int, int], fps: float, recipe: Recipe) -> None:
        """Open the file at `path`; `name` is what messages call it; size: width and height of the pictures, px.

        Raises: SpecError for an odd size; MediaError where an encoder or a container for it is missing.
        """
        import av

        if size[0] % 2 or size[1] % 2:
            raise SpecError(f"pictures of {size[0]} x {size[1]} cannot be encoded; give a camera of even size")
        rate = Fraction(fps).limit_denominator(1001)
        self._step, self._name = 1 / rate, name
        self._links: list[_Link] = []
        self._chroma: tuple[NDArray[np.uint8], NDArray[np.uint8]] | None = None
        for one in recipe.passes[:-1]:
            with self._translated_errors():
                self._links.append(_Link(one, size, rate))
            size = self._links[-1].size
        last = self._last = recipe.passes[-1]
        self.size = scaled(size, last.height)
        self.keeps_colour = not self._links and self.size == size and last.transfer is None
        encoder, options = _encoder(last)
        try:
            self._container = av.open(str(path), "w")
            self._stream = self._container.add_stream(encoder, rate=rate, options=options)
        except (av.error.FFmpegError, ValueError) as error:
            raise MediaError(
                f"film {name} cannot be written as {last.codec} ({error}); name it .mp4 or .mkv"
            ) from error
        with self._translated_errors():
            _set_up(self._stream.codec_context, self.size, rate, last)

    def __enter__(self) -> FilmWriter:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finish the file; after an error close it as it is, which the caller then removes."""
        import av

        if kind is not None:
            with contextlib.suppress(av.error.FFmpegError):
                self._container.close()
            return
        with self._translated_errors():
            self._pass_on([], 0, flush=True)
            self._container.close()

    def write(
        self, picture: NDArray[np.uint8], number: int, chroma: tuple[NDArray[np.uint8], NDArray[np.uint8]] | None = None
    ) -> None:
        """Encode one picture (height, width), 0 to 255; `number`: its time in frames, rising.

        Parameters: chroma: both planes of colour differences, half as wide and high, as the file holds them; None for
            a grey picture, as is every one that passes an encoder before the last, is scaled, or has 10 bits.
        Raises: MediaError where the file takes no more, or cannot hold the codec.
        """
        self._chroma = chroma
        with self._translated_errors():
            self._pass_on([(np.asarray(cv2.LUT(picture, TO_VIDEO), dtype=np.uint8), number)], 0, flush=False)

    @contextlib.contextmanager
    def _translated_errors(self) -> Iterator[None]:
        """Turn the encoder's errors into a sentence."""
        import av

        try:
            yield
        except av.error.FFmpegError as error:
            advice = "name it .mp4 or .mkv, and check the free space"
            raise MediaError(f"film {self._name} cannot be written ({error.strerror}); {advice}") from error

    def _pass_on(self, frames: Iterable[tuple[NDArray[np.uint8], int]], link: int, *, flush: bool) -> None:
        """Send frames through the passes from number `link` on, and those that come out into the file."""
        if link < len(self._links):
            self._pass_on(self._links[link].feed(frames, flush=flush), link + 1, flush=flush)
            return
        for luma, number in frames:
            chroma = self._chroma if self.keeps_colour else None
            frame = _frame(luma, self.size, number, self._step, self._last.transfer, chroma)
            self._container.mux(self._stream.encode(frame))
        if flush:
            self._container.mux(self._stream.encode())


#: Length of a spell of one picture size, s; calls change it as the line allows, at most every few seconds.
TURN_S = 3


class _Link:
    """A pass in the middle of a recipe: each frame is encoded and decoded again, and comes out some frames later.

    Where picture sizes take turns, each spell has an encoder of its own, and all frames come out at one size.
    """

    def __init__(self, one: Pass, size: tuple[int, int], rate: Fraction) -> None:
        self.size, self._one, self._rate = scaled(size, one.height), one, rate
        self._open(0)

    def _open(self, spell: int) -> None:
        import av

        one = self._one
        self._spell = spell
        self._coded = scaled(self.size, one.turns[spell % len(one.turns)] if one.turns else None)
        encoder, options = _encoder(one)
        self._encoder = av.CodecContext.create(encoder, "w")
        self._encoder.options = options
        _set_up(self._encoder, self._coded, self._rate, one)
        # What is encoded anew afterwards is always H.264.
        self._decoder: Any = av.CodecContext.create("h264", "r")

    def feed(
        self, frames: Iterable[tuple[NDArray[np.uint8], int]], *, flush: bool
    ) -> Iterator[tuple[NDArray[np.uint8], int]]:
        """Frames that come out for those that go in, with their numbers."""
        for luma, number in frames:
            spell = int(number / self._rate / TURN_S) if self._one.turns else 0
            if spell != self._spell:
                yield from self._drained()
                self._open(spell)
            for packet in self._encoder.encode(_frame(luma, self._coded, number, 1 / self._rate)):
                yield from self._decoded(packet)
        if flush:
            yield from self._drained()

    def _drained(self) -> Iterator[tuple[NDArray[np.uint8], int]]:
        for packet in (*self._encoder.encode(), None):
            yield from self._decoded(packet)

    def _decoded(self, packet: Any) -> Iterator[tuple[NDArray[np.uint8], int]]:
        for frame in self._decoder.decode(packet):
            plane = frame.planes[0]
            rows = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)[:, : plane.width]
            yield np.asarray(cv2.resize(rows, self.size, interpolation=cv2.INTER_LINEAR), np.uint8), frame.pts


def scaled(size: tuple[int, int], height: int | None) -> tuple[int, int]:
    """Width and height scaled down to that many rows at the same shape, both even; as they are if that is less."""
    if height is None or height >= size[1]:
        return size
    return 2 * round(size[0] * height / size[1] / 2), height


def _encoder(one: Pass) -> tuple[str, dict[str, str]]:
    """Name and options of the encoder of a pass."""
    name, usual, options = ENCODERS[one.codec]
    if one.kbps is not None:
        return name, options
    return name, options | {"crf": str(usual if one.crf is None else one.crf)}


def _set_up(context: Any, size: tuple[int, int], rate: Fraction, one: Pass) -> None:
    """Set an encoder's size, frame rate and bit rate, and start it."""
    context.width, context.height = size
    context.pix_fmt = "yuv420p"
    if one.transfer is not None:
        context.pix_fmt = "yuv420p10le"
        context.color_primaries, context.color_trc, context.colorspace = CURVES[one.transfer].tags
    if one.aspect is not None:
        context.sample_aspect_ratio = one.aspect
    context.framerate, context.time_base = rate, 1 / rate
    if one.kbps is not None:
        context.bit_rate = 1000 * one.kbps
    context.open()


def _frame(
    luma: NDArray[np.uint8],
    size: tuple[int, int],
    number: int,
    time_base: Fraction,
    transfer: str | None = None,
    chroma: tuple[NDArray[np.uint8], NDArray[np.uint8]] | None = None,
) -> Any:
    """A frame for an encoder, scaled to its size; grey without colour differences; of 10 bits with a transfer curve."""
    import av

    if (luma.shape[1], luma.shape[0]) != size:
        luma = np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    if transfer is None:
        frame = av.VideoFrame(*size, format="yuv420p")
        for index, plane in enumerate(frame.planes):
            lines = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
            lines[:, : plane.width] = luma if index == 0 else chroma[index - 1] if chroma else GREY
    else:
        counts = CURVES[transfer].counts[luma]
        planes = np.concatenate([counts, np.full((size[1] // 2, size[0]), 512, np.uint16)])
        frame = av.VideoFrame.from_ndarray(planes, format="yuv420p10le")
    frame.pts, frame.time_base = number, time_base
    return frame
