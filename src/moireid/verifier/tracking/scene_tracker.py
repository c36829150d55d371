"""The badges in view, each on its own track.

A frame is searched in this order: each badge near its expected place; the missing ones around their last place; and if
no badge is seen, the whole frame, with one enlarged tile per frame for small badges.  While a badge is seen, others are
searched every two seconds: by a glance, which is cheap, or by a full search if a badge is lost.

A page that is found belongs to the badge that was last lost near there.  If the film has shown one badge so far and the
page is alone, it belongs to that badge, which may have left and come back.  Otherwise it begins a new track.  So after
a cut between several badges each piece is a track of its own, and no track joins two badges.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.borders import borders_of
from moireid.verifier.tracking.markers import Box, MarkerFinder, faint_turns, marker_corners_mm, tiles_of
from moireid.verifier.tracking.page_groups import MOST_PAGES, same_page
from moireid.verifier.tracking.profiles import ProfileReader
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar, Registration, scale_px_per_mm
from moireid.verifier.video import Frame

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
#: Time between two searches for further badges while one is seen.
GLANCE_S = 2.0
#: Of several badges, a lost one is recognised by its place: within this time, this distance as a share of its size, and
#: this ratio of scales.
KNOWN_S, KNOWN_SIZES, KNOWN_SCALE = 1.0, 0.5, 1.25
#: A lost small badge is searched around its last place for this long: after a hand has passed, it is still there.
KEPT_S = 4.0
#: Most tiles that are enlarged in the first frame searched; a frame of 3840 x 2160 has 16.
MOST_TILES = 16


class SceneTracker:
    """Follows up to `MOST_PAGES` badges at a time; `trackers` has one for each, the first from the start.

    It owns the finder, the registrar and the reader of profiles; its trackers share them.
    """

    def __init__(self, badge: Badge) -> None:
        """Raises: SpecError where a row of the badge is too small to be read."""
        self._badge = badge
        self._finder, self._registrar = MarkerFinder(badge.markers), PageRegistrar(badge.markers, borders_of(badge))
        self._reader = ProfileReader(badge)
        self._template, self._faint = KeptTemplate(self._registrar.printer), faint_turns()
        self._corners_mm = marker_corners_mm(badge.markers)
        self._middle = self._corners_mm.mean(axis=(0, 1))
        self._size_mm = float(np.ptp(self._corners_mm.reshape(-1, 2), axis=0).max())
        self._mirrored, self._glance_s, self._tile = False, 0.0, 0
        self.trackers = [self._new_tracker()]
        #: Lost badges that made room for others since this list was last emptied.
        self.given_up: list[BadgeTracker] = []

    def push(self, frame: Frame) -> bool:
        """Take one frame; returns whether a badge was found in it."""
        luma = _mirror(frame.luma) if self._mirrored else frame.luma
        for tracker in self.trackers:
            # Places of the last frame must not count as occupied in this one.
            tracker.place = None
        for tracker in self.trackers:
            tracker.follow(frame, luma, self._places())
        for tracker in self._lost():
            tracker.seek(frame, luma, self._places())
        if not self._places() or frame.time_s >= self._glance_s:
            self._search(frame, luma)
        for tracker in self._lost():
            tracker.course.lose()
        return bool(self._places())

    def _new_tracker(self) -> BadgeTracker:
        return BadgeTracker(self._badge, self._finder, self._registrar, self._reader)

    def _places(self) -> list[Array]:
        return [tracker.place for tracker in self.trackers if tracker.place is not None]

    def _lost(self) -> list[BadgeTracker]:
        return [tracker for tracker in self.trackers if tracker.place is None]

    def _search(self, frame: Frame, luma: Luma) -> None:
        """Search the whole frame, and give each page to its tracker."""
        self._glance_s = frame.time_s + GLANCE_S
        clock = time.perf_counter()
        # A lost badge may be too small for a glance.
        if self._lost():
            found, luma = self._sought(frame, luma)
        else:
            found = self._registered(luma, self._finder.glance(luma))
        self.trackers[0].spent(time.perf_counter() - clock)
        for page in found:
            tracker = self._tracker_for(page, frame, alone=len(found) == 1)
            begun = tracker is not None and tracker.begin(frame, luma, page, self._places(), mirrored=self._mirrored)
            if begun and tracker is not None and tracker not in self.trackers:
                self._make_room()
                self.trackers.append(tracker)

    def _sought(self, frame: Frame, luma: Luma) -> tuple[list[Array], Luma]:
        """Pages in the whole frame, or if there are none, in the enlarged parts whose turn it is.

        Returns: the pages, and the frame in which they lie, which may be mirrored.
        """
        new, turned = all(tracker.course.first is None for tracker in self.trackers), _mirror(luma)
        for box in (None, *self._parts(frame, luma)):
            pages, mirrored = (
                self._finder.either_way(luma, faint=next(self._faint))
                if box is None
                else self._finder.enlarged(luma, box)
            )
            found = self._registered(luma, pages)
            if found:
                return found, luma
            # Only until the first badge is found: a film is mirrored as a whole or not at all.
            found = self._registered(turned, mirrored) if new else []
            if found:
                self._mirrored = not self._mirrored
                return found, turned
        return [], luma

    def _parts(self, frame: Frame, luma: Luma) -> list[Box]:
        """The last places of small badges; and all tiles of the first frame searched, one tile of each later frame.

        If there are more than `MOST_TILES` tiles, the search is spread over several frames.
        """
        tiles = tiles_of(luma.shape)
        count = MOST_TILES if self._tile == 0 else 1
        due = [tiles[(self._tile + k) % len(tiles)] for k in range(min(count, len(tiles)))]
        self._tile += count
        lost = [tracker.course.last for tracker in self._lost() if tracker.course.last is not None]
        near = [self._finder.around(seen.page, luma.shape) for seen in lost if frame.time_s - seen.time_s <= KEPT_S]
        return [*(box for box in near if box is not None), *due]

    def _registered(self, luma: Luma, pages: list[Array]) -> list[Array]:
        """The pages that look like the print and are not followed already."""
        found: list[Array] = []
        for page in pages:
            registration: Registration | None = None
            if not self._known(page, found):
                registration = self._registrar.register(luma, page, self._template.at(page))
            if registration is not None and not self._known(registration.homography, found):
                found.append(registration.homography)
        return found

    def _known(self, page: Array, found: list[Array]) -> bool:
        return any(same_page(page, other, self._corners_mm) for other in (*self._places(), *found))

    def _tracker_for(self, page: Array, frame: Frame, *, alone: bool) -> BadgeTracker | None:
        """The tracker for a page; None if the largest number of badges is already followed."""
        only = self.trackers[0] if len(self.trackers) == 1 else None
        if only is not None and only.place is None and (alone or only.course.first is None):
            return only
        for tracker in self._lost():
            if self._was_there(tracker, page, frame):
                return tracker
        return self._new_tracker() if len(self.trackers) < MOST_PAGES or self._lost() else None

    def _make_room(self) -> None:
        """If the largest number of badges is followed, give up the lost one that was shown least."""
        if len(self.trackers) == MOST_PAGES:
            least = min(self._lost(), key=lambda tracker: tracker.shown)
            self.trackers.remove(least)
            self.given_up.append(least)

    def _was_there(self, tracker: BadgeTracker, page: Array, frame: Frame) -> bool:
        """Whether a lost badge was recently near this place, at about this size."""
        last = tracker.course.last
        if last is None or frame.time_s - last.time_s > KNOWN_S:
            return False
        before, now = scale_px_per_mm(last.page, self._middle), scale_px_per_mm(page, self._middle)
        apart = np.linalg.norm(self._middle_px(last.page) - self._middle_px(page))
        grown = max(before / now, now / before)
        return bool(grown < KNOWN_SCALE and apart < KNOWN_SIZES * self._size_mm * before)

    def _middle_px(self, page: Array) -> Array:
        mapped = page @ (*self._middle, 1.0)
        return np.asarray(mapped[:2] / mapped[2])


def _mirror(luma: Luma) -> Luma:
    """The picture with left and right swapped; the principal point, its centre, stays."""
    return np.ascontiguousarray(luma[:, ::-1])
