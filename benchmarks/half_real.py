"""A badge on a board that is held before real webcams: run `.venv/bin/python benchmarks/half_real.py --data DIR`.

DIR holds clips of a ChArUco board, `hold_N.mp4`, the board's `charuco.toml`, and each camera's matrix and distortion in
`camera_array.toml`, as caliscope records them.  The board's pose in each frame follows from its corners and the known
lens.  There a printed badge is drawn by `outside`, which shares nothing with `moireid.simulate`: through that lens, in
the light that the board's white squares show, with the camera's noise; what lies before the board, fingers and glare,
stays before the badge.  So lens, hands, room and motion are real.  The clips are short and are played to and fro.

Printed is, for each camera, true and forged, the verdict, the gain with its error bar, how many frames were tracked,
whether the identity was read, and the camera as solved beside the true one.  With `--keep DIR` the films are kept.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import tomllib
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
from natural_films import prepared
from numpy.typing import NDArray
from outside.build import built
from outside.camera import Camera
from outside.film import Shoot, Tracer
from outside.motion import Course
from outside.page import PAPER, load_page

from moireid.badge import load_badge
from moireid.verifier import Claim, verify

Array = NDArray[np.float64]
#: Frames a second of the clips, and the least corners of the board that tell its pose.
FPS, LEAST_CORNERS = 6, 8
#: Shorter clips are played to and fro again.
LEAST_FRAMES = 80
FORGERIES = (None, "gain_0.5", "frozen")
#: Of the optics, standard deviation, px; of the sensor, grey values; a webcam's curve from light to grey values.
BLUR_PX, NOISE, GAMMA = 0.6, 1.2, 2.2
#: A pixel of the board that differs by this share of white less black shows something that lies before it.
BEFORE_SHARE, BEFORE_PX = 0.35, 7
#: Of a square in the board's own picture.
PRINTED_PX = 40


@dataclass(frozen=True)
class Webcam(Camera):
    """A camera of OpenCV's whole model.  matrix (3, 3), distortion (5,): as calibrated, pixel centres at whole px."""

    matrix: Array | None = None
    distortion: Array | None = None

    def project(self, points: Array) -> Array:
        """As `Camera.project`."""
        seen, _ = cv2.projectPoints(points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), self.matrix, self.distortion)
        return np.asarray(seen.reshape(*points.shape[:-1], 2) + 0.5)

    def rays(self) -> NDArray[np.float32]:
        """As `Camera.rays`."""
        grid = np.stack(np.meshgrid(*(np.arange(n, dtype=float) for n in self.size_px)), axis=-1)
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-9)
        flat = cv2.undistortPoints(grid.reshape(-1, 1, 2), self.matrix, self.distortion, criteria=until)
        return flat.reshape(grid.shape).astype(np.float32)


@dataclass(frozen=True)
class View:
    """One frame of a clip.  grey: its luma; turn (3, 3), place (3,): from the badge's frame, mm, to the camera's."""

    grey: NDArray[np.uint8]
    colour: NDArray[np.uint8]
    turn: Array
    place: Array


@dataclass(frozen=True)
class Held(Course):
    """The course of a clip, one pose for each frame."""

    views_of: tuple[View, ...] = ()

    def views(self, t: Array) -> tuple[Array, Array]:
        """As `Course.views`: a frame's pose holds for its time."""
        frames = np.clip(np.floor(np.asarray(t) * FPS + 0.5).astype(int), 0, len(self.views_of) - 1)
        turns = np.stack([self.views_of[k].turn.T for k in frames])
        return np.stack([-self.views_of[k].turn.T @ self.views_of[k].place for k in frames]), turns


def charuco(folder: Path) -> tuple[cv2.aruco.CharucoBoard, bool, float]:
    """The board, whether it is printed inverted, and the side of a square, mm."""
    told = tomllib.loads((folder / "charuco.toml").read_text(encoding="utf-8"))
    square = 10 * float(told["square_size_override_cm"])
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, told["dictionary"]))
    size = told["columns"], told["rows"]
    return cv2.aruco.CharucoBoard(size, square, square * told["aruco_scale"], dictionary), told["inverted"], square


