"""The track of one badge: register its page, read its profiles.  One frame is in memory at a time.

A frame leaves its homography and the profiles of its uniform rows, 3 kB, until `take`.  Profiles of phase cells are
kept for at most `SAMPLE_FRAMES` frames, evenly spread over a track.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid.verifier.tracking.edge_spread import ACROSS, EVERY_FRAMES
from moireid.verifier.tracking.even_sample import EvenSample
from moireid.verifier.tracking.finding.markers import faint_turns
from moireid.verifier.tracking.finding.page_finder import PageFinder
from moireid.verifier.tracking.finding.page_groups import same_page
from moireid.verifier.tracking.patch_search import registered
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar, Registration, scale_px_per_mm
from moireid.verifier.tracking.search_work import Purse, Purses
from moireid.verifier.tracking.smeared_frames import ShakenFollower
from moireid.verifier.tracking.track import FrameSighting, Track, TrackEnds, board_px

Array = NDArray[np.float64]
Found = TypeVar("Found")
#: Pixels per millimetre of the picture in the report; a 500 mm board stays under 3 megapixels.
SNAPSHOT_PX_PER_MM = 3.0
#: A lost badge of less contrast is searched as faded print is: a usual search needs 10 counts between black and white,
#: and light may change by half.
FAINT_BELOW_COUNTS = 20.0


class BadgeTracker:
    """Follows one badge, frame after frame, and returns what it has seen as tracks.

    All badges share the tools of the scene tracker.  Each badge has its own memory: where it was seen, its template at
    the present scale, and the exposure estimated from its smears.  `SceneTracker` decides where a badge is found first,
    and where it is found again after it was lost.
    Convention: homographies as `MarkerFinder`; only the badge's layout is used, not its pitches or id.
    Source: `registration`, or `smeared_frames`, or `markers`, and `brightness_profiles`, in that order in each frame.
    """

    def __init__(
        self, badge: Badge, finder: PageFinder, registrar: PageRegistrar, reader: ProfileReader, purses: Purses
    ) -> None:
        """Parameters: finder, registrar, reader: made for the badge's layout; purses: of the whole scene."""
        self._badge, self._finder, self._registrar, self._reader = badge, finder, registrar, reader
        self._purses = purses
        self.ends, self._template, self._faint = TrackEnds(), KeptTemplate(registrar.printer), faint_turns()
        self._shaken = ShakenFollower(registrar, self._template, self.ends)
        self._corners_mm = marker_corners_mm(badge.markers)
        self._middle = self._corners_mm.mean(axis=(0, 1))
        self._uniform = np.array([strip.uniform for strip in self._reader.strips])
        #: Whether the sharp print did not match in the present frame.
        self.smeared = False
        self._mirrored = False
        self._image_px = (0, 0)
        #: Whether its markers were faded where it was last seen.
        self.faint = False
        #: Homography in the present frame; None if the badge is not seen.
        self.place: Array | None = None
        #: Size and duration of view: its scale squared, summed over all frames that show it, (px / mm)^2.
        self.shown = 0.0
        self.frames_read = 0
        self._measured: list[FrameSighting] = []
        self._cells = EvenSample()
        #: Sum of the page's edges.
        self._edge_sum = np.zeros((2, ACROSS))
        self._snapshot: NDArray[np.uint8] | None = None
        self._best, self._clock = 0.0, 0.0
        self._stages = dict.fromkeys(("find", "register", "shaken", "profiles", "snapshot"), 0.0)

    @property
    def tracked(self) -> int:
        """Frames of the present track in which the badge was found and registered."""
        return len(self._measured)

    def follow(self, frame: Frame, luma: Picture, taken: Sequence[Array] = ()) -> bool:
        """Begin the next frame: look for the badge near its expected place; returns whether it was found.

        Parameters: luma: of the frame, unmirrored if the film is mirrored; taken: pages of other badges.
        """
        self.frames_read += 1
        self._image_px = (luma.shape[1], luma.shape[0])
        self._clock = time.perf_counter()
        # The expected place is mostly near enough for registration, so no marker has to be decoded.
        expected = self.ends.expected(frame.index)
        registration: Registration | None = None
        if expected is not None:
            registration = _clear(self._registrar.register(luma, expected, self._template.at(expected)))
        self._lap("register")
        if registration is None and expected is not None:
            registration = self._paid(self._purses.near, partial(self._outlined, luma, expected))
            self._lap("find")
        elif registration is not None and self._hides_more(registration):
            # A start that was too far away hides markers as a hand does.
            seen = self._unsmeared(frame, luma)
            if seen is not None and seen.vague < registration.vague:
                registration = seen
        self.smeared = registration is None
        if registration is None:
            registration = self._unsmeared(frame, luma)
        return self._taken_in(frame, luma, registration, taken)

    def _hides_more(self, registration: Registration) -> bool:
        """Whether less of the page is visible than in the last frame that was measured."""
        before = self._measured[-1].registration.vague if self._measured else (1.0, 1.0)
        return max(registration.vague) > max(before)

    def _unsmeared(self, frame: Frame, luma: Picture) -> Registration | None:
        """The smeared page near its expected place."""
        # A page that was there in the last frame has a purse of its own: what is tried in vain after it has left
        # must not be missing where it is seen, smeared, in frame after frame.
        purse = self._purses.smeared if self.ends.followed else self._purses.gone
        registration = self._paid(purse, lambda: _clear(self._shaken.find(luma, frame.time_s)))
        self._lap("shaken")
        return registration

    def _outlined(self, luma: Picture, expected: Array) -> Registration | None:
        """The page by its outline at its expected place."""
        found = (_clear(self._registered(luma, page)) for page in self._finder.again(luma, expected))
        return next((one for one in found if one is not None), None)

    def _paid(self, purse: Purse, search: Callable[[], Found | None]) -> Found | None:
        """What a search finds, if it is paid for."""
        if not purse.open:
            return None
        before_ns = self._purses.work_ns
        found = search()
        purse.pay(self._purses.work_ns - before_ns, found=bool(found))
        return found

    def seek(self, frame: Frame, luma: Picture, taken: Sequence[Array] = ()) -> bool:
        """Look for its markers around its last place; returns whether it was found."""
        self._clock = time.perf_counter()
        last, purse = self.ends.last, self._purses.near
        if last is None or not self.ends.followed:
            return False

        def found() -> bool:
            # A search for faded print costs ten times as much, so it is left out where little is saved and the print
            # clear.
            near = self._finder.near(luma, last.page, faint=next(self._faint) and (self.faint or purse.ample))[0]
            pages = [page for page in near if not self._is_one_of(page, taken)]
            self._lap("find")
            # The largest first, but before all the page at this badge's own place.
            pages.sort(key=lambda page: not same_page(page, last.page, self._corners_mm))
            return any(self.begin(frame, luma, page, taken) for page in pages)

        return bool(self._paid(purse, found))

    def begin(
        self, frame: Frame, luma: Picture, page: Array, taken: Sequence[Array] = (), *, mirrored: bool = False
    ) -> bool:
        """Start to follow the badge at a page; returns whether it is there.  mirrored: whether the film is mirrored."""
        self._clock = time.perf_counter()
        self._image_px, self.frames_read = (luma.shape[1], luma.shape[0]), max(self.frames_read, 1)
        registration = self._registered(luma, page)
        self._lap("register")
        self._mirrored = self._mirrored or (mirrored and registration is not None)
        return self._taken_in(frame, luma, registration, taken)

    def spent(self, seconds: float) -> None:
        """Add the time of a search of the whole frame to this track."""
        self._stages["find"] += seconds

    def _registered(self, luma: Picture, page: Array) -> Registration | None:
        return registered(self._registrar, luma, page, self._template.at(page))

    def _is_one_of(self, page: Array, taken: Sequence[Array]) -> bool:
        return any(same_page(page, other, self._corners_mm) for other in taken)

    def _taken_in(self, frame: Frame, luma: Picture, registration: Registration | None, taken: Sequence[Array]) -> bool:
        """Read the frame if the page was registered, at a place of no other badge; returns whether it was."""
        if registration is None or self._is_one_of(registration.homography, taken):
            return False
        self.place, self.faint = registration.homography, registration.contrast < FAINT_BELOW_COUNTS
        seen = self._reader.read(luma, registration.homography)
        sighting = FrameSighting(frame.index, frame.time_s, registration, seen[self._uniform])
        self.ends.follow(sighting)
        self.shown += scale_px_per_mm(registration.homography, self._middle) ** 2
        self._measured.append(sighting)
        self._cells.offer(seen[~self._uniform])
        if self.tracked % EVERY_FRAMES == 0:
            self._edge_sum += self._reader.edges.read(luma, registration.homography)
        self._lap("profiles")
        # Only a clearly better frame is straightened again, or a steady film would do it all the time.
        if registration.correlation > self._best + 0.003:
            self._best = registration.correlation
            self._snapshot = straighten(luma, registration.homography, self._badge)
            self._lap("snapshot")
        return True

    def outline_px(self) -> Array | None:
        """Corners of the board in the first frame that shows it, as `corners_px`; None if no frame does."""
        return self.corners_px(self.ends.first.page) if self.ends.first is not None else None

    def corners_px(self, page: Array) -> Array:
        """Corners of the board under the homography `page`, as `track.board_px`."""
        return board_px(self._badge, page, self._image_px[0] if self._mirrored else None)

    def _lap(self, stage: str) -> None:
        now = time.perf_counter()
        self._stages[stage] += now - self._clock
        self._clock = now

    def look(self, last: int | None = None) -> Track:
        """The track since the last `take`, or its last `last` frames; the tracker goes on."""
        first = 0 if last is None else max(self.tracked - last, 0)
        places = self._cells.places
        kept, seen = places >= first, self._measured[first:]
        vague = [one.registration.vague for one in seen]
        cells = [item for item, keep in zip(self._cells.items, kept, strict=True) if keep]
        return Track(
            badge=self._badge,
            frames_read=self.frames_read,
            frame_numbers=np.array([one.frame for one in seen], np.int64),
            times_s=np.array([one.time_s for one in seen], float),
            homographies=np.array([one.page for one in seen], float).reshape(-1, 3, 3),
            correlations=np.array([one.registration.correlation for one in seen], float),
            profiles=_by_strip(self._uniform, [one.rows for one in seen], cells, self._reader.samples),
            cell_frames=places[kept] - first,
            strips=tuple(self._reader.strips),
            image_px=self._image_px,
            mirrored=self._mirrored,
            snapshot=self._snapshot,
            vague=np.array(vague) if any(max(pair) > 1 for pair in vague) else None,
            stages_s=dict(self._stages),
            spread_mm=self._reader.edges.spread_mm(self._edge_sum),
        )

    def take(self, keep: int = 0) -> Track:
        """The track since the last `take`; then begin a new one with the last `keep` tracked frames.

        Convention: `frames_read` and `stages_s` restart at 0, so that kept frames are not counted twice.
        """
        track = self.look()
        gone = max(self.tracked - keep, 0)
        del self._measured[:gone]
        self._cells.drop(gone)
        self._edge_sum[:] = 0.0
        self.frames_read, self._best = 0, 0.0
        self._stages = dict.fromkeys(self._stages, 0.0)
        return track


