"""The badges in view, each on its own track.

A frame is looked at in this order: each badge near where it must be; those that are not there, in the neighbourhood of
their last place; and the whole frame, where no badge is seen at all, small ones in one enlarged tile of it a frame.
While one is seen, others are looked for every two seconds: by a glance, which costs little beside following, or by a
search where one is lost.

A page that is found belongs to the badge that was lost last near there; where the film has shown one badge so far and
the page is alone, to that one, as one that leaves and comes back is still followed; else it begins a track.  So after a
cut between several badges the pieces are tracks of their own, rather than a track being made of two badges.
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
#: Others are looked for so often while a badge is seen.
GLANCE_S = 2.0
#: Of several badges, one is known again by its place for so long, and no farther off than this share of its size, at
#: no more than so many times its scale.
KNOWN_S, KNOWN_SIZES, KNOWN_SCALE = 1.0, 0.5, 1.25
#: A small badge that was lost is sought where it was for so long: a hand that went before it leaves it near there.
KEPT_S = 4.0
#: So many tiles of the first frame that is searched are enlarged; one of 3840 x 2160 has 16.
MOST_TILES = 16


class SceneTracker:
    """Follows up to `MOST_PAGES` badges at a time; `trackers` has one for each, the first from the start.

    It owns the finder, the registrar and the reader of profiles, and lends them to its trackers.
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
        #: Badges that were given up for others since this was last emptied.
        self.given_up: list[BadgeTracker] = []

    def push(self, frame: Frame) -> bool:
        """Take in one frame; whether a badge was found in it."""
        luma = _mirror(frame.luma) if self._mirrored else frame.luma
        for tracker in self.trackers:
            # No place of the frame before may be taken for one that is occupied in this one.
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
        """Look over the whole frame, and hand what is found to its trackers."""
        self._glance_s = frame.time_s + GLANCE_S
        clock = time.perf_counter()
        # One that was lost may be too small for a glance.
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
        """Pages in the whole frame, and where there are none, in those enlarged parts of it whose turn it is.

        Returns: the pages, and the frame as they lie in it, which may be its mirror image.
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
            # Only until a badge is found for the first time, as a film is mirrored or is not.
            found = self._registered(turned, mirrored) if new else []
            if found:
                self._mirrored = not self._mirrored
                return found, turned
        return [], luma

    def _parts(self, frame: Frame, luma: Luma) -> list[Box]:
        """Where small badges were a moment ago; and all of the first frame that is searched, of the others a tile each.

        A frame of more than `MOST_TILES` tiles is gone over in several frames.
        """
        tiles = tiles_of(luma.shape)
        count = MOST_TILES if self._tile == 0 else 1
        due = [tiles[(self._tile + k) % len(tiles)] for k in range(min(count, len(tiles)))]
        self._tile += count
        lost = [tracker.course.last for tracker in self._lost() if tracker.course.last is not None]
        near = [self._finder.around(seen.page, luma.shape) for seen in lost if frame.time_s - seen.time_s <= KEPT_S]
        return [*(box for box in near if box is not None), *due]

    def _registered(self, luma: Luma, pages: list[Array]) -> list[Array]:
        """Those pages that look like the print, without those that are followed already."""
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
        """The tracker that a page is for; None where as many badges are followed as can be."""
        only = self.trackers[0] if len(self.trackers) == 1 else None
        if only is not None and only.place is None and (alone or only.course.first is None):
            return only
        for tracker in self._lost():
            if self._was_there(tracker, page, frame):
                return tracker
        return self._new_tracker() if len(self.trackers) < MOST_PAGES or self._lost() else None

    def _make_room(self) -> None:
        """Where as many are followed as can be, give up the lost one that was shown least."""
        if len(self.trackers) == MOST_PAGES:
            least = min(self._lost(), key=lambda tracker: tracker.shown)
            self.trackers.remove(least)
            self.given_up.append(least)

    def _was_there(self, tracker: BadgeTracker, page: Array, frame: Frame) -> bool:
        """Whether a lost badge was near this place, about as large, a moment ago."""
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
    """The picture with left and right changed; the principal point, its centre, stays where it is."""
    return np.ascontiguousarray(luma[:, ::-1])
