"""A few true photographs of a badge turned on the spot, shown over and over: run
`moireid lab bench turned`.

Each picture is true in itself, the page hardly moves in the picture, and a few values correlate with anything that
takes as many; where they are held for long, one cross-faded frame at each turn shows a view between.  None
should be accepted.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.simulate.filming import film
from moireid.simulate.motion import Poses
from moireid.simulate.recording.encode import TO_VIDEO
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.forgers.forgers_suite import CAMERA, badge_of
from moireid_lab.bench.part import OWN, Asked, Part, Row, film_row, numbered

Array = NDArray[np.float64]
DISTANCE_MM, CLOCK = 1000.0, 90_000
#: Frames for which a picture that was moved after a cut is held.
MOVED_FRAMES = 24


@dataclass(frozen=True)
class Show:
    """order: numbers of the photographs of one round; step_s: time of a frame, and of each seventh one; hold: frames
    for which each photograph stays, at least and at most; turn_deg: the outermost photographs' turn; mixed: whether one
    cross-faded frame is between two; moved_px: by how much the first two are moved in the picture at the end;
    faded: whether all frames are cross-faded, along a calm course."""

    order: tuple[int, ...]
    step_s: tuple[float, float]
    hold: tuple[int, int] = (1, 1)
    turn_deg: float = 5.0
    frames: int = 110
    mixed: bool = False
    moved_px: int = 0
    faded: bool = False

    @property
    def times_s(self) -> Array:
        """Of the frames."""
        return np.cumsum([self.step_s[frame % 7 == 0] for frame in range(self.frames)])

    def pictures(self, taken: list[NDArray[np.uint8]], seed: int) -> Iterator[NDArray[np.uint8]]:
        """The frames in turn, of the photographs that were taken."""
        rng = np.random.default_rng(seed)
        if self.faded:
            time_s = self.times_s
            way = (1 + np.sin(2 * np.pi * 0.33 * time_s + seed + 0.6 * np.sin(1.1 * time_s))) / 2 * (len(taken) - 1)
            before = np.minimum(way.astype(int), len(taken) - 2)
            for first, share in zip(before.tolist(), (way - before).tolist(), strict=True):
                yield np.rint((1 - share) * taken[first] + share * taken[first + 1]).astype(np.uint8)
            return
        last = 2 * MOVED_FRAMES if self.moved_px else 0
        one, left = 0, self.frames - last
        while left > 0:
            here, there = (taken[self.order[(one + k) % len(self.order)]] for k in (0, 1))
            held = min(left, int(rng.integers(self.hold[0], self.hold[1] + 1)))
            yield from [here] * held
            left, one = left - held, one + 1
            if self.mixed and left > 0:
                share = rng.uniform(0.08, 0.92)
                yield np.rint((1 - share) * here + share * there).astype(np.uint8)
                left -= 1
        for picture, way in zip(taken, (1, -1), strict=False):
            yield from [np.roll(picture, way * self.moved_px, axis=1)] * (last // 2)


TWELVE = (1 / 12, 1 / 12)
SHOWS = {
    "2 in turns, every seventh frame late": Show((0, 1), (0.1, 0.2)),
    "2, each for 6 frames, every seventh late": Show((0, 1), (0.1, 0.2), (6, 6)),
    "3 to and fro, 12 a second": Show((1, 2, 1, 0), TWELVE),
    "3 to and fro, each for a second": Show((1, 2, 1, 0), TWELVE, (12, 12)),
    "4 to and fro, 15 a second": Show((0, 1, 2, 3, 2, 1), (1 / 15, 1 / 15)),
    "2, held, one mixed frame a turn": Show((0, 1), TWELVE, (8, 20), 3.0, 608, True),
    "2, held, mixed, and moved at the end": Show((0, 1), TWELVE, (8, 20), 3.0, 608, True, 300),
    "3, held, one mixed frame a turn": Show((0, 1, 2, 1), TWELVE, (15, 37), 4.2, 840, True),
    "4, held, one mixed frame a turn": Show((0, 1, 2, 3, 2, 1), TWELVE, (15, 37), 4.2, 840, True),
    "2, cross-faded along a calm course": Show((0, 1), (1 / 30, 1 / 30), turn_deg=3.5, frames=600, faded=True),
    "3, cross-faded along a calm course": Show((0, 1, 2), (1 / 30, 1 / 30), turn_deg=3.6, frames=600, faded=True),
    "6, held, one mixed frame a turn": Show((0, 1, 2, 3, 4, 5, 4, 3, 2, 1), TWELVE, (15, 37), 7.0, 840, True),
}


def taken(badge: Badge, count: int, turn_deg: float, seed: int, folder: Path) -> list[NDArray[np.uint8]]:
    """So many photographs, of a badge that is turned from one side to the other."""
    along = np.linspace(-1, 1, count)
    angles = np.column_stack([turn_deg * along, 3 * np.cos(2.1 * np.arange(count))])
    turn = Rotation.from_euler("yx", angles, degrees=True)
    camera, matrix = -turn.inv().apply([0.0, 0.0, DISTANCE_MM]), turn.as_matrix()
    pictures: list[NDArray[np.uint8]] = []

    def motion(times_s: Array) -> Poses:
        number = np.clip(np.rint(np.asarray(times_s) * 10).astype(int), 0, count - 1)
        return Poses(camera[number], matrix[number])

    def kept(frame: int, luma: NDArray[np.uint8], homography: Array) -> NDArray[np.uint8]:
        pictures.append(luma.copy())
        return luma

    scene = Scene(badge, Build.typical(seed), CAMERA)
    film(scene, motion, folder / "taken.mp4", frames=count, fps=10.0, edit=kept, seed=seed, overwrite=True)
    return pictures


def shown(pictures: list[NDArray[np.uint8]], show: Show, seed: int, path: Path) -> None:
    """The film of a show."""
    with av.open(str(path), "w") as made:
        height, width = pictures[0].shape
        stream = made.add_stream(
            "libx264", rate=30, options={"crf": "18", "preset": "veryfast", "bf": "0", "threads": "2"}
        )
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.codec_context.time_base = Fraction(1, CLOCK)
        for picture, time_s in zip(show.pictures(pictures, seed), show.times_s.tolist(), strict=True):
            whole = np.full((height * 3 // 2, width), 128, np.uint8)
            whole[:height] = TO_VIDEO[picture]
            frame = av.VideoFrame.from_ndarray(whole, format="yuv420p")
            frame.pts, frame.time_base = round(time_s * CLOCK), Fraction(1, CLOCK)
            made.mux(stream.encode(frame))
        made.mux(stream.encode())


def judged(job: tuple[str, int], folder: Path) -> Row:
    """The verdict of one film."""
    name, seed = job
    badge, show = badge_of("x"), SHOWS[name]
    with tempfile.TemporaryDirectory(dir=folder) as own:
        path = Path(own) / "film.mp4"
        shown(taken(badge, len(set(show.order)), show.turn_deg, seed, Path(own)), show, seed, path)
        report = verify(path, Question(badge, badge.id))
    return film_row(name, report, true=False)


def cases(asked: Asked) -> dict[str, tuple[str, int]]:
    """All films."""
    return numbered(list(SHOWS), asked.clips or 1, 1)


QUESTIONS = {"forged": "Is a show of two to six true photographs of a badge rejected, turned on the spot?"}
PART = Part(QUESTIONS, OWN, cases, judged)
