"""A badge on a board that is held before real webcams: run `moireid lab bench half-real --data DIR`.

DIR holds clips of a ChArUco board, `hold_N.mp4`, the board's `charuco.toml`, and each camera's matrix and distortion in
`camera_array.toml`, as caliscope records them.  The board's pose in each frame follows from its corners and the known
lens.  There a printed badge is drawn by `outside`, which shares nothing with `moireid.simulate`: through that lens, in
the light that the board's white squares show, with the camera's noise.  What is in front of the board, fingers and
glare, stays in front of the badge.  So lens, hands, room and motion are real.  The clips are short and are played to
and fro.

Printed is, for each camera, badge and forgery, the verdict, the gain with its error bar, how many frames were tracked,
whether the identity was read, and the camera as estimated next to the true one.  With `--keep DIR` the films are kept,
each with its badge next to it, as `golden.py` reads them.
"""

from __future__ import annotations

import math
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from pathlib import Path

import cv2
import numpy as np
from half_real_poses import MM_PER_M, error_row, joint_pose
from numpy.typing import NDArray
from outside.build import built
from outside.camera import Camera
from outside.film import Shoot, Tracer
from outside.motion import Course
from outside.page import PAPER, load_page

import moireid
from moireid.badge import Badge
from moireid.verifier import Question, Report, verify
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.verdicts import why_not

Array = NDArray[np.float64]
#: Frames a second of the clips, and the fewest corners of the board that give its pose.
FPS, LEAST_CORNERS = 6, 8
#: Fewest cameras that give a joint pose.
LEAST_VIEWS = 3
#: Shorter clips are played to and fro again.
LEAST_FRAMES = 80
#: The default badge, mm, and the largest that pdfium draws whole at 1200 dpi.
SIZES_MM = (146, 175)
PATTERNS = ("silk", "cells")
FORGERIES = ("gain_0.5", "frozen")
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

    @property
    def tangent(self) -> float:
        """The camera's parallax coordinate."""
        return parallax(-self.turn.T @ self.place)


def parallax(camera_mm: Array) -> float:
    """Cx/|Cz| of a camera in the badge's frame."""
    return float(camera_mm[0] / abs(camera_mm[2]))


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


def judged(report: Report, badge: Badge, camera: Webcam) -> Row:
    """What becomes of one film, with the camera as solved next to the true one."""
    lens = report.measurement.camera if report.measurement else None
    middle = np.array(camera.center_px) - 0.5 - (np.array(camera.size_px) - 1) / 2
    return {
        "verdict": report.verdict,
        "gain": report.invariant.gain_ratio,
        "error bar": report.invariant.gain_sd,
        "tracked": report.frames["tracked"],
        "read": report.identity.decoded_id == badge.id,
        "f": lens and lens.focal_px,
        "true f": camera.focal_px,
        "k1": lens and lens.bend_k1,
        "true k1": float(camera.distortion[0]),
        "axis off, px": float(np.hypot(*(np.array(lens.axis_px) - middle))) if lens else None,
        "why": why_not(report),
    }


def printed(folder: Path, pattern: str, width_mm: int) -> Badge:
    """A board of that width, in the proportions of the default one, printed into the folder."""
    size_mm = width_mm, round(width_mm * 160 / 146)
    badge = moireid.design("Guest", payload="0f5ac3962d784be1", pattern=pattern, size_mm=size_mm)
    if not folder.exists():
        moireid.print_badge(badge, folder, mount="none")
    return badge


