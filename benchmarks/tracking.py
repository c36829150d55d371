"""Frames in which the badge is followed, and how well: run `.venv/bin/python benchmarks/tracking.py [--only REGEX]`.

Short films of our own simulator, 40 frames at 30 a second, H.264, 1080p.

Rows "size": of the frames with the whole badge, the share in which it is followed; distance of the sixteen marker
corners from where they truly are, px, median and worst frame; error of the camera's Cx/|Cz| of a single frame, root
mean square, before any smoothing, with the focal length known; milliseconds a frame of the tracker alone.
Rows "back": the camera turns from a room full of things to the badge and away again, to nine places of the picture:
seconds from the first frame that shows the badge until it is followed, median and worst place.
Row "nothing": processor time a frame of a film that shows a background alone, and of the first one, next to what the
two searches of a frame and of its mirror image take that are made without looking for small markers.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from speed_films import Room

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import truth_path
from moireid.simulate.motion import motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Scene
from moireid.verifier.picture import Frame
from moireid.verifier.picture import Picture as FilmPicture
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.video import VIDEO_CONTRAST, VIDEO_RANGE, Film
from moireid_lab.bench.bench_frame import Bench, Row, Wish, run_script, temporary_film

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
FRAMES, FPS, SEED = 40, 30.0, 5
CAMERA = Camera(shutter_s=0.0)
DISTANCES_M, SIZES_PX, AWAY_S = (1.0, 2.0, 3.0, 3.2, 3.6, 4.2), (36, 18, 13), (1.0, 10.0)


@dataclass(frozen=True)
class HeldBadge:
    """A film of a badge in a hand, and its truth: homographies (T, 3, 3) page mm -> px."""

    frames: list[Frame]
    homographies: Array
    badge: Badge


def badge_held() -> Badge:
    """The badge of all films."""
    return design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))


def held(distance_mm: float) -> HeldBadge:
    """The badge held in a hand at a distance."""
    badge = badge_held()
    scene, motion = Scene(badge, Build(), CAMERA), motion_named("handheld", distance_mm=distance_mm, seed=SEED)
    with temporary_film(scene, motion, frames=FRAMES, fps=FPS, seed=SEED) as video:
        rows, frames = np.genfromtxt(truth_path(video), delimiter=",", names=True), list(Film(video).frames())
    camera_mm = np.column_stack([rows[f"camera_{axis}_mm"] for axis in "xyz"])
    rotation = np.column_stack([rows[f"r{i}{j}"] for i in (1, 2, 3) for j in (1, 2, 3)]).reshape(-1, 3, 3)
    to_board = np.array([[1, 0, -scene.board_centre_mm[0]], [0, 1, -scene.board_centre_mm[1]], [0, 0, 1.0]])
    warps = [
        CAMERA.matrix @ np.column_stack([turn[:, 0], turn[:, 1], -turn @ place]) @ to_board
        for turn, place in zip(rotation, camera_mm, strict=True)
    ]
    return HeldBadge(frames, np.array([warp / warp[2, 2] for warp in warps]), badge)


def as_coded(counts: Picture) -> FilmPicture:
    """A picture as video codes it."""
    return FilmPicture(np.rint(16 + counts * VIDEO_CONTRAST).astype(np.uint8), VIDEO_RANGE, VIDEO_CONTRAST)


def rows(wish: Wish) -> Iterator[Row]:
    """One row a case."""
    cases: dict[str, Callable[[], Row]] = {}
    for metres in DISTANCES_M:
        size_px = 26 * CAMERA.focal_px / metres / 1000
        cases[f"size {size_px:.0f} px"] = partial(_size_row, 1000 * metres)
    for size_px, away_s in itertools.product(SIZES_PX, AWAY_S):
        cases[f"back, {size_px} px, after {away_s:g} s"] = partial(_back_row, 26 * CAMERA.focal_px / size_px, away_s)
    cases["nothing"] = _nothing_row
    for name in wish.chosen(cases):
        yield {"case": name} | cases[name]()


def _size_row(distance_mm: float) -> Row:
    """How often and how well the badge is followed."""
    made = held(distance_mm)
    view, spent = SceneTracker(made.badge), 0.0
    whole = [_inside(homography, made.badge) for homography in made.homographies]
    for frame in made.frames:
        begun = time.perf_counter()
        view.push(frame)
        spent += time.perf_counter() - begun
    track = view.trackers[0].take()
    points = marker_corners_mm(made.badge.markers).reshape(-1, 1, 2)
    apart, parallax = [], []
    for homography, number in zip(track.homographies, track.frame_numbers, strict=True):
        if not whole[number]:
            continue
        seen, there = (
            cv2.perspectiveTransform(points, one).reshape(-1, 2) for one in (homography, made.homographies[number])
        )
        apart.append(np.sqrt(np.mean(np.sum((seen - there) ** 2, axis=1))))
        parallax.append(_parallax(seen, made.badge) - _parallax(there, made.badge))
    return {
        "tracked": len(apart) / sum(whole),
        "corners px": float(np.median(apart)) if apart else None,
        "worst": float(max(apart)) if apart else None,
        "parallax": float(np.sqrt(np.mean(np.square(parallax)))) if apart else None,
        "ms a frame": 1e3 * spent / len(made.frames),
    }


def _inside(homography: Array, badge: Badge) -> bool:
    """Whether all markers are in the picture, with their white border, a fortieth of the badge's width."""
    corners = cv2.perspectiveTransform(marker_corners_mm(badge.markers).reshape(-1, 1, 2), homography).reshape(-1, 2)
    border = 0.025 * float(np.ptp(corners, axis=0).max())
    return bool(np.all(corners > border) and np.all(corners < np.array([CAMERA.width, CAMERA.height]) - border))


