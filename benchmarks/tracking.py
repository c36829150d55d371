"""Share of frames in which the badge is followed, and how well: `.venv/bin/python benchmarks/tracking.py [WORD ...]`.

Short films of our own simulator, 40 frames at 30 a second, H.264, 1080p; hands, glare, turns and cuts are painted over
the decoded frames.  WORDs leave only the rows that they begin.

tracked: share of the frames that show the whole badge.  corners: distance of the sixteen marker corners from where they
truly are, px, median and worst frame.  parallax: error of the camera's Cx/|Cz| of a single frame, root mean square,
before any smoothing, with the focal length known.  ms/frame: of the tracker alone.

Rows "back": the camera turns from a room full of things to the badge and away again, to nine places of the picture.
Printed: seconds from the first frame that shows the badge until it is followed, median and worst place.
"""

from __future__ import annotations

import itertools
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from speed_films import Room

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_from_hex
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import film, truth_path
from moireid.simulate.motion import Motion, Poses, motion_named
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Build, Scene
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.finding.markers import MarkerFinder
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.scene_tracker import SceneTracker
from moireid.verifier.tracking.track import Track
from moireid.verifier.video import Film

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
#: Changes a frame: picture, its number, and the true homography page -> px in; both out, None where no badge is seen.
Paint = Callable[[Picture, int, Array], tuple[Picture, Array | None]]
FRAMES, FPS, SEED = 40, 30.0, 5
CAMERA = Camera(shutter_s=0.0)
COVERS = {"none": (), "top left": (0,), "top both": (0, 1), "left both": (0, 3), "opposite": (0, 2), "three": (0, 1, 2)}


@dataclass(frozen=True)
class Filmed:
    """A film and its truth: homographies (T, 3, 3) page mm -> px, camera centres (T, 3) mm from the board's centre."""

    frames: list[Frame]
    homographies: Array
    camera_mm: Array
    camera: Camera
    badge: Badge

    @property
    def module_px(self) -> float:
        """Width of a marker's module in the first frame."""
        first = cv2.perspectiveTransform(marker_corners_mm(self.badge.markers)[:1], self.homographies[0])[0]
        return float(np.linalg.norm(first[1] - first[0]) / 6)


def main() -> None:
    """Print one row a case."""
    badge = design_badge(Request("Ada Lovelace"), payload_from_hex("7097c67b0fafc59b"))
    print(f"{'case':<28}{'frames':>7}{'tracked':>9}{'corners px':>14}{'parallax':>10}{'ms/frame':>10}")
    with tempfile.TemporaryDirectory() as folder:
        make = Maker(badge, Path(folder) / "film.mp4")
        for name, run in cases(make):
            if len(sys.argv) == 1 or name.startswith(tuple(sys.argv[1:])):
                run(name)


class Maker:
    """Makes films; asked for the same film again, it returns the first one."""

    def __init__(self, badge: Badge, video: Path) -> None:
        self.badge, self._video, self._made = badge, video, {}

    def at(self, distance_mm: float, *, motion: Motion | None = None, camera: Camera = CAMERA, key: str = "") -> Filmed:
        """The badge held in a hand, or moved otherwise, at a distance."""
        name = f"{distance_mm} {key}"
        if name not in self._made:
            course = motion or motion_named("handheld", distance_mm=distance_mm, seed=SEED)
            scene = Scene(self.badge, Build(), camera)
            film(scene, course, self._video, frames=FRAMES, fps=FPS, seed=SEED, overwrite=True)
            self._made = {name: _read(self._video, scene)}
        return self._made[name]


