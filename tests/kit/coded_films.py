"""Films of given pictures, and short ones of long ones."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np


def written(
    path: Path,
    pictures: list[np.ndarray],
    codec: str,
    pixels: str,
    *,
    full_range: bool = False,
    aspect: Fraction | None = None,
) -> Path:
    """A film of grey pictures, coded without visible loss; aspect: width of a pixel over its height, as a flag.

    Without B-frames: of two frames, x265 would now and then make a packet that no file can hold.
    """
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=Fraction(30))
        stream.height, stream.width = pictures[0].shape
        stream.pix_fmt = pixels
        stream.options = {"crf": "1", "preset": "ultrafast", "threads": "2", "x265-params": "log-level=none:bframes=0"}
        if full_range:
            stream.codec_context.color_range = 2
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(np.repeat(picture[..., None], 3, axis=2), format="rgb24")
            container.mux(stream.encode(frame.reformat(format=pixels, dst_color_range=2 if full_range else 1)))
        container.mux(stream.encode(None))
    return path


def first_frames(source: Path, target: Path, frames: int) -> Path:
    """The beginning of a film, its pictures as they are coded."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        for packet, _ in zip(given.demux(video=0), range(frames), strict=False):
            packet.stream = stream
            made.mux(packet)
    return target
