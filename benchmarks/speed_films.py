"""The films of `verify_speed.py`: what phones film on good days and on bad ones, and what shows no badge at all.

They are by our own simulator: 20 s of measured motions ("handheld", "walk"), and 10 s where there are 240 frames a
second.  A `Room` of boxes and shelves, as textured as a real one, fills the films without a badge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge
from moireid.designer import Order, design_badge, payload_from_hex
from moireid.simulate.cameras import Camera, camera_named
from moireid.simulate.filming import film
from moireid.simulate.motion import Motion, Poses, motion_named
from moireid.simulate.scene import Build, Scene

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
SHORT = Path(__file__).parent.parent / "tests" / "data" / "films" / "genuine_2.0m.mp4"
SECONDS, SEED, DISTANCE_MM = 20.0, 3, 1000.0
BADGE = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_from_hex("7097c67b0fafc59b"))
OTHER = design_badge(Order("Grace Hopper", lens="50lpi"), payload_from_hex("0123456789abcdef"))
#: The camera looks away from the badge in spells of so many seconds, after so many with it; by so much, and takes this
#: long to turn.
AWAY_S, SEEN_S, AWAY_RAD, TURN_S = (0.5, 2.0), (1.0, 3.0), math.radians(50.0), 0.25
#: Pixels a millimetre of the drawn board.
BOARD_PX_PER_MM = 4


@dataclass(frozen=True)
class SpeedFilm:
    """A film by name, the badge that is claimed, its file's name, and what writes it.

    Convention: films of one file name are one film, judged by several claims.
    """

    name: str
    badge: Badge
    file: str
    write: Callable[[Path], None]

    def within(self, folder: Path) -> Path:
        """The film, written into the folder unless it is there."""
        path = folder / self.file
        if not path.exists():
            self.write(path)
        return path


def speed_films() -> Iterator[SpeedFilm]:
    """The stated set; nothing is written yet."""
    phone, room = camera_named("phone"), Room(camera_named("phone"))
    large, shaken = replace(phone, width=3840, height=2160, focal_px=2 * phone.focal_px), camera_named("sharpened")
    usual = partial(_filmed, phone, seconds=SECONDS)
    in_hand, hidden = usual, partial(usual, build=Build(), motion="walk", fps=30.0)
    yield SpeedFilm("in a hand, 60 fps", BADGE, "hand.mp4", in_hand)
    yield SpeedFilm("walk", BADGE, "walk.mp4", partial(usual, motion="walk", fps=30.0))
    away = partial(_filmed, shaken, seconds=SECONDS, looks_away=True, edit=room.behind)
    yield SpeedFilm("loses the badge, 60 fps", BADGE, "away.mp4", away)
    yield SpeedFilm("no badge", BADGE, "room.mp4", partial(hidden, edit=room.alone))
    yield SpeedFilm("foreign identity, 60 fps", OTHER, "hand.mp4", in_hand)
    yield SpeedFilm("foreign squares", BADGE, "squares.mp4", partial(hidden, edit=room.with_squares))
    yield SpeedFilm("240 fps", BADGE, "slow.mp4", partial(_filmed, phone, motion="walk", fps=240.0, seconds=10.0))
    yield SpeedFilm("4K", BADGE, "large.mp4", partial(_filmed, large, seconds=SECONDS, fps=30.0))


def _filmed(
    camera: Camera,
    out: Path,
    *,
    motion: str = "handheld",
    fps: float = 60.0,
    seconds: float,
    build: Build | None = None,
    looks_away: bool = False,
    edit: Callable[[int, Picture, Array], Picture] | None = None,
) -> None:
    """The badge held in the hand before a camera, or a camera carried around it."""
    path = motion_named(motion, distance_mm=DISTANCE_MM, seed=SEED)
    path = _looking_away(path) if looks_away else path
    scene = Scene(BADGE, build or Build.typical(1), camera)
    film(scene, path, out, frames=round(fps * seconds), fps=fps, edit=edit, seed=SEED)


def _looking_away(motion: Motion) -> Motion:
    """The same trajectory by a camera that turns away from the badge and back, at random times."""
    rng, count = np.random.default_rng(SEED), math.ceil(SECONDS / (AWAY_S[0] + SEEN_S[0]))
    starts, ends = np.cumsum(rng.uniform(*np.transpose([SEEN_S, AWAY_S]), (count, 2)).ravel()).reshape(-1, 2).T

    def poses(times_s: Array) -> Poses:
        straight, way = motion(times_s), np.zeros(len(times_s))
        for start, end in zip(starts, ends, strict=True):
            out, back = (np.clip((times_s - at) / TURN_S + 0.5, 0, 1) for at in (start, end))
            way += 0.5 * (np.cos(math.pi * back) - np.cos(math.pi * out))
        turn = Rotation.from_rotvec(np.outer(AWAY_RAD * way, [0.0, 1.0, 0.0])).as_matrix()
        return Poses(straight.camera_mm, turn @ straight.rotation)

    return poses


class Room:
    """Boxes, shelves and stripes behind or in place of the badge, moving with the picture; noise as a sensor's."""

    def __init__(self, camera: Camera) -> None:
        rng = np.random.default_rng(SEED)
        self._size = height, width = camera.height, camera.width
        self._wall = np.full((2 * height, 2 * width), 120, np.uint8)
        for _ in range(900):
            x, y = (int(v) for v in rng.integers(0, (2 * width, 2 * height)))
            w, h = (int(v) for v in 10 * 2 ** rng.uniform(0, 5, 2))
            box = cv2.boxPoints(((x, y), (w, h), float(rng.normal(0, 6)))).astype(np.int32)
            cv2.fillPoly(self._wall, [box], int(rng.integers(20, 235)), cv2.LINE_AA)
        self._noise = rng.normal(0, camera.noise_counts, (2 * height, 2 * width)).astype(np.float32)
        self._rng = rng
        self._board = _board_of_squares()
        self._middle = np.append(np.asarray(BADGE.markers.centers_mm).mean(axis=0), 1.0)

    def alone(self, number: int, picture: Picture, homography: Array) -> Picture:
        """The room without a badge."""
        height, width = self._size
        place = homography @ self._middle
        left, top = np.clip((width, height) - place[:2] / place[2], 0, (width, height))
        view = cv2.getRectSubPix(self._wall, (width, height), (left + width / 2, top + height / 2))
        row, column = self._rng.integers(0, (height, width))
        noise = self._noise[row : row + height, column : column + width]
        return np.asarray(np.clip(view + noise, 0, 255), np.uint8)

    def behind(self, number: int, picture: Picture, homography: Array) -> Picture:
        """The picture as it is, and the room where the page is out of it."""
        corners = cv2.perspectiveTransform(np.array([[[0.0, 0.0]], [list(BADGE.page_mm)]]), homography)
        gone = corners.max(axis=(0, 1)).min() < 0 or np.any(corners.min(axis=(0, 1)) > self._size[::-1])
        return self.alone(number, picture, homography) if gone else picture

    def with_squares(self, number: int, picture: Picture, homography: Array) -> Picture:
        """In the room a board with the badge's squares, two of them swapped, around a chessboard."""
        view = self.alone(number, picture, homography)
        size, warp = view.shape[::-1], homography @ np.diag([1 / BOARD_PX_PER_MM, 1 / BOARD_PX_PER_MM, 1.0])
        board = cv2.warpPerspective(self._board, warp, size, flags=cv2.INTER_AREA)
        there = cv2.warpPerspective(np.full_like(self._board, 255), warp, size, flags=cv2.INTER_NEAREST)
        return np.asarray(np.where(there > 0, board, view), np.uint8)


def _board_of_squares() -> Picture:
    """The page at `BOARD_PX_PER_MM`: a chessboard of centimetres, and the markers, the first and the third swapped."""
    markers, scale = BADGE.markers, BOARD_PX_PER_MM
    rows, columns = (np.arange(round(scale * length)) // (10 * scale) for length in reversed(BADGE.page_mm))
    board = np.where((rows[:, None] + columns) % 2 == 0, 40, 230).astype(np.uint8)
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
    side, white = round(scale * markers.size_mm), round(scale * markers.size_mm / 6)
    for place, (x, y) in enumerate(markers.centers_mm):
        left, top = round(scale * x - side / 2), round(scale * y - side / 2)
        cv2.rectangle(board, (left - white, top - white), (left + side + white, top + side + white), 230, cv2.FILLED)
        board[top : top + side, left : left + side] = cv2.aruco.generateImageMarker(
            known, markers.ids[(2, 1, 0, 3)[place]], side
        )
    return board