def webcam(folder: Path, number: int) -> Webcam:
    """One of the cameras, as calibrated."""
    told = tomllib.loads((folder / "camera_array.toml").read_text(encoding="utf-8"))["cameras"][str(number)]
    matrix = np.array(told["matrix"])
    return Webcam(
        size_px=tuple(told["size"]),
        focal_px=float(matrix[0, 0]),
        center_px=(float(matrix[0, 2]) + 0.5, float(matrix[1, 2]) + 0.5),
        blur_px=BLUR_PX,
        matrix=matrix,
        distortion=np.array(told["distortions"]),
    )


def views(folder: Path, number: int, camera: Webcam) -> list[View]:
    """The frames of a clip that show the board.  The badge lies in its middle, x along its longer side."""
    board, inverted, square = charuco(folder)
    columns, rows = board.getChessboardSize()
    middle = np.array([columns, rows, 0]) * square / 2
    to_board = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    detector = cv2.aruco.CharucoDetector(board)
    clip, found = cv2.VideoCapture(str(folder / f"hold_{number}.mp4")), []
    while (read := clip.read())[0]:
        luma = cv2.cvtColor(read[1], cv2.COLOR_BGR2YUV_I420)
        grey, colour = luma[: camera.size_px[1]], luma[camera.size_px[1] :]
        corners, ids, _, _ = detector.detectBoard(255 - grey if inverted else grey)
        if ids is None or len(ids) < LEAST_CORNERS:
            continue
        solid = board.getChessboardCorners()[ids.ravel()]
        good, turn, place = cv2.solvePnP(solid, corners.reshape(-1, 1, 2), camera.matrix, camera.distortion)
        if good:
            turned = cv2.Rodrigues(turn)[0]
            found.append(View(grey, colour, turned @ to_board, turned @ middle + place[:, 0]))
    return found