def cases(make: Maker) -> Iterator[tuple[str, Callable[[str], None]]]:
    """Every row: its name, and what prints it."""
    for distance_m in (1.0, 2.0, 3.0, 3.2, 3.6, 4.2):
        size_px = 26 * CAMERA.focal_px / distance_m / 1000
        yield f"size {size_px:.0f} px", lambda name, d=1000 * distance_m: _row(name, make.at(d))
    for word in ("sideways", "upwards", "slanting"):
        yield f"blur {word}", lambda name, word=word: _blur_rows(name, make, word)
    for distance_m in (1.0, 2.0):
        for word, covered in COVERS.items():
            yield (
                f"covered {word} {distance_m:g} m",
                lambda name, d=1000 * distance_m, covered=covered: _row(name, make.at(d), _hand(covered, make.badge)),
            )
    for share in (0.3, 0.6, 1.0):
        yield f"glare {share:g}", lambda name, share=share: _row(name, make.at(1000.0), _glare(share, make.badge))
    for degrees in range(0, 360, 45):
        yield f"turned {degrees}", lambda name, degrees=degrees: _row(name, make.at(1000.0), _turned(degrees))
    yield "mirrored", lambda name: _row(name, make.at(1000.0), _mirrored)
    for jump_px in (0, 150):
        yield f"cut, {jump_px} px aside", lambda name, jump_px=jump_px: _cut_row(name, make.at(2000.0), jump_px)
    for size_px in (36, 18, 13):
        distance_mm = 26 * CAMERA.focal_px / size_px
        for away_s in (1.0, 10.0):
            yield (
                f"back, {size_px} px, after {away_s:g} s",
                lambda name, d=distance_mm, away_s=away_s: _back_row(name, make.at(d), away_s),
            )
    yield "nothing", lambda name: _nothing_row(name, make.badge)


def _read(video: Path, scene: Scene) -> Filmed:
    """A film of the simulator with its poses."""
    rows = np.genfromtxt(truth_path(video), delimiter=",", names=True)
    camera_mm = np.column_stack([rows[f"camera_{axis}_mm"] for axis in "xyz"])
    rotation = np.column_stack([rows[f"r{i}{j}"] for i in (1, 2, 3) for j in (1, 2, 3)]).reshape(-1, 3, 3)
    to_board = np.array([[1, 0, -scene.board_centre_mm[0]], [0, 1, -scene.board_centre_mm[1]], [0, 0, 1.0]])
    homographies = []
    for turn, place in zip(rotation, camera_mm, strict=True):
        warp = scene.camera.matrix @ np.column_stack([turn[:, 0], turn[:, 1], -turn @ place]) @ to_board
        homographies.append(warp / warp[2, 2])
    return Filmed(list(Film(video).frames()), np.array(homographies), camera_mm, scene.camera, scene.badge)


def _follow(made: Filmed, paint: Paint | None) -> tuple[Track, Array, NDArray[np.bool_], float]:
    """The track of painted frames, the true homographies, which frames show the badge, and seconds a frame."""
    view, true, shown, spent = SceneTracker(made.badge), [], [], 0.0
    for frame, homography in zip(made.frames, made.homographies, strict=True):
        picture, there = paint(frame.luma.copy(), frame.index, homography) if paint else (frame.luma, homography)
        begun = time.perf_counter()
        view.push(Frame(frame.index, frame.time_s, picture))
        spent += time.perf_counter() - begun
        true.append(np.eye(3) if there is None else there)
        shown.append(there is not None and _inside(there, picture, made.badge))
    return view.trackers[0].take(), np.array(true), np.array(shown), spent / len(made.frames)


def _row(name: str, made: Filmed, paint: Paint | None = None, frames: NDArray[np.bool_] | None = None) -> None:
    """Print one case; frames: only these are used for the figures."""
    track, true, shown, spent = _follow(made, paint)
    asked = shown if frames is None else shown & frames
    kept = np.array([bool(asked[number]) for number in track.frame_numbers], bool)
    numbers, found = track.frame_numbers[kept], track.homographies[kept]
    if not len(numbers):
        print(f"{name:<28}{asked.sum():>7}{0:>9.3f}", flush=True)
        return
    points = marker_corners_mm(made.badge.markers).reshape(-1, 1, 2)
    apart, parallax = [], []
    for homography, number in zip(found, numbers, strict=True):
        seen, there = (cv2.perspectiveTransform(points, h).reshape(-1, 2) for h in (homography, true[number]))
        apart.append(np.sqrt(np.mean(np.sum((seen - there) ** 2, axis=1))))
        parallax.append(_parallax(seen, made) - _parallax(there, made))
    error = np.sqrt(np.mean(np.square(parallax)))
    print(
        f"{name:<28}{asked.sum():>7}{len(numbers) / asked.sum():>9.3f}{np.median(apart):>7.3f}{max(apart):>7.3f}"
        f"{error:>10.4f}{1e3 * spent:>10.1f}",
        flush=True,
    )


