"""The pass over the film: find the page, register it, read its profiles.  One frame in memory at a time.

What is kept of a frame is its homography and the profiles of its uniform rows, 3 kB; profiles of phase cells are kept
of at most `SAMPLE_FRAMES` frames, evenly spread over the film.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.markers import MarkerFinder
from moireid.verifier.register import PageRegistrar, Registration
from moireid.verifier.sample import EvenSample
from moireid.verifier.strips import ProfileReader, Strip
from moireid.verifier.video import Film

Array = NDArray[np.float64]
#: Pixels to the millimetre of the picture in the report; a 500 mm board stays under 3 megapixels.
SNAPSHOT_PX_PER_MM = 3.0
#: A page that was followed must look more like the print than one whose markers were decoded (0.80): it may have been
#: left behind.  True pages show 0.93 and more at 3 m.
FOLLOWED_CORRELATION = 0.90
Progress = Callable[[int, int | None], None]


@dataclass(frozen=True)
class Track:
    """The badge over the film: T tracked frames of the `frames_read` that were read.

    homographies (T, 3, 3) page mm -> px; correlations (T,) of picture and print; profiles: one array a strip, counts:
    (T, N) of a uniform strip, (K, N) of a row of phase cells, whose K frames are `cell_frames` of the T; snapshot: the
    board of the best registered frame, straightened, for people to look at; mirrored: whether the film shows the badge
    mirror-wise (a self-view) and was turned back before it was measured.
    """

    frames_read: int
    frame_numbers: NDArray[np.int64]
    times_s: Array
    homographies: Array
    correlations: Array
    profiles: tuple[NDArray[np.float32], ...]
    cell_frames: NDArray[np.int64]
    strips: tuple[Strip, ...]
    image_px: tuple[int, int]
    mirrored: bool = False
    snapshot: NDArray[np.uint8] | None = None
    stages_s: dict[str, float] = field(default_factory=dict)

    @property
    def tracked(self) -> int:
        """Number of frames in which the badge was found and registered."""
        return len(self.times_s)


def no_track(frames_read: int, image_px: tuple[int, int]) -> Track:
    """The track of a film in which no badge was followed."""
    none, flat = np.zeros(0, np.int64), np.zeros(0)
    return Track(frames_read, none, flat, np.zeros((0, 3, 3)), flat, (), none, (), image_px)


def track_badge(film: Film, badge: Badge, progress: Progress | None = None) -> Track:
    """Follow the badge through the film.

    Parameters: progress: called with frames read and frames expected, if the file says.
    Convention: homographies as `MarkerFinder.find`; only the badge's layout is looked at, not its pitches or id.
    Returns: Track, which may be empty.
    Raises: MediaError where the film breaks off.
    Source: `markers`, `register` and `strips`, in that order in each frame.
    """
    finder, registrar, reader = MarkerFinder(badge.markers), PageRegistrar(badge.markers), ProfileReader(badge)
    numbers: list[int] = []
    times: list[float] = []
    homographies, correlations = [], []
    uniform = np.array([strip.uniform for strip in reader.strips])
    rows, cells = [], EvenSample()
    stages = dict.fromkeys(("decode", "find", "register", "profiles", "snapshot"), 0.0)
    clock = time.perf_counter()

    def lap(stage: str) -> None:
        nonlocal clock
        now = time.perf_counter()
        stages[stage] += now - clock
        clock = now

    read, snapshot, best, mirrored = 0, None, 0.0, False
    for frame in film.frames():
        read += 1
        lap("decode")
        luma = _mirror(frame.luma) if mirrored else frame.luma
        # Where the badge must be now is mostly near enough for registration, which needs no marker to be decoded.
        registration = _followed(registrar, luma, finder.expected(frame.index))
        lap("register")
        if registration is None:
            start = finder.find(luma)
            if start is None and not times:
                # Until the badge is found for the first time, each frame is also looked at in the mirror.
                turned = _mirror(frame.luma)
                start = finder.find(turned)
                luma, mirrored = (turned, True) if start is not None else (luma, False)
            lap("find")
            registration = registrar.register(luma, start) if start is not None else None
            mirrored = mirrored and (bool(times) or registration is not None)
            lap("register")
        finder.follow(registration.homography if registration else None, frame.index)
        if registration:
            numbers.append(frame.index)
            times.append(frame.time_s)
            homographies.append(registration.homography)
            correlations.append(registration.correlation)
            seen = reader.read(luma, registration.homography)
            rows.append(seen[uniform])
            cells.offer(seen[~uniform])
            lap("profiles")
            # A frame must be clearly better to be straightened anew, or a steady film would do it again and again.
            if registration.correlation > best + 0.003:
                best, snapshot = registration.correlation, straighten(luma, registration.homography, badge)
                lap("snapshot")
        if progress:
            progress(read, film.frames_expected)
    return Track(
        frames_read=read,
        frame_numbers=np.array(numbers, np.int64),
        times_s=np.array(times, float),
        homographies=np.array(homographies, float).reshape(-1, 3, 3),
        correlations=np.array(correlations, float),
        profiles=_by_strip(uniform, rows, cells.items, reader.samples),
        cell_frames=cells.places,
        strips=tuple(reader.strips),
        image_px=(film.width, film.height),
        mirrored=mirrored,
        snapshot=snapshot,
        stages_s=stages,
    )


def _followed(registrar: PageRegistrar, luma: NDArray[np.uint8], expected: Array | None) -> Registration | None:
    """The page near where it is expected, if it is seen there clearly."""
    found = registrar.register(luma, expected) if expected is not None else None
    return found if found is not None and found.correlation >= FOLLOWED_CORRELATION else None


def _by_strip(
    uniform: NDArray[np.bool_], rows: list[NDArray[np.float32]], cells: list[NDArray[np.float32]], samples: int
) -> tuple[NDArray[np.float32], ...]:
    """Profiles frame by frame, of uniform strips and of the others, turned into one array a strip."""
    of_rows = np.array(rows, np.float32).reshape(len(rows), int(uniform.sum()), samples)
    of_cells = np.array(cells, np.float32).reshape(len(cells), int((~uniform).sum()), samples)
    places = np.where(uniform, np.cumsum(uniform), np.cumsum(~uniform)) - 1
    return tuple(
        (of_rows if is_uniform else of_cells)[:, place] for is_uniform, place in zip(uniform, places, strict=True)
    )


def _mirror(luma: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The picture with left and right changed; the principal point, its centre, stays where it is."""
    return np.ascontiguousarray(luma[:, ::-1])


def straighten(luma: NDArray[np.uint8], homography: Array, badge: Badge) -> NDArray[np.uint8]:
    """The board as seen in a frame, turned upright and flat, `SNAPSHOT_PX_PER_MM`."""
    x0, y0, x1, y1 = badge.outline_mm
    to_page = np.array([[1 / SNAPSHOT_PX_PER_MM, 0, x0], [0, 1 / SNAPSHOT_PX_PER_MM, y0], [0, 0, 1.0]])
    size = (round((x1 - x0) * SNAPSHOT_PX_PER_MM), round((y1 - y0) * SNAPSHOT_PX_PER_MM))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpPerspective(luma, homography @ to_page, size, flags=flags), np.uint8)