def pose_rows(data: Path, board: PrintedBoard, numbers: list[int], badge: Badge) -> Iterator[Row]:
    """Of each camera, how far its poses are from those by all of them."""
    cameras = {number: webcam(data, number) for number in numbers}
    clips = {number: read_clip(data, number, camera, board) for number, camera in cameras.items()}
    worlds = {number: camera_in_world(data, number) for number in numbers}
    views = {number: {view.number: view for view in clip} for number, clip in clips.items()}
    joint: dict[int, dict[int, float]] = {number: {} for number in numbers}
    for frame in sorted(set().union(*views.values())):
        shown = [number for number in numbers if frame in views[number]]
        if len(shown) < LEAST_VIEWS:
            continue
        here = {number: views[number][frame] for number in shown}
        first, world = here[shown[0]], worlds[shown[0]]
        start = world[:, :3].T @ first.turn, world[:, :3].T @ (first.place - world[:, 3])
        seen = [
            (view.solid, view.corners, cameras[number].matrix, cameras[number].distortion, worlds[number])
            for number, view in here.items()
        ]
        turn, place = joint_pose(seen, start)
        for number in shown:
            world = worlds[number]
            joint[number][frame] = parallax(-turn.T @ (place + world[:, :3].T @ world[:, 3]))
    for number in numbers:
        frames = list(joint[number])
        alone, together = (np.array([one[frame] for frame in frames]) for one in (views[number], joint[number]))
        alone = np.array([view.tangent for view in alone])
        yield {"camera": number, "poses of": "one view"} | error_row(alone, together, badge, FPS)


def solved_row(report: Report, clip: list[BoardView], badge: Badge) -> Row:
    """How far the poses of a film are from those at which its badge was drawn."""
    low, top, high, bottom = badge.outline_mm
    middle = np.array([(low + high) / 2, (top + bottom) / 2, 0.0])
    found = np.array([parallax(place - middle) for place in report.measurement.camera_mm])
    true = np.array([clip[frame].tangent for frame in report.track.frame_numbers])
    return error_row(found, true, badge, FPS)


def camera_in_world(folder: Path, number: int) -> Array:
    """A camera's rotation and translation from the world's frame, (3, 4), mm."""
    config = tomllib.loads((folder / "camera_array.toml").read_text(encoding="utf-8"))["cameras"][str(number)]
    return np.column_stack([config["rotation"], MM_PER_M * np.array(config["translation"])])


def rows(wish: Wish) -> Iterator[Row]:
    """One row a film."""
    own = wish.own
    with wish.kept_folder() as kept:
        board = load_board(own.data)
        for pattern, width_mm in product(own.patterns, own.sizes):
            home = kept / f"{pattern}-{width_mm}"
            badge = printed(home, pattern, width_mm)
            for number in own.cameras:
                camera = webcam(own.data, number)
                clip = read_clip(own.data, number, camera, board)
                found = {"camera": number, "badge": home.name, "frames": len(clip)}
                for forge in (None, *own.forged):
                    name = f"{'forged-' if forge else ''}real-{number}-{home.name}{f'-{forge}' if forge else ''}"
                    path = kept / f"{name}.mp4"
                    if not path.exists():
                        write_film(BoardTracer(home, camera, clip, board, forge), path, number)
                        shutil.copy(home / "badge.json", path.with_suffix(".json"))
                    report = verify(path, Question(badge, badge.id))
                    yield found | {"film": forge or "true"} | judged(report, badge, camera)
                    if forge is None and report.measurement is not None:
                        yield {"camera": number, "poses of": home.name} | solved_row(report, clip, badge)
        yield from pose_rows(own.data, board, own.cameras, badge)


OPTIONS = {
    "--data": {"type": Path, "required": True, "metavar": "DIR"},
    "--cameras": {"type": int, "nargs": "*", "default": [0, 1, 2, 3]},
    "--patterns": {"nargs": "*", "default": PATTERNS},
    "--sizes": {"type": int, "nargs": "*", "default": SIZES_MM, "help": "widths of the board, mm"},
    "--forged": {"nargs": "*", "default": FORGERIES},
}
COLUMNS = {"camera": ">6", "badge": "<9", "film": "<8", "verdict": "<12", "gain": ">7.3f", "error bar": ">9.3f"}
COLUMNS |= {"tracked": ">7", "frames": ">6", "read": ">5", "f": ">5.0f", "true f": ">6.0f", "k1": ">6.2f"}
COLUMNS |= {"true k1": ">7.2f", "axis off, px": ">12.0f", "why": "<1"}
COLUMNS |= {"poses of": "<9", "poses": ">5", "rms": ">6.4f", "median": ">6.4f", "< 0.2 Hz": ">8.2f", "to 1 Hz": ">7.2f"}
COLUMNS |= {"faster": ">6.2f", "of the law, rad": ">15.3f", "its median": ">10.3f"}
BENCH = Bench(rows, COLUMNS, options=OPTIONS, table=lambda rows: sorted(rows, key=lambda row: "poses of" in row))
