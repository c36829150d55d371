"""What a page may be found by, compared on the same films: `.venv/bin/python benchmarks/fiducials.py [WORD ...]`.

Short films of our own simulator, 36 frames at 30 a second, H.264: one badge, one course, one camera (1450 px) and one
seed for each distance; only the fiducial differs.  Pictures are as large as the badge needs.  WORDs leave only the
rows that they begin.

covers: share of the board that the fiducial takes, with the white around it.  alone: share of the frames in which a
search of the whole picture finds the page, without the frame before and without enlarging.  tracked: share that is
followed and registered.  corners: distance of the field's four corners from where they truly are, px, root mean square
over them, median and worst tracked frame.  parallax: error of the camera's Cx/|Cz| of a single frame, root mean square,
before any smoothing, with the focal length known.  ms: processor time of the tracker a frame.

Rows "held": two thumbs over the board's edges from the tenth frame on.  Rows "shaken": by 60 px to either side once a
second, with an exposure of a sixtieth.  Rows "least": how small a square or a line may be, over three courses.  Rows
"format": the smallest with which a format's own badge is tracked in 98 % of the frames at the far end of its range.

STag's detector is asked for by `pip install stag-python`; its rows are left out where that is missing.  Its own corners
are printed, and those of its squares registered as ours are.  "none": the board's outline and the name, with and
without the field's borders, registered as ours are; there is no search for it, so it is given its true place in the
first frame, and again in each frame where it was lost.
"""

from __future__ import annotations

import itertools
import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from unittest import mock

import cv2
import numpy as np
from fiducial_stag import STAG, stag_page, stag_print
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from moireid.badge import Badge, Cell, CodedFrame, Fiducial, Grating, Markers, Rect
from moireid.designer import Request, design_badge
from moireid.designer.formats import FORMATS, in_format
from moireid.designer.layout import coded_frame
from moireid.profiles import lens_named
from moireid.simulate.analytic.traced_page import TEXTURE_PX_PER_MM, page_texture
from moireid.simulate.cameras import Camera
from moireid.simulate.filming import film, truth_path
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Scene
from moireid.verifier.picture import Frame
from moireid.verifier.tracking.patches import Patch
from moireid.verifier.tracking.print_template import TemplatePrinter
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar
from moireid.verifier.tracking.scene_tracker import SceneTracker, finder_of
from moireid.verifier.video import Film

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Picture = NDArray[np.uint8]
#: Paints over a picture, given the homography page mm -> px.
Paint = Callable[[Picture, Array], Picture]
FRAMES, FPS, SEED, FOCAL_PX = 36, 30.0, 5, 1450.0
#: Squares and lines of "least", px, and the distances from which they are seen, m.
LEAST_PX, LEAST_LINE_PX, LEAST_M = (7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 14.0), (1.2, 1.5, 1.8, 2.1, 2.5), (1.0, 2.0)
COURSES = (0.0, 0.9, 1.7)
#: Share of the frames in which a format's smallest fiducial is tracked; focal length of a laptop's camera (`webcam`).
FORMAT_SHARE, LAPTOP_PX = 0.98, 960.0
#: Thumbs lie over the board from this frame on.
HELD_FROM = 10
DISTANCES_M = (0.5, 1.0, 2.0)
PAGE_MM, BOARD_MM = (210.0, 297.0), (32.0, 68.5, 178.0, 228.5)
FIELD_MM = (45.0, 106.0, 165.0, 191.0)
MARGIN_MM = 5.0
#: Sides of the squares and widths of the frames' lines, mm.
SQUARES_MM, LINES_MM = (26.0, 18.0, 13.0, 9.0, 6.0), (3.0, 2.0, 1.0)


@dataclass(frozen=True)
class Filmed:
    """Frames and their truth: homographies (T, 3, 3) page mm -> px."""

    frames: list[Frame]
    homographies: Array
    camera: Camera
    badge: Badge