def _inside(homography: Array, picture: Picture, badge: Badge) -> bool:
    """Whether all markers lie in the picture, with a pixel to spare."""
    corners = cv2.perspectiveTransform(marker_corners_mm(badge.markers).reshape(-1, 1, 2), homography).reshape(-1, 2)
    size = np.array(picture.shape[::-1])
    # Their white border must be seen too: a fortieth of the badge's width.
    border = 0.025 * float(np.ptp(corners, axis=0).max())
    return bool(np.all(corners > border) and np.all(corners < size - border))


def _parallax(points_px: Array, made: Filmed) -> float:
    """Cx/|Cz| of the pose through the marker corners."""
    flat = np.column_stack([marker_corners_mm(made.badge.markers).reshape(-1, 2), np.zeros(16)])
    flat[:, :2] -= flat[:, :2].mean(axis=0)
    _, turn, shift = cv2.solvePnP(flat, points_px, made.camera.matrix, None, flags=cv2.SOLVEPNP_ITERATIVE)
    centre = -cv2.Rodrigues(turn)[0].T @ shift.ravel()
    return float(centre[0] / abs(centre[2]))


def _shaken(word: str, distance_mm: float) -> Motion:
    """A badge shaken once a second, so that its blur runs from nothing to two modules and more."""
    way = {"sideways": (1.0, 0.0), "upwards": (0.0, 1.0), "slanting": (0.7, 0.7)}[word]

    def poses(times_s: Array) -> Poses:
        beat = 75.0 * np.sin(2 * np.pi * 1.13 * times_s)
        place = np.column_stack([way[0] * beat, way[1] * beat, np.full_like(beat, distance_mm)])
        turn = Rotation.from_rotvec(np.outer(0.2 * np.sin(2 * np.pi * 0.7 * times_s), [0.0, 1.0, 0.0]))
        return Poses(-turn.inv().apply(place), turn.as_matrix())

    return poses


def _blur_rows(name: str, make: Maker, word: str) -> None:
    """One row a range of blur, in modules, of one film of a shaken badge with an exposure of a sixtieth of a second."""
    camera = replace(CAMERA, exposure_s=1 / 60)
    made = make.at(1000.0, motion=_shaken(word, 1000.0), camera=camera, key=word)
    centre = np.asarray(made.badge.markers.centers_mm).mean(axis=0).reshape(1, 1, 2)
    places = np.array([cv2.perspectiveTransform(centre, h).ravel() for h in made.homographies])
    blur = np.linalg.norm(np.gradient(places, axis=0), axis=1) * FPS * camera.exposure_s / made.module_px
    for low, high in ((0.0, 0.5), (0.5, 1.0), (1.0, 1.5), (1.5, 2.0), (2.0, 3.0)):
        _row(f"{name} {low:g} to {high:g}", made, None, (blur >= low) & (blur < high))


def _hand(covered: tuple[int, ...], badge: Badge) -> Paint:
    """Fingers of skin's brightness over markers, from the tenth frame on, trembling a little."""

    def paint(picture: Picture, number: int, homography: Array) -> tuple[Picture, Array]:
        for index in covered if number >= 10 else ():
            middle, outward = np.asarray(badge.markers.centers_mm[index]), np.array([1.0, 1.0])
            outward[:] = np.sign(middle - np.mean(badge.markers.centers_mm, axis=0))
            tip = middle - 8 * outward + 1.5 * np.sin(number / 5 + index)
            ends = cv2.perspectiveTransform(np.array([[tip, middle + 60 * outward]]), homography)[0]
            width = round(36 * np.linalg.norm(ends[1] - ends[0]) / np.linalg.norm(middle + 60 * outward - tip))
            cv2.line(picture, *(tuple(int(v) for v in np.round(end)) for end in ends), 150, max(width, 1), cv2.LINE_AA)
        return picture, homography

    return paint


def _glare(share: float, badge: Badge) -> Paint:
    """A white spot 40 mm wide that wanders over the top of the badge, of so much of full brightness."""

    def paint(picture: Picture, number: int, homography: Array) -> tuple[Picture, Array]:
        left, right = np.asarray(badge.markers.centers_mm)[:2]
        place = left + (right - left) * (0.5 - 0.5 * np.cos(number / 6))
        (x, y), edge = cv2.perspectiveTransform(np.array([[place, place + np.array([20.0, 0.0])]]), homography)[0]
        rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]]
        spot = np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / float(np.sum((edge - (x, y)) ** 2)))
        return np.clip(picture + 255 * share * spot, 0, 255).astype(np.uint8), homography

    return paint