def _parallax(points_px: Array, badge: Badge) -> float:
    """Cx/|Cz| of the pose through the marker corners."""
    flat = np.column_stack([marker_corners_mm(badge.markers).reshape(-1, 2), np.zeros(16)])
    flat[:, :2] -= flat[:, :2].mean(axis=0)
    _, turn, shift = cv2.solvePnP(flat, points_px, CAMERA.matrix, None, flags=cv2.SOLVEPNP_ITERATIVE)
    centre = -cv2.Rodrigues(turn)[0].T @ shift.ravel()
    return float(centre[0] / abs(centre[2]))


def _back_row(distance_mm: float, away_s: float) -> Row:
    """Seconds until a badge is followed that comes back, at nine places of the picture one after another."""
    made = held(distance_mm)
    room, view, waits, shown, tracked = Room(CAMERA), SceneTracker(made.badge), [], 0, 0
    numbers = itertools.count()

    def push(picture: Picture) -> bool:
        number = next(numbers)
        return view.push(Frame(number, number / FPS, as_coded(picture)))

    for place in itertools.product((0.0, 0.5, 1.0), repeat=2):
        for number in range(round(away_s * FPS)):
            push(room.alone(number, made.frames[0].luma, made.homographies[number % FRAMES]))
        found = [push(picture) for picture in _at(place, made, room)]
        waits.append(found.index(True) / FPS if any(found) else np.inf)
        shown, tracked = shown + len(found), tracked + sum(found)
    return {"tracked": tracked / shown, "s until followed": float(np.median(waits)), "at most": float(max(waits))}


def _at(place: tuple[float, float], made: HeldBadge, room: Room) -> Iterator[Picture]:
    """A film's pictures with the badge moved to a place, (0, 0) top left to (1, 1) bottom right, before the room."""
    x, y = made.badge.page_mm
    page = np.array([[[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]]])
    outlines = np.array([cv2.perspectiveTransform(page, homography)[0] for homography in made.homographies])
    low, high = outlines.min(axis=(0, 1)), outlines.max(axis=(0, 1))
    shift = np.round(place * (np.array([CAMERA.width, CAMERA.height]) - 8 - (high - low)) + 4 - low)
    moved = np.array([[1, 0, shift[0]], [0, 1, shift[1]]])
    for frame, homography, outline in zip(made.frames, made.homographies, outlines, strict=True):
        picture = cv2.warpAffine(frame.luma, moved, frame.luma.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
        there = cv2.fillConvexPoly(np.zeros_like(picture), np.round(outline + shift).astype(np.int32), 1)
        yield np.where(there > 0, picture, room.alone(frame.index, picture, homography))


def _nothing_row() -> Row:
    """Milliseconds of processor time."""
    badge = badge_held()
    sensor, view, finder = Sensor(CAMERA, SEED), SceneTracker(badge), MarkerFinder(badge.markers)
    turns = Rotation.from_rotvec(np.outer(np.linspace(0, 0.1, FRAMES), [0.0, 1.0, 0.0])).as_matrix()
    spent, plain = [], 0.0
    for index, turn in enumerate(turns):
        picture = np.asarray(sensor.expose(None, turn, index / FPS))
        clock = time.process_time()
        view.push(Frame(index, index / FPS, as_coded(picture)))
        spent.append(1e3 * (time.process_time() - clock))
        clock = time.process_time()
        finder.pages(picture)
        finder.pages(np.ascontiguousarray(picture[:, ::-1]))
        plain += 1e3 * (time.process_time() - clock) / FRAMES
    found = {"CPU ms a frame": sum(spent[1:]) / (FRAMES - 1), "the first": spent[0], "large markers alone": plain}
    return found | {"finds": view.trackers[0].tracked}


COLUMNS = {"case": "<27", "tracked": ">8.3f", "corners px": ">10.3f", "worst": ">7.3f", "parallax": ">9.4f"}
COLUMNS |= {"ms a frame": ">10.1f", "s until followed": ">16.2f", "at most": ">7.2f", "CPU ms a frame": ">14.0f"}
COLUMNS |= {"the first": ">9.0f", "large markers alone": ">19.0f", "finds": ">5"}
BENCH = Bench(rows, COLUMNS)

if __name__ == "__main__":
    run_script(__file__)