@dataclass(frozen=True)
class Outcome:
    """Homographies (T,) by frame, None where the page was not followed; likewise by a search alone; ms a frame."""

    tracked: list[Array | None]
    alone: list[Array | None]
    ms: float


def main() -> None:
    """Print one row for each fiducial and distance."""
    print(f"{'fiducial':<22}{'covers':>8}{'m':>5}{'alone':>7}{'tracked':>9}{'corners px':>14}{'parallax':>10}{'ms':>7}")
    with tempfile.TemporaryDirectory() as folder:
        for name, run in rows(Path(folder) / "film.mp4"):
            if len(sys.argv) == 1 or name.startswith(tuple(sys.argv[1:])):
                for metres in DISTANCES_M:
                    run(name, metres)
        for kind, make, sizes_px in (("squares", _squares, LEAST_PX), ("frame", _frame, LEAST_LINE_PX)):
            if len(sys.argv) == 1 or f"least {kind}".startswith(tuple(sys.argv[1:])):
                _least(Path(folder) / "film.mp4", kind, make, sizes_px)
        for form in FORMATS:
            if len(sys.argv) == 1 or f"format {form}".startswith(tuple(sys.argv[1:])):
                _smallest(Path(folder) / "film.mp4", form, "squares", LEAST_PX)
                _smallest(Path(folder) / "film.mp4", form, "frame", LEAST_LINE_PX)


def rows(video: Path) -> Iterator[tuple[str, Callable[[str, float], None]]]:
    """Every row: its name, and what prints it."""
    for side in SQUARES_MM:
        yield f"squares {side:g}", partial(_ours, video, _squares(side))
    for line in LINES_MM:
        yield f"frame {line:g}", partial(_ours, video, _frame(line))
    for size, words in (("16h5", "DICT_APRILTAG_16h5"), ("36h11", "DICT_APRILTAG_36h11")):
        yield f"AprilTag {size} 26", partial(_ours, video, _squares(26.0, words))
    yield "STag 26", partial(_stag, video)
    yield "none", partial(_none, video)
    for fiducial, words in ((_squares(26.0), "squares 26"), (_squares(9.0), "squares 9"), (_frame(3.0), "frame 3")):
        yield f"held, {words}", partial(_ours, video, fiducial, paint=_thumbs)
    yield "held, none", partial(_none, video, paint=_thumbs)
    for fiducial, words in ((_squares(26.0), "squares 26"), (_squares(13.0), "squares 13"), (_frame(3.0), "frame 3")):
        yield f"shaken, {words}", partial(_ours, video, fiducial, shaken=True)


def _squares(side: float, words: str = "DICT_4X4_50") -> Markers:
    """Four squares in the board's corners."""
    x0, y0, x1, y1 = BOARD_MM
    inset = MARGIN_MM + side / 2
    near, far = (x0 + inset, y0 + inset), (x1 - inset, y1 - inset)
    return Markers(words, side, (0, 1, 2, 3), (near, (far[0], near[1]), far, (near[0], far[1])))


def _frame(line: float) -> CodedFrame:
    """A frame around the field, a line and a little away from it."""
    x0, y0, x1, y1 = FIELD_MM
    out = line + max(1.05 * line, 1.5)
    return coded_frame((x0 - out, y0 - out, x1 + out, y1 + out), line)


def _badge(fiducial: Fiducial) -> Badge:
    cell = Cell(FIELD_MM, 0.5192, 45.0, 0.5)
    grating = Grating(FIELD_MM, "x", 0.5192, "pitch", (cell,))
    return Badge(None, "Ada Lovelace", PAGE_MM, lens_named("50lpi"), (grating,), fiducial, board_mm=BOARD_MM)


