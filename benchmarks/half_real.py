"""A badge on a board that is held before real webcams: run `moireid lab bench half-real --data DIR`.

DIR holds clips of a ChArUco board, `hold_N.mp4`, the board's `charuco.toml`, and each camera's matrix and distortion in
`camera_array.toml`, as caliscope records them.  The board's pose in each frame follows from its corners and the known
lens.  There a printed badge is drawn by `outside`, which shares nothing with `moireid.simulate`: through that lens, in
the light that the board's white squares show, with the camera's noise.  What is in front of the board, fingers and
glare, stays in front of the badge.  So lens, hands, room and motion are real.  The clips are short and are played to
and fro.

With `--keep DIR` the films are kept, each with its badge next to it, as `golden.py` reads them.
"""

from __future__ import annotations

import math
import tempfile
import tomllib
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from outside.build import built
from outside.camera import Camera
from outside.film import Shoot, Tracer
from outside.motion import Course
from outside.page import PAPER, load_page

from moireid.designer import Order
from moireid.verifier import Question, verify
from moireid_lab.bench.part import OUTSIDE, Asked, Part, Row, film_row, identity_answer, printed

Array = NDArray[np.float64]
#: Frames a second of the clips, and the fewest corners of the board that give its pose.
FPS, LEAST_CORNERS = 6, 8
#: Shorter clips are played to and fro again.
LEAST_FRAMES = 80
#: The default badge, mm, and the largest that pdfium draws whole at 1200 dpi.
SIZES_MM = (146, 175)
PATTERNS = ("silk", "cells")
FORGERIES, CAMERAS = ("gain_0.5", "frozen"), range(4)
#: Of the optics, standard deviation, px; of the sensor, grey values; a webcam's curve from light to grey values.
BLUR_PX, NOISE, GAMMA = 0.6, 1.2, 2.2
#: A pixel of the board that differs by this share of white less black shows something in front of it.
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


def bent_webcam(camera: Camera, k1: float, k2: float) -> Webcam:
    """The camera with a radial distortion of two terms."""
    across, up = camera.center_px
    matrix = np.array([[camera.focal_px, 0, across - 0.5], [0, camera.focal_px, up - 0.5], [0, 0, 1]])
    own = {**vars(camera), "k1": 0.0}
    return Webcam(**own, matrix=matrix, distortion=np.array([k1, k2, 0, 0, 0]))


@dataclass(frozen=True)
class BoardView:
    """One frame of a clip.  number: in the clip; grey: its luma; turn (3, 3), place (3,): from the badge's frame, mm,
    to the camera's; solid (N, 3), corners (N, 2): the board's corners in that frame and in the picture.
    """

    number: int
    grey: NDArray[np.uint8]
    colour: NDArray[np.uint8]
    turn: Array
    place: Array
    solid: Array
    corners: Array


@dataclass(frozen=True)
class ClipCourse(Course):
    """The course of a clip, one pose for each frame."""

    clip: tuple[BoardView, ...] = ()

    def views(self, t: Array) -> tuple[Array, Array]:
        """As `Course.views`: a frame's pose holds for its time."""
        frames = np.clip(np.floor(np.asarray(t) * FPS + 0.5).astype(int), 0, len(self.clip) - 1)
        turns = np.stack([self.clip[k].turn.T for k in frames])
        return np.stack([-self.clip[k].turn.T @ self.clip[k].place for k in frames]), turns


@dataclass(frozen=True)
class PrintedBoard:
    """The ChArUco board.  square: side of a square, mm; inverted: whether black and white are exchanged in print."""

    board: cv2.aruco.CharucoBoard
    inverted: bool
    square: float

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of squares."""
        return self.board.getChessboardSize()

    def picture(self) -> NDArray[np.uint8]:
        """The board in the badge's frame, x to the right."""
        picture = self.board.generateImage(tuple(PRINTED_PX * count for count in self.size))
        return cv2.rotate(255 - picture if self.inverted else picture, cv2.ROTATE_90_CLOCKWISE)


