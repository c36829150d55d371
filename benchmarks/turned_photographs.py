"""A few true photographs of a badge turned on the spot, shown over and over: run
`.venv/bin/python benchmarks/turned_photographs.py`.

Each picture is true in itself, the page hardly moves in the picture, and a few values correlate with anything that
takes as many.  Printed is what becomes of each film, of which none should be accepted.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.bench.forgers.suite import CAMERA, badge_of
from moireid.simulate.filming import film
from moireid.simulate.motion import Poses
from moireid.simulate.recording.encode import TO_VIDEO
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Claim, verify

Array = NDArray[np.float64]
DISTANCE_MM, TURN_DEG, FRAMES, CLOCK = 1000.0, 5.0, 110, 90_000


@dataclass(frozen=True)
class Show:
    """order: numbers of the photographs of one round; step_s: time of a frame, and of each seventh one; hold: frames
    for which each photograph stays."""

    order: tuple[int, ...]
    step_s: tuple[float, float]
    hold: int = 1

    @property
    def times_s(self) -> Array:
        """Of the frames."""
        return np.cumsum([self.step_s[frame % 7 == 0] for frame in range(FRAMES)])


SHOWS = {
    "2 in turns, every seventh frame late": Show((0, 1), (0.1, 0.2)),
    "2, each for 6 frames, every seventh late": Show((0, 1), (0.1, 0.2), 6),
    "3 to and fro, 12 a second": Show((1, 2, 1, 0), (1 / 12, 1 / 12)),
    "3 to and fro, each for a second": Show((1, 2, 1, 0), (1 / 12, 1 / 12), 12),
    "4 to and fro, 15 a second": Show((0, 1, 2, 3, 2, 1), (1 / 15, 1 / 15)),
}


def taken(badge: Badge, count: int, seed: int, folder: Path) -> list[NDArray[np.uint8]]:
    """So many photographs, of a badge that is turned from one side to the other."""
    along = np.linspace(-1, 1, count)
    angles = np.column_stack([TURN_DEG * along, 3 * np.cos(2.1 * np.arange(count))])
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


def shown(pictures: list[NDArray[np.uint8]], show: Show, path: Path) -> None:
    """The film of a show."""
    with av.open(str(path), "w") as made:
        height, width = pictures[0].shape
        stream = made.add_stream("libx264", rate=30, options={"crf": "23", "preset": "veryfast", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.codec_context.time_base = Fraction(1, CLOCK)
        for number, time_s in enumerate(show.times_s.tolist()):
            whole = np.full((height * 3 // 2, width), 128, np.uint8)
            whole[:height] = TO_VIDEO[pictures[show.order[number // show.hold % len(show.order)]]]
            frame = av.VideoFrame.from_ndarray(whole, format="yuv420p")
            frame.pts, frame.time_base = round(time_s * CLOCK), Fraction(1, CLOCK)
            made.mux(stream.encode(frame))
        made.mux(stream.encode())


def main() -> None:
    """Print the verdict of each film."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=1, metavar="N", help="films of each kind; default: 1")
    arguments = parser.parse_args()
    badge = badge_of("x")
    for name, show in SHOWS.items():
        for seed in range(1, arguments.seeds + 1):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "film.mp4"
                shown(taken(badge, len(set(show.order)), seed, Path(folder)), show, path)
                report = verify(path, Claim(badge, badge.id))
            why = ", ".join(reason.code for reason in report.reasons if reason.level in ("fail", "undecided"))
            print(f"{name:42} seed {seed}: {report.verdict} {why}", flush=True)


if __name__ == "__main__":
    main()