def _covers(fiducial: Fiducial) -> float:
    """Share of the board under the fiducial and the white that it needs."""
    if isinstance(fiducial, CodedFrame):
        (x0, y0, x1, y1), (a, b, c, d) = fiducial.rect_mm, FIELD_MM
        area = (x1 - x0) * (y1 - y0) - (c - a) * (d - b)
    else:
        area = 4 * (1.35 * fiducial.size_mm) ** 2
    return area / ((BOARD_MM[2] - BOARD_MM[0]) * (BOARD_MM[3] - BOARD_MM[1]))


def _in_a_hand(distance_mm: float, begun_s: float, times_s: Array) -> Poses:
    """A badge that a hand turns to and fro, and that wanders and trembles by some 20 px."""
    times_s = times_s + begun_s
    px_mm = distance_mm / FOCAL_PX
    beat = np.sin(2 * np.pi * np.outer(times_s, [0.7, 0.5, 0.4]) + (0.3, 1.0, 2.0))
    tremor = np.sin(2 * np.pi * np.outer(times_s, [5.3, 6.1]) + (0.0, 1.5))
    place = np.column_stack(
        [px_mm * (18 * beat[:, 0] + tremor[:, 0]), px_mm * (12 * beat[:, 1] + tremor[:, 1]), distance_mm + 0 * times_s]
    )
    turn = Rotation.from_rotvec(beat[:, [1, 0, 2]] * (0.08, 0.15, 0.05))
    return Poses(-turn.inv().apply(place), turn.as_matrix())


def _shaken(distance_mm: float, times_s: Array) -> Poses:
    """A badge shaken sideways once a second, by 60 px to either side."""
    beat = np.sin(2 * np.pi * 1.13 * times_s)
    place = np.column_stack([60 * distance_mm / FOCAL_PX * beat, 0 * beat, distance_mm + 0 * beat])
    turn = Rotation.from_rotvec(np.outer(0.2 * np.sin(2 * np.pi * 0.7 * times_s), [0.0, 1.0, 0.0]))
    return Poses(-turn.inv().apply(place), turn.as_matrix())


def _film(
    video: Path,
    badge: Badge,
    metres: float,
    texture: Callable[[Scene], Single] = page_texture,
    begun_s: float = 0.0,
    shaken: bool = False,
    focal_px: float = FOCAL_PX,
) -> Filmed:
    """The film of a badge held in a hand, in a picture as large as it needs."""
    x0, y0, x1, y1 = badge.board_mm or BOARD_MM
    side = 16 * math.ceil(1.5 * max(x1 - x0, y1 - y0) * focal_px / (1000 * metres) / 16)
    camera = Camera(width=side, height=side, focal_px=focal_px, shutter_s=0.0)
    course = partial(_in_a_hand, 1000 * metres, begun_s)
    if shaken:
        camera, course = replace(camera, width=2 * side, exposure_s=1 / 60), partial(_shaken, 1000 * metres)
    scene = Scene(badge, Build(), camera)
    with mock.patch("moireid.simulate.analytic.analytic_renderer.page_texture", texture):
        film(scene, course, video, frames=FRAMES, fps=FPS, seed=SEED, overwrite=True)
    rows = np.genfromtxt(truth_path(video), delimiter=",", names=True)
    centres = np.column_stack([rows[f"camera_{axis}_mm"] for axis in "xyz"])
    turns = np.column_stack([rows[f"r{i}{j}"] for i in (1, 2, 3) for j in (1, 2, 3)]).reshape(-1, 3, 3)
    to_board = np.array([[1, 0, -scene.board_centre_mm[0]], [0, 1, -scene.board_centre_mm[1]], [0, 0, 1.0]])
    found = [
        scene.camera.matrix @ np.column_stack([turn[:, 0], turn[:, 1], -turn @ place]) @ to_board
        for turn, place in zip(turns, centres, strict=True)
    ]
    return Filmed(list(Film(video).frames()), np.array([one / one[2, 2] for one in found]), scene.camera, badge)