def load_board(folder: Path) -> PrintedBoard:
    """The board as described in the folder."""
    config = tomllib.loads((folder / "charuco.toml").read_text(encoding="utf-8"))
    square = 10 * float(config["square_size_override_cm"])
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, config["dictionary"]))
    size = config["columns"], config["rows"]
    board = cv2.aruco.CharucoBoard(size, square, square * config["aruco_scale"], dictionary)
    return PrintedBoard(board, config["inverted"], square)


def webcam(folder: Path, number: int) -> Webcam:
    """One of the cameras, as calibrated."""
    config = tomllib.loads((folder / "camera_array.toml").read_text(encoding="utf-8"))["cameras"][str(number)]
    matrix = np.array(config["matrix"])
    return Webcam(
        size_px=tuple(config["size"]),
        focal_px=float(matrix[0, 0]),
        center_px=(float(matrix[0, 2]) + 0.5, float(matrix[1, 2]) + 0.5),
        blur_px=BLUR_PX,
        matrix=matrix,
        distortion=np.array(config["distortions"]),
    )


def read_clip(folder: Path, number: int, camera: Webcam, board: PrintedBoard) -> list[BoardView]:
    """The frames of a clip that show the board, played to and fro.

    Convention: the badge is in the board's middle, x along the board's longer side.
    """
    middle = np.array([*board.size, 0]) * board.square / 2
    to_board = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    detector = cv2.aruco.CharucoDetector(board.board)
    clip, found = cv2.VideoCapture(str(folder / f"hold_{number}.mp4")), []
    frame = -1
    while (read := clip.read())[0]:
        frame += 1
        luma = cv2.cvtColor(read[1], cv2.COLOR_BGR2YUV_I420)
        grey, colour = luma[: camera.size_px[1]], luma[camera.size_px[1] :]
        corners, ids, _, _ = detector.detectBoard(255 - grey if board.inverted else grey)
        if ids is None or len(ids) < LEAST_CORNERS:
            continue
        solid = board.board.getChessboardCorners()[ids.ravel()]
        good, turn, place = cv2.solvePnP(solid, corners.reshape(-1, 1, 2), camera.matrix, camera.distortion)
        if good:
            turned = cv2.Rodrigues(turn)[0]
            pose = turned @ to_board, turned @ middle + place[:, 0]
            corners_px = corners.reshape(-1, 2).astype(float)
            found.append(BoardView(frame, grey, colour, *pose, (solid - middle) @ to_board, corners_px))
    both_ways = found + found[-2:0:-1]
    return both_ways * math.ceil(LEAST_FRAMES / len(both_ways))


