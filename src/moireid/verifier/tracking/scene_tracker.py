"""The badges in view, each on its own track.

A frame is searched in this order: each badge near its expected place; the missing ones around their last place; and if
no badge is seen, the whole frame, with one enlarged tile per frame for small badges.  While a badge is seen, others are
searched every two seconds: by a glance, which is cheap, or by a full search if a badge is lost.

Looking may cost a share of decoding (`search_work`).  What is saved is spent as soon as a badge is lost, frame after
frame.  Then the whole frame is searched closely now and then, and between that by a quick look, which a badge that
comes back seldom escapes; where it sees what may be a badge, that place is searched closely at once.

A page that is found belongs to the badge that was last lost near there.  If the film has shown one badge so far and the
page is alone, it belongs to that badge, which may have left and come back.  Otherwise it begins a new track.  So after
a cut between several badges each piece is a track of its own, and no track joins two badges.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, CodedFrame, Fiducial
from moireid.verifier.picture import Frame, Picture
from moireid.verifier.tracking.badge_tracker import BadgeTracker
from moireid.verifier.tracking.borders import borders_of
from moireid.verifier.tracking.brightness_profiles import ProfileReader
from moireid.verifier.tracking.finding.coded_frames import FrameFinder
from moireid.verifier.tracking.finding.markers import MarkerFinder, faint_turns, tiles_of
from moireid.verifier.tracking.finding.page_finder import EitherWay, PageFinder
from moireid.verifier.tracking.finding.page_groups import MOST_PAGES, same_page
from moireid.verifier.tracking.patch_search import registered
from moireid.verifier.tracking.patches import marker_corners_mm
from moireid.verifier.tracking.registration import KeptTemplate, PageRegistrar, Registration, scale_px_per_mm
from moireid.verifier.tracking.search_work import Purse, Purses
from moireid.verifier.tracking.track import FrameSighting

Array = NDArray[np.float64]
#: Pages of a picture, and of its mirror image.
Look = Callable[[Picture], EitherWay]
#: Time between two searches for further badges while one is seen.
GLANCE_S = 2.0
#: A glance waits for a frame that is not smeared, which has time left for it, but at most for so long.
GLANCE_WAIT_S = 0.5
#: Of several badges, a lost one is recognised by its place within this time: it moves by at most this share of its
#: size, and its scale by at most this ratio.
KNOWN_S, MOVED_SIZES, MOVED_SCALE = 1.0, 0.5, 1.25
#: A lost badge is searched around its last place for this long: after a hand has passed, it is still there.
KEPT_S = 4.0
#: It is searched there alone for so long: what hides a badge for some frames is mostly its own smear, and a search of
#: the whole frame costs as much as decoding three.  Small markers are lost for other reasons.
SOON_S = 0.1
#: Most tiles that are enlarged in the first frame searched; a frame of 3840 x 2160 has 16.
MOST_TILES = 16


def finder_of(fiducial: Fiducial) -> PageFinder:
    """The search for pages with a fiducial."""
    return FrameFinder(fiducial) if isinstance(fiducial, CodedFrame) else MarkerFinder(fiducial)


class SceneTracker:
    """Follows up to `MOST_PAGES` badges at a time; `trackers` has one for each, the first from the start.

    It owns the finder, the registrar and the reader of profiles; its trackers share them.
    """

    def __init__(self, badge: Badge) -> None:
        """Raises: SpecError where a row of the badge is too small to be read."""
        self._badge = badge
        self._finder, self._registrar = finder_of(badge.markers), PageRegistrar(badge.markers, borders_of(badge))
        self._reader = ProfileReader(badge)
        self._template, self._faint = KeptTemplate(self._registrar.printer), faint_turns()
        self._corners_mm = marker_corners_mm(badge.markers)
        self._mirrored, self._glance_s, self._tile, self._before_s = False, 0.0, 0, 0.0
        tools = (self._finder, self._registrar, self._registrar.printer)
        self._purses = Purses(tools, self._finder.quick_share, self._finder.close_share)
        #: Pages that the last look saw, registered or not.
        self._may_be: list[Array] = []
        self.trackers = [self._new_tracker()]
        #: Frames in which a lost badge, or any, was due to be looked for, and the whole picture was not searched; and
        #: the longest time in a row in which none was followed either, s.
        self.unsearched, self.unsearched_s = 0, 0.0
        #: When a badge was last followed, or the whole picture searched.
        self._looked_s: float | None = None
        #: Lost badges that made room for others since this list was last emptied.
        self.given_up: list[BadgeTracker] = []

    def push(self, frame: Frame) -> bool:
        """Take one frame; returns whether a badge was found in it."""
        luma = frame.picture.mirrored() if self._mirrored else frame.picture
        self._purses.earn(luma.size, frame.time_s - self._before_s)
        self._before_s = frame.time_s
        before = self.unsearched
        for tracker in self.trackers:
            # Places of the last frame must not count as occupied in this one.
            tracker.place = None
        for tracker in self.trackers:
            tracker.follow(frame, luma, self._places())
        for tracker in self._lost():
            tracker.seek(frame, luma, self._places())
        if not self._places() or self._glance_is_due(frame):
            self._search(frame, luma)
        for tracker in self._lost():
            tracker.ends.lose()
        self._note_when_looked(frame, unsearched=self.unsearched > before and not self._places())
        return bool(self._places())

    def _glance_is_due(self, frame: Frame) -> bool:
        """Whether to search for further badges; where followed ones are smeared others are too, so it may wait."""
        smeared = any(tracker.smeared and tracker.place is not None for tracker in self.trackers)
        return frame.time_s >= self._glance_s + (GLANCE_WAIT_S if smeared else 0.0)

    def _note_when_looked(self, frame: Frame, *, unsearched: bool) -> None:
        """Keep the longest time for which nothing was followed or searched; unsearched: in this frame."""
        if not unsearched or self._looked_s is None:
            self._looked_s = frame.time_s
        self.unsearched_s = max(self.unsearched_s, frame.time_s - self._looked_s)

    def _new_tracker(self) -> BadgeTracker:
        return BadgeTracker(self._badge, self._finder, self._registrar, self._reader, self._purses)

    def _places(self) -> list[Array]:
        return [tracker.place for tracker in self.trackers if tracker.place is not None]

    def _lost(self) -> list[BadgeTracker]:
        return [tracker for tracker in self.trackers if tracker.place is None]

    def _search(self, frame: Frame, luma: Picture) -> None:
        """Search the whole frame, and give each page to its tracker."""
        self._glance_s = frame.time_s + GLANCE_S
        clock = time.perf_counter()
        # A lost badge may be too small for a glance.
        if self._lost():
            found, luma = self._sought(frame, luma)
        else:
            found = self._registered(luma, self._finder.quick(luma)[0])
        self.trackers[0].spent(time.perf_counter() - clock)
        for page in found:
            tracker = self._tracker_for(page, frame, alone=len(found) == 1)
            begun = tracker is not None and tracker.begin(frame, luma, page, self._places(), mirrored=self._mirrored)
            if begun and tracker is not None and tracker not in self.trackers:
                self._make_room()
                self.trackers.append(tracker)

    def _sought(self, frame: Frame, luma: Picture) -> tuple[list[Array], Picture]:
        """Pages in the frame, as far as its looks are paid for.

        Returns: the pages, and the frame in which they lie, which may be mirrored.
        """
        searched = False
        for purse, look in self._looks(frame, luma):
            before_ns, pages, near = self._purses.work_ns, look(luma), purse is self._purses.near
            found, there = self._either_way_registered(luma, pages)
            self._may_be = pages[0]
            purse.pay(self._purses.work_ns - before_ns, found=near and bool(found))
            if found:
                return found, there
            searched = searched or not near
        self.unsearched += not searched
        return [], luma

    def _looks(self, frame: Frame, luma: Picture) -> Iterator[tuple[Purse, Look]]:
        """Looks at a frame, and what pays them.

        Closely where that is paid for; otherwise around lost badges, quickly at the whole frame, and around what may be
        a badge.  A badge that was just lost is looked for around its place alone.
        """
        purses, finder = self._purses, self._finder
        lost = [(tracker, last) for tracker in self._lost() if (last := self._recently(tracker, frame)) is not None]
        soon = len(lost) == len(self._lost()) and all(
            frame.time_s - last.time_s < SOON_S and finder.around(last.page, luma.shape) is None for _, last in lost
        )
        if purses.wide.open and not soon:
            clear = bool(lost) and not (purses.wide.ample or any(tracker.faint for tracker, _ in lost))
            for look in self._close_looks(luma.shape, [last for _, last in lost], faint=not clear):
                yield purses.wide, look
            return
        for tracker, last in lost:
            # A badge that the last frame showed was sought there already, but not as closely as small markers need it.
            small = finder.around(last.page, luma.shape) is not None
            if small and purses.near.open:
                yield purses.near, partial(finder.closely, page=last.page)
            if not (small or tracker.ends.followed) and purses.near.open:
                yield purses.near, partial(finder.near, page=last.page, faint=tracker.faint)
        if purses.glance.open and not soon:
            yield purses.glance, finder.quick
            for page in list(self._may_be):
                if purses.near.open:
                    yield purses.near, partial(finder.closely, page=page)

    def _recently(self, tracker: BadgeTracker, frame: Frame, most_s: float = KEPT_S) -> FrameSighting | None:
        """Where a lost badge was last seen, unless that is too long ago."""
        last = tracker.ends.last
        return last if last is not None and frame.time_s - last.time_s <= most_s else None

    def _close_looks(self, shape: tuple[int, ...], lost: list[FrameSighting], *, faint: bool) -> Iterator[Look]:
        """The whole frame; the last places of small badges; all tiles of the first frame searched, and one tile of each
        later frame.

        If there are more than `MOST_TILES` tiles, the search is spread over several frames.
        """
        finder, tiles = self._finder, tiles_of(shape)
        count = MOST_TILES if self._tile == 0 else 1
        due = [tiles[(self._tile + k) % len(tiles)] for k in range(min(count, len(tiles)))]
        self._tile += count
        yield partial(finder.either_way, faint=next(self._faint) and faint)
        near = [finder.around(seen.page, shape) for seen in lost]
        for box in (*(box for box in near if box is not None), *due):
            yield partial(finder.enlarged, box=box)

    def _either_way_registered(self, luma: Picture, pages: EitherWay) -> tuple[list[Array], Picture]:
        """The pages that are the badge, and the frame in which they lie: mirrored, if the film turns out to be so."""
        found = self._registered(luma, pages[0])
        # Only until the first badge is found: a film is mirrored as a whole or not at all.
        if found or not pages[1] or any(tracker.ends.first is not None for tracker in self.trackers):
            return found, luma
        turned = luma.mirrored()
        found = self._registered(turned, pages[1])
        if found:
            self._mirrored = not self._mirrored
        return found, turned if found else luma

    def _registered(self, luma: Picture, pages: list[Array]) -> list[Array]:
        """The pages that look like the print and are not followed already."""
        found: list[Array] = []
        for page in pages:
            registration: Registration | None = None
            if not self._known(page, found):
                registration = registered(self._registrar, luma, page, self._template.at(page))
            if registration is not None and not self._known(registration.homography, found):
                found.append(registration.homography)
        return found

    def _known(self, page: Array, found: list[Array]) -> bool:
        return any(same_page(page, other, self._corners_mm) for other in (*self._places(), *found))

    def _tracker_for(self, page: Array, frame: Frame, *, alone: bool) -> BadgeTracker | None:
        """The tracker for a page; None if the largest number of badges is already followed."""
        only = self.trackers[0] if len(self.trackers) == 1 else None
        if only is not None and only.place is None and (alone or only.ends.first is None):
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
        last = self._recently(tracker, frame, KNOWN_S)
        if last is None:
            return False
        middle, corners = self._corners_mm.mean(axis=(0, 1)), self._corners_mm.reshape(-1, 2)
        before_px, now_px = (_mapped(one, middle) for one in (last.page, page))
        before, now = (scale_px_per_mm(one, middle) for one in (last.page, page))
        size_px = before * float(np.ptp(corners, axis=0).max())
        moved = float(np.linalg.norm(now_px - before_px))
        return max(before, now) < MOVED_SCALE * min(before, now) and moved < MOVED_SIZES * size_px


def _mapped(page: Array, place_mm: Array) -> Array:
    """A place of the page in the picture, px."""
    x, y, w = page @ (*place_mm, 1.0)
    return np.array([x / w, y / w])