def _ours(
    video: Path, fiducial: Fiducial, name: str, metres: float, paint: Paint | None = None, shaken: bool = False
) -> None:
    """A fiducial that the verifier knows, or finds by OpenCV's dictionaries."""
    made = _painted(_film(video, _badge(fiducial), metres, shaken=shaken), paint)
    _print(name, metres, _covers(fiducial), made, _seen(made, fiducial))


def _seen(made: Filmed, fiducial: Fiducial) -> Outcome:
    """What the verifier's tracker, and a search alone, see of a film."""
    view, finder, tracked, alone, spent = SceneTracker(made.badge), finder_of(fiducial), [], [], 0.0
    for frame in made.frames:
        begun = time.process_time()
        tracked.append(view.trackers[0].place if view.push(frame) else None)
        spent += time.process_time() - begun
        pages = finder.either_way(frame.luma)[0]
        alone.append(pages[0] if pages else None)
    return Outcome(tracked, alone, 1e3 * spent / len(made.frames))


def _least(video: Path, kind: str, make: Callable[[float], Fiducial], sizes_px: Sequence[float]) -> None:
    """A row for each size: share tracked, over courses and distances, and the worst clip."""
    for size_px in sizes_px:
        shares, alone = [], []
        for metres, begun_s in itertools.product(LEAST_M, COURSES):
            fiducial = make(size_px * 1000 * metres / FOCAL_PX)
            outcome = _seen(_film(video, _badge(fiducial), metres, begun_s=begun_s), fiducial)
            shares.append(np.mean([page is not None for page in outcome.tracked]))
            alone.append(np.mean([page is not None for page in outcome.alone]))
        print(
            f"{f'least {kind} {size_px:g} px':<22}{'':>8}{'':>5}{np.mean(alone):>7.2f}{np.mean(shares):>9.3f}"
            f"   worst clip {min(shares):.3f}",
            flush=True,
        )


def _smallest(video: Path, form: str, kind: str, sizes_px: Sequence[float]) -> None:
    """A row for a format: its smallest squares, in their places, or its thinnest frame, that is tracked far away."""
    badge = design_badge(in_format(Request("Bench", markers=kind), form), bytes(8))
    assert badge.range_m is not None
    far_m, focal_px, own = badge.range_m[1], LAPTOP_PX if form == "webcam" else FOCAL_PX, badge.markers
    own_mm = own.line_mm if isinstance(own, CodedFrame) else own.size_mm
    for size_px in sizes_px:
        size_mm = size_px * 1000 * far_m / focal_px
        fiducial = coded_frame(own.rect_mm, size_mm) if isinstance(own, CodedFrame) else replace(own, size_mm=size_mm)
        small = replace(badge, markers=fiducial)
        films = [_film(video, small, far_m, begun_s=begun_s, focal_px=focal_px) for begun_s in COURSES]
        share = np.mean([page is not None for made in films for page in _seen(made, fiducial).tracked])
        if share >= FORMAT_SHARE:
            result = f"{size_mm:.1f} mm ({size_px:g} px), {share:.3f} tracked"
            break
    else:
        result = f"none of up to {size_mm:.1f} mm ({sizes_px[-1]:g} px)"
    print(f"format {form} {kind}, {far_m:g} m: {result}; as made {own_mm:.1f} mm", flush=True)


def _painted(made: Filmed, paint: Paint | None) -> Filmed:
    """The film with something painted over each frame."""
    if paint is None:
        return made
    frames = [
        Frame(frame.index, frame.time_s, paint(frame.luma.copy(), homography)) if frame.index >= HELD_FROM else frame
        for frame, homography in zip(made.frames, made.homographies, strict=True)
    ]
    return replace(made, frames=frames)


def _thumbs(picture: Picture, homography: Array) -> Picture:
    """Two thumbs of skin's brightness, 16 mm wide, that reach 14 mm over the left and right edge of the board."""
    for edge, way in ((BOARD_MM[0], 1.0), (BOARD_MM[2], -1.0)):
        tip = (edge + way * 6.0, 170.0)
        ends = cv2.perspectiveTransform(np.array([[tip, (tip[0] - way * 60.0, tip[1] + 10.0)]]), homography)[0]
        width = max(round(16.0 * float(np.linalg.norm(ends[1] - ends[0])) / 60.8), 1)
        cv2.line(picture, *(tuple(int(v) for v in np.round(end)) for end in ends), 150, width, cv2.LINE_AA)
    return picture


