"""Films that an editor or a call program recut: run `.venv/bin/python benchmarks/recut_films.py`.

The outside films of a true badge and of half its gain (tests/data/films) are cropped off-centre, placed as a tile in a
larger picture, or stretched, and coded again.  Printed is what becomes of each, and how far the camera that was solved
is from the film's own: 1450 px, the optical axis in the middle of the uncut picture.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import load_badge
from moireid.verifier import Claim, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script

FILMS = Path(__file__).resolve().parent.parent / "tests" / "data" / "films"
NAMES = ("genuine_1.0m", "genuine_2.0m", "forged_gain_low_1.0m")
FOCAL_PX, SIZE = 1450.0, (1920, 1080)
CRF = "20"
Luma = NDArray[np.uint8]


@dataclass(frozen=True)
class Recut:
    """A part (left, top, width, height) of the picture, scaled to `scaled`, at `place` in a picture of `size`; flag:
    the pixels' aspect that the file states.
    """

    name: str
    part: tuple[int, int, int, int]
    scaled: tuple[int, int]
    size: tuple[int, int]
    place: tuple[int, int] = (0, 0)
    flag: Fraction | None = None

    @property
    def aspect(self) -> float:
        """Width of a pixel over its height in the recut film, by the uncut one's."""
        return self.scaled[0] / self.part[2] / (self.scaled[1] / self.part[3])

    @property
    def axis_px(self) -> tuple[float, float]:
        """Where the optical axis lies from the recut picture's middle, in px of the height."""
        places = []
        for k in (0, 1):
            scale = self.scaled[k] / self.part[2 + k]
            place = ((SIZE[k] - 1) / 2 - self.part[k] + 0.5) * scale - 0.5 + self.place[k]
            places.append(place - (self.size[k] - 1) / 2)
        return places[0], places[1]

    def of(self, luma: Luma) -> Luma:
        """One picture, recut."""
        left, top, width, height = self.part
        shown = luma[top : top + height, left : left + width]
        if self.scaled != (width, height):
            shown = np.asarray(cv2.resize(shown, self.scaled, interpolation=cv2.INTER_AREA), np.uint8)
        out = np.full(self.size[::-1], 40, np.uint8)
        x, y = self.place
        out[y : y + self.scaled[1], x : x + self.scaled[0]] = shown
        return out


WHOLE = (0, 0, *SIZE)
RECUTS = (
    Recut("as it is, coded again", WHOLE, SIZE, SIZE),
    Recut("cropped on the right", (0, 0, 1500, 1080), (1500, 1080), (1500, 1080)),
    Recut("cropped on the left and above", (420, 200, 1500, 880), (1500, 880), (1500, 880)),
    Recut("a tile of a recorded call", (240, 140, 1440, 800), (1440, 800), (2560, 1440), (40, 60)),
    Recut("half size, then a tile aside", (240, 140, 1440, 800), (1080, 600), (1920, 1080), (820, 20)),
    Recut("squeezed to 4:3, with a flag", WHOLE, (1440, 1080), (1440, 1080), flag=Fraction(4, 3)),
    Recut("squeezed to 4:3, without a flag", WHOLE, (1440, 1080), (1440, 1080)),
    Recut("3 % wider", WHOLE, (1978, 1080), (1978, 1080)),
    Recut("3 % narrower", WHOLE, (1862, 1080), (1862, 1080)),
    Recut("848 x 480 for 854 x 480", WHOLE, (848, 480), (848, 480)),
)


def write(source: Path, recut: Recut, target: Path) -> None:
    """The recut film."""
    with av.open(str(source)) as given, av.open(str(target), "w") as made:
        own = given.streams.video[0]
        stream = made.add_stream("libx264", rate=own.average_rate, options={"crf": CRF})
        stream.width, stream.height, stream.pix_fmt, stream.time_base = *recut.size, "yuv420p", own.time_base
        if recut.flag is not None:
            stream.codec_context.sample_aspect_ratio = recut.flag
        for frame in given.decode(own):
            luma = recut.of(frame.to_ndarray(format="gray"))
            shown = av.VideoFrame.from_ndarray(np.repeat(luma[..., None], 3, axis=2), format="rgb24")
            shown = shown.reformat(format="yuv420p")
            shown.pts, shown.time_base = frame.pts, frame.time_base
            made.mux(stream.encode(shown))
        made.mux(stream.encode(None))


def judged(job: tuple[Recut, str]) -> Row:
    """One film, recut and verified."""
    recut, name = job
    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / "film.mp4"
        write(FILMS / f"{name}.mp4", recut, video)
        report = verify(video, Claim(load_badge(FILMS / "badge.json")))
    camera, motion = report.measurement.camera, report.invariant
    aspect = 1.0 if recut.flag else recut.aspect
    return {
        "recut": recut.name,
        "film": name,
        "verdict": report.verdict,
        "gain": motion.gain_ratio,
        "error bar": motion.gain_sd,
        "axis off, px": float(np.hypot(*np.subtract(camera.axis_px, np.divide(recut.axis_px, (aspect, 1.0))))),
        "aspect off": camera.aspect / aspect - 1,
        "focal off": camera.focal_px / (FOCAL_PX * recut.scaled[1] / recut.part[3]) - 1,
    }


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film and recut."""
    return wish.each(judged, {f"{recut.name}, {name}": (recut, name) for recut in RECUTS for name in NAMES})


COLUMNS = {"recut": "<33", "film": "<21", "verdict": "<13", "gain": ">8.3f", "error bar": ">10.3f"}
COLUMNS |= {"axis off, px": ">13.1f", "aspect off": ">11+.2%", "focal off": ">10+.1%"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