class BoardTracer(Tracer):
    """Frames of a clip with the badge drawn on the board."""

    def __init__(self, badge: Path, camera: Webcam, clip: list[BoardView], board: PrintedBoard, forge: str | None):
        page = load_page(badge)
        course = ClipCourse("held", lambda t: t, lambda t: t, tuple(clip))
        build = built(page, np.random.default_rng(1))
        super().__init__(page, build, camera, course, Shoot(len(clip), FPS, 23, 7, forge))
        self.board, self.printed, self.clip = board, board.picture(), clip

    def _fill(self, t: float) -> None:
        """What is behind the badge: the frame itself, in light over that of the board's white squares."""
        view = self.view
        grey = view.grey.astype(np.float32)
        self.white = self._white(view)
        self.light[:] = PAPER * (grey / self.white) ** GAMMA

    @property
    def view(self) -> BoardView:
        """The frame that is drawn."""
        return self.clip[self.number]

    def draw_frame(self, number: int, rng: np.random.Generator) -> NDArray[np.uint8]:
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

    def _white(self, view: BoardView) -> NDArray[np.float32]:
        """Grey value of the board's white over the picture, as a plane, from the middles of its squares."""
        places, values = [], []
        columns, rows = self.board.size
        for column, row in np.ndindex(columns, rows):
            at = np.array([row - (rows - 1) / 2, (columns - 1) / 2 - column, 0]) * self.board.square
            x, y = np.rint(self._seen(view, at[None])[0]).astype(int)
            if 3 <= x < view.grey.shape[1] - 3 and 3 <= y < view.grey.shape[0] - 3:
                places.append([x, y, 1.0])
                values.append(float(np.median(view.grey[y - 3 : y + 4, x - 3 : x + 4])))
        table, level = np.array(places), np.array(values)
        bright = level > np.median(level)
        plane, *_ = np.linalg.lstsq(table[bright], level[bright], rcond=None)
        y, x = np.indices(view.grey.shape)
        return np.clip(plane[0] * x + plane[1] * y + plane[2], 40, 250).astype(np.float32)

    def _before(self, view: BoardView) -> NDArray[np.bool_]:
        """Pixels in which something is in front of the board."""
        half = np.array(self.board.size[::-1]) * self.board.square / 2
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        seen = self._seen(view, np.column_stack([corners, np.zeros(4)])).astype(np.float32)
        height, width = self.printed.shape
        flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32) - 0.5
        matrix = cv2.getPerspectiveTransform(flat, seen)
        expected = cv2.warpPerspective(self.printed, matrix, view.grey.shape[::-1], borderValue=255) / 255.0
        shown = view.grey / self.white
        black = float(np.percentile(shown[expected < 0.1], 50)) if np.any(expected < 0.1) else 0.2
        apart = np.abs(shown - (black + (1 - black) * expected)) > BEFORE_SHARE * (1 - black)
        kernel = np.ones((BEFORE_PX, BEFORE_PX), np.uint8)
        return cv2.morphologyEx(apart.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0

    def _seen(self, view: BoardView, solid: Array) -> Array:
        return self.camera.project(solid @ view.turn.T + view.place) - 0.5


def write_film(tracer: BoardTracer, path: Path, seed: int) -> None:
    """Write one film."""
    import av

    rng = np.random.default_rng(seed)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(FPS), options={"crf": "20", "preset": "fast"})
        stream.width, stream.height, stream.pix_fmt = *tracer.camera.size_px, "yuv420p"
        for k in range(len(tracer.clip)):
            frame = av.VideoFrame.from_ndarray(tracer.draw_frame(k, rng), format="yuv420p")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


def judged(job: tuple[Path | None, int, str, int, str | None], folder: Path) -> Row:
    """One film, with the focal length as solved over the true one."""
    data, number, pattern, width_mm, forge = job
    assert data is not None
    board, camera = load_board(data), webcam(data, number)
    path = folder / f"{'forged-' if forge else ''}real-{number}-{pattern}-{width_mm}{f'-{forge}' if forge else ''}.mp4"
    # In the proportions of the default board.
    size_mm = width_mm, round(width_mm * 160 / 146)
    with tempfile.TemporaryDirectory(dir=folder) as name:
        order = Order("Guest", payload="0f5ac3962d784be1", pattern=pattern, size_mm=size_mm)
        badge = printed(order, Path(name) / "badge")
        if not path.exists():
            clip = read_clip(data, number, camera, board)
            write_film(BoardTracer(Path(name) / "badge", camera, clip, board, forge), path, number)
            path.with_suffix(".json").write_text(badge.to_json(), encoding="utf-8")
    report = verify(path, Question(badge, badge.id))
    lens = report.measurement.camera if report.measurement else None
    row = film_row(f"webcam {number}", report, true=forge is None, gain_sd=report.invariant.gain_sd)
    if forge is None:
        row["answers"]["identity"] = identity_answer(report, badge)
    return row | {"focal over true": lens and lens.focal_px / camera.focal_px}


def cases(asked: Asked) -> dict[str, tuple[Path | None, int, str, int, str | None]]:
    """All films."""
    return {
        f"webcam {number}, {pattern}, {width} mm, {forge or 'true'}": (asked.data, number, pattern, width, forge)
        for width, pattern, forge, number in product(SIZES_MM, PATTERNS, (None, *FORGERIES), CAMERAS)
    }


QUESTIONS = {
    "genuine": "Is a true badge accepted that is drawn into films of four real webcams?",
    "identity": "Is its identity read there?",
    "forged": "Is a forged one rejected there? Frozen, or half the gain",
}
PART = Part(QUESTIONS, f"{OUTSIDE}, in real films", cases, judged, needs_data=True)