class OnBoard(Tracer):
    """Frames of a clip with the badge drawn on the board."""

    def _fill(self, t: float) -> None:
        """What is behind the badge: the frame itself, in light over that of the board's white squares."""
        view = self.view
        grey = view.grey.astype(np.float32)
        self.white = self._white(view)
        self.light[:] = PAPER * (grey / self.white) ** GAMMA

    @property
    def view(self) -> View:
        """The frame that is drawn."""
        return self.course.views_of[self.number]  # type: ignore[attr-defined]

    def painted(self, number: int, rng: np.random.Generator) -> NDArray[np.uint8]:
        """One frame, luma and colour as yuv420p has them."""
        self.number = number
        light = self.frame(number).copy()
        view, noise = self.view, rng.normal(scale=NOISE, size=self.light.shape)
        grey = view.grey.astype(np.float32)
        drawn = self.white * np.maximum(light / PAPER, 0) ** (1 / GAMMA)
        changed = (np.abs(drawn - grey) > 0.5) & ~self._before(view)
        grey = np.where(changed, drawn + noise, grey)
        colour = view.colour.reshape(2, self.light.shape[0] // 2, -1).copy()
        colour[:, changed[::2, ::2]] = 128
        luma = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        return np.concatenate([luma, colour.reshape(-1, luma.shape[1])])

    def _white(self, view: View) -> NDArray[np.float32]:
        """Grey value of the board's white over the picture, as a plane, from the middles of its squares."""
        places, values = [], []
        for column in range(self.columns):
            for row in range(self.rows):
                at = np.array([row - (self.rows - 1) / 2, (self.columns - 1) / 2 - column, 0]) * self.square
                place = self._seen(view, at[None])[0]
                x, y = np.rint(place).astype(int)
                if 3 <= x < view.grey.shape[1] - 3 and 3 <= y < view.grey.shape[0] - 3:
                    places.append([x, y, 1.0])
                    values.append(float(np.median(view.grey[y - 3 : y + 4, x - 3 : x + 4])))
        table, level = np.array(places), np.array(values)
        bright = level > np.median(level)
        plane, *_ = np.linalg.lstsq(table[bright], level[bright], rcond=None)
        y, x = np.indices(view.grey.shape)
        return np.clip(plane[0] * x + plane[1] * y + plane[2], 40, 250).astype(np.float32)

    def _before(self, view: View) -> NDArray[np.bool_]:
        """Pixels in which something lies before the board."""
        half = np.array([self.rows, self.columns]) * self.square / 2
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        seen = self._seen(view, np.column_stack([corners, np.zeros(4)])).astype(np.float32)
        board = cv2.rotate(self.printed, cv2.ROTATE_90_CLOCKWISE)
        height, width = board.shape
        flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32) - 0.5
        matrix = cv2.getPerspectiveTransform(flat, seen)
        expected = cv2.warpPerspective(board, matrix, view.grey.shape[::-1], borderValue=255) / 255.0
        shown = view.grey / self.white
        black = float(np.percentile(shown[expected < 0.1], 50)) if np.any(expected < 0.1) else 0.2
        apart = np.abs(shown - (black + (1 - black) * expected)) > BEFORE_SHARE * (1 - black)
        kernel = np.ones((BEFORE_PX, BEFORE_PX), np.uint8)
        return cv2.morphologyEx(apart.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0

    def _seen(self, view: View, solid: Array) -> Array:
        return self.camera.project(solid @ view.turn.T + view.place) - 0.5


def half_real(folder: Path, number: int, forge: str | None, badge: Path, path: Path) -> int:
    """Write one film; the number of its frames."""
    import av

    camera = webcam(folder, number)
    once = views(folder, number, camera)
    clip = once + once[-2:0:-1]
    while len(clip) < LEAST_FRAMES:
        clip += once + once[-2:0:-1]
    course = Held("held", lambda t: t, lambda t: t, tuple(clip))
    page = load_page(badge)
    tracer = OnBoard(page, built(page, np.random.default_rng(1)), camera, course, Shoot(len(clip), FPS, 23, 7, forge))
    board, inverted, tracer.square = charuco(folder)
    tracer.columns, tracer.rows = board.getChessboardSize()
    picture = board.generateImage((PRINTED_PX * tracer.columns, PRINTED_PX * tracer.rows))
    tracer.printed = 255 - picture if inverted else picture
    rng = np.random.default_rng(number)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(FPS), options={"crf": "20", "preset": "fast"})
        stream.width, stream.height, stream.pix_fmt = *camera.size_px, "yuv420p"
        for k in range(len(clip)):
            frame = av.VideoFrame.from_ndarray(tracer.painted(k, rng), format="yuv420p")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return len(clip)


def main() -> None:
    """Make the films, judge them, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, metavar="DIR")
    parser.add_argument("--keep", type=Path, metavar="DIR")
    parser.add_argument("--cameras", type=int, nargs="*", default=[0, 1, 2, 3])
    wish = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        kept = prepared(wish.keep or Path(scratch))
        badge = load_badge(kept / "badge" / "badge.json")
        for number in wish.cameras:
            camera = webcam(wish.data, number)
            for forge in FORGERIES:
                path = kept / f"hold_{number}_{forge or 'true'}.mp4"
                frames = half_real(wish.data, number, forge, kept / "badge", path)
                report = verify(path, Claim(badge, badge.id))
                found = report.to_json()
                gain, sd = report.invariant.gain_ratio, report.invariant.gain_sd
                lens = report.measurement.camera if report.measurement else None
                solved = f"f {lens.focal_px:.0f} k1 {lens.bend_k1:.2f}" if lens else "no camera"
                middle = np.array(camera.center_px) - 0.5 - (np.array(camera.size_px) - 1) / 2
                axis = np.array(lens.axis_px) - middle if lens else np.full(2, math.nan)
                reasons = [one["code"] for one in found["reasons"] if one["level"] in ("fail", "undecided")]
                print(
                    f"camera {number} {forge or 'true':9} {report.verdict:13} gain {gain} ± {sd} "
                    f"tracked {found['frames']['tracked']} of {frames} read {report.identity.decoded_id == badge.id} "
                    f"{solved} (true f {camera.focal_px:.0f} k1 {camera.distortion[0]:.2f}; axis off by "
                    f"{np.hypot(*axis):.0f} px) {' '.join(reasons)}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