def _turned(degrees: int) -> Paint:
    """The picture turned about its centre, in a square that holds it whole."""

    def paint(picture: Picture, number: int, homography: Array) -> tuple[Picture, Array]:
        height, width = picture.shape
        turn = np.eye(3)
        turn[:2] = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1.0)
        turn[1, 2] += (width - height) / 2
        return np.asarray(
            cv2.warpAffine(picture, turn[:2], (width, width), borderValue=90), np.uint8
        ), turn @ homography

    return paint


def _mirrored(picture: Picture, number: int, homography: Array) -> tuple[Picture, Array]:
    """A mirrored self-view; the track gives places in the picture turned back."""
    return np.ascontiguousarray(picture[:, ::-1]), homography


def _cut_row(name: str, made: Filmed, jump_px: int) -> None:
    """Frames from a badge's return, after half a second of another scene, until it is followed again."""
    away = range(12, 27)

    def paint(picture: Picture, number: int, homography: Array) -> tuple[Picture, Array | None]:
        if number in away:
            return np.full_like(picture, 90), None
        shift = np.eye(3)
        shift[0, 2] = jump_px if number >= away.stop else 0
        moved = cv2.warpAffine(picture, shift[:2], picture.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(moved, np.uint8), shift @ homography

    track, _, _, _ = _follow(made, paint)
    after = [int(number) for number in track.frame_numbers if number >= away.stop]
    until = f"{(after[0] - away.stop) / FPS:.2f} s until followed again" if after else "never followed again"
    print(f"{name:<28}{len(made.frames):>7}   {until}", flush=True)


def _back_row(name: str, made: Filmed, away_s: float) -> None:
    """Seconds until a badge is followed that comes back, at nine places of the picture one after another."""
    room, view, waits, shown, tracked = Room(CAMERA), SceneTracker(made.badge), [], 0, 0
    numbers = itertools.count()

    def push(picture: Picture) -> bool:
        number = next(numbers)
        return view.push(Frame(number, number / FPS, picture))

    for place in itertools.product((0.0, 0.5, 1.0), repeat=2):
        for number in range(round(away_s * FPS)):
            push(room.alone(number, made.frames[0].luma, made.homographies[number % FRAMES]))
        found = [push(picture) for picture in _at(place, made, room)]
        waits.append(found.index(True) / FPS if any(found) else np.inf)
        shown, tracked = shown + len(found), tracked + sum(found)
    print(
        f"{name:<28}{shown:>7}{tracked / shown:>9.3f}   {np.median(waits):.2f} s until followed, "
        f"{max(waits):.2f} at most",
        flush=True,
    )


def _at(place: tuple[float, float], made: Filmed, room: Room) -> Iterator[Picture]:
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


def _nothing_row(name: str, badge: Badge) -> None:
    """Time a frame of a film that shows a background alone, and the first one, next to what the two searches of a frame
    and of its mirror image take that are made without looking for small markers.
    """
    sensor, view, finder = Sensor(CAMERA, SEED), SceneTracker(badge), MarkerFinder(badge.markers)
    turns = Rotation.from_rotvec(np.outer(np.linspace(0, 0.1, FRAMES), [0.0, 1.0, 0.0])).as_matrix()
    spent, plain = [], 0.0
    for index, turn in enumerate(turns):
        picture = np.asarray(sensor.expose(None, turn, index / FPS))
        clock = time.process_time()
        view.push(Frame(index, index / FPS, picture))
        spent.append(1e3 * (time.process_time() - clock))
        clock = time.process_time()
        finder.pages(picture)
        finder.pages(np.ascontiguousarray(picture[:, ::-1]))
        plain += 1e3 * (time.process_time() - clock) / FRAMES
    print(
        f"{name:<28}{FRAMES:>7}   {sum(spent[1:]) / (FRAMES - 1):.0f} ms a frame of processor time, {spent[0]:.0f} the "
        f"first; {plain:.0f} for large markers alone by two searches; {view.trackers[0].tracked} finds",
        flush=True,
    )


if __name__ == "__main__":
    main()