def _followed(made: Filmed, registrar: PageRegistrar, found: list[Array | None]) -> tuple[list[Array | None], float]:
    """The page registered from where the frame before had it, or else from where a search finds it; ms a frame."""
    tracked: list[Array | None] = []
    template, begun = KeptTemplate(registrar.printer), time.process_time()
    for frame, start in zip(made.frames, found, strict=True):
        last = tracked[-1] if tracked else None
        tries = [page for page in (last, start) if page is not None]
        pages = (registrar.register(frame.picture, page, template.at(page)) for page in tries)
        tracked.append(next((one.homography for one in pages if one is not None), None))
    return tracked, 1e3 * (time.process_time() - begun) / len(made.frames)


def _stag(video: Path, name: str, metres: float) -> None:
    """STag's squares, found by its own detector; and registered as ours are."""
    try:
        import stag  # type: ignore[import-not-found]
    except ImportError:
        print(f"{name:<22}  left out: pip install stag-python", flush=True)
        return
    places = _squares(26.0)
    patches = tuple(
        Patch(center, (13.0, 13.0), partial(stag_print, word, 26.0))
        for (word, _), center in zip(STAG.values(), places.centers_mm, strict=True)
    )
    made = _film(video, _badge(places), metres, partial(_texture, patches))
    alone: list[Array | None] = []
    begun = time.process_time()
    for frame in made.frames:
        corners, ids, _ = stag.detectMarkers(cv2.cvtColor(frame.luma, cv2.COLOR_GRAY2BGR), 11)
        alone.append(stag_page(corners, np.ravel(ids).tolist(), places))
    spent = 1e3 * (time.process_time() - begun) / len(made.frames)
    _print(f"{name} itself", metres, _covers(places), made, Outcome(alone, alone, spent))
    tracked, ms = _followed(made, PageRegistrar(TemplatePrinter(patches, 26.0 / 6)), alone)
    _print(f"{name} registered", metres, _covers(places), made, Outcome(tracked, alone, ms))


def _none(video: Path, name: str, metres: float, paint: Paint | None = None) -> None:
    """No fiducial: the board's outline, the field's borders and the name."""
    outline, field, words = _around(BOARD_MM, dark_outside=True), _around(FIELD_MM, dark_outside=False), _name_patch()
    made = _painted(_film(video, _badge(_squares(26.0)), metres, partial(_texture, (words,))), paint)
    given: list[Array | None] = list(made.homographies)
    for kind, patches in (("with field", (*outline, *field, words)), ("outline, name", (*outline, words))):
        tracked, ms = _followed(made, PageRegistrar(TemplatePrinter(patches, 3.0)), given)
        _print(f"{name}, {kind}", metres, 0.0, made, Outcome(tracked, [None] * len(given), ms))


def _around(rect: Rect, reach: float = 3.0, *, dark_outside: bool) -> tuple[Patch, ...]:
    """Eight patches along the sides of a rectangle, half of each side in each, without the corners."""
    x0, y0, x1, y1 = rect
    patches = []
    for side in range(4):
        low, high = (x0, x1) if side % 2 == 0 else (y0, y1)
        for part in (0.27, 0.73):
            along, at = low + part * (high - low), (y0, x1, y1, x0)[side]
            center = (along, at) if side % 2 == 0 else (at, along)
            half = (0.21 * (high - low), reach) if side % 2 == 0 else (reach, 0.21 * (high - low))
            light_positive = (side in (0, 3)) == dark_outside
            patches.append(Patch(center, half, partial(_step_print, side % 2 == 0, light_positive)))
    return tuple(patches)