def _clear(found: Registration | None) -> Registration | None:
    """The registration of a followed page if the page is seen clearly; otherwise None."""
    return found if found is not None and found.clear else None


def _by_strip(
    uniform: NDArray[np.bool_], rows: list[NDArray[np.float32]], cells: list[NDArray[np.float32]], samples: int
) -> tuple[NDArray[np.float32], ...]:
    """Profiles by frame, of uniform strips and of the others, rearranged into one array per strip."""
    of_rows = np.array(rows, np.float32).reshape(len(rows), int(uniform.sum()), samples)
    of_cells = np.array(cells, np.float32).reshape(len(cells), int((~uniform).sum()), samples)
    places = np.where(uniform, np.cumsum(uniform), np.cumsum(~uniform)) - 1
    return tuple(
        (of_rows if is_uniform else of_cells)[:, place] for is_uniform, place in zip(uniform, places, strict=True)
    )


def straighten(luma: Picture, homography: Array, badge: Badge) -> NDArray[np.uint8]:
    """The board as seen in a frame, rectified to `SNAPSHOT_PX_PER_MM`."""
    x0, y0, x1, y1 = badge.outline_mm
    to_page = np.array([[1 / SNAPSHOT_PX_PER_MM, 0, x0], [0, 1 / SNAPSHOT_PX_PER_MM, y0], [0, 0, 1.0]])
    size = (round((x1 - x0) * SNAPSHOT_PX_PER_MM), round((y1 - y0) * SNAPSHOT_PX_PER_MM))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpPerspective(luma.whole, homography @ to_page, size, flags=flags), np.uint8)