def _step_print(level: bool, light_positive: bool, across: Array, down: Array) -> Single:
    """A border: light on one side of the middle, dark on the other."""
    x, y = np.meshgrid(across, down)
    return (((y if level else x) > 0) == light_positive).astype(np.float32)


def _name_patch() -> Patch:
    """The name above the field, 8 mm high."""
    picture = np.full((120, 900), 255, np.uint8)
    cv2.putText(picture, "Ada Lovelace", (20, 90), cv2.FONT_HERSHEY_SIMPLEX, 3.2, 0, 9, cv2.LINE_AA)
    middle = ((FIELD_MM[0] + FIELD_MM[2]) / 2, 85.0)
    return Patch(middle, (30.0, 4.0), partial(_picture_print, picture.astype(np.float32) / 255, (60.0, 8.0)))


def _picture_print(picture: Single, size_mm: tuple[float, float], across: Array, down: Array) -> Single:
    x, y = np.meshgrid(
        (across / size_mm[0] + 0.5) * picture.shape[1] - 0.5, (down / size_mm[1] + 0.5) * picture.shape[0] - 0.5
    )
    return cv2.remap(picture, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderValue=1.0)


def _texture(patches: tuple[Patch, ...], scene: Scene) -> Single:
    """The simulator's page with these patches in place of its fiducial."""
    x0, y0, x1, y1 = BOARD_MM
    scale = TEXTURE_PX_PER_MM
    across = (np.arange(math.ceil((x1 - x0) * scale)) + 0.5) / scale + x0
    down = (np.arange(math.ceil((y1 - y0) * scale)) + 0.5) / scale + y0
    page = np.full((len(down), len(across)), scene.paper, np.float32)
    for patch in patches:
        (x, y), (width, height) = patch.center_mm, patch.half_mm
        columns, rows = np.flatnonzero(np.abs(across - x) < width), np.flatnonzero(np.abs(down - y) < height)
        shown = patch.print(across[columns] - x, down[rows] - y)
        page[np.ix_(rows, columns)] = scene.ink + (scene.paper - scene.ink) * shown
    return page


def _print(name: str, metres: float, covers: float, made: Filmed, outcome: Outcome) -> None:
    x0, y0, x1, y1 = FIELD_MM
    points = np.array([[[x0, y0]], [[x1, y0]], [[x1, y1]], [[x0, y1]]])
    apart, parallax = [], []
    for page, truth in zip(outcome.tracked, made.homographies, strict=True):
        if page is None:
            continue
        seen, there = (cv2.perspectiveTransform(points, one).reshape(-1, 2) for one in (page, truth))
        apart.append(float(np.sqrt(np.mean(np.sum((seen - there) ** 2, axis=1)))))
        parallax.append(_parallax(points, seen, made) - _parallax(points, there, made))
    alone = np.mean([page is not None for page in outcome.alone])
    figures = f"{name:<22}{100 * covers:>7.1f}%{metres:>5g}{alone:>7.2f}{len(apart) / len(made.frames):>9.3f}"
    if apart:
        figures += f"{np.median(apart):>7.3f}{max(apart):>7.3f}{np.sqrt(np.mean(np.square(parallax))):>10.4f}"
    print(f"{figures}{outcome.ms:>7.1f}", flush=True)


def _parallax(points_mm: Array, points_px: Array, made: Filmed) -> float:
    """Cx/|Cz| of the pose through the field's corners."""
    flat = np.column_stack([points_mm.reshape(-1, 2), np.zeros(4)])
    flat[:, :2] -= flat[:, :2].mean(axis=0)
    _, turn, shift = cv2.solvePnP(flat, points_px, made.camera.matrix, None, flags=cv2.SOLVEPNP_ITERATIVE)
    centre = -cv2.Rodrigues(turn)[0].T @ shift.ravel()
    return float(centre[0] / abs(centre[2]))


if __name__ == "__main__":
    main()
