"""What a film shows of one badge, frame by frame; and where it was in the first and in the last two of its frames."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.tracking.brightness_profiles import Strip
from moireid.verifier.tracking.registration import Registration

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Track:
    """The badge over the film: T tracked frames out of `frames_read`.

    badge: its layout is searched in the frames, and the measurements are compared with it; homographies (T, 3, 3) page
    mm -> px; correlations (T,) of picture and print; profiles: one array per strip, counts: (T, N) for a uniform strip,
    (K, N) for a row of phase cells, in the K frames `cell_frames`; snapshot: the rectified board of the best registered
    frame, for people to look at; mirrored: whether the film is mirrored (a self-view), and was unmirrored before the
    measurement; vague (T, 2): as `Registration.vague`, None if it is 1 everywhere;
    spread_mm (2,): of the page's edges, as `EdgeReader.spread_mm`.
    """

    badge: Badge
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
    vague: Array | None = None
    stages_s: dict[str, float] = field(default_factory=dict)
    spread_mm: Array = field(default_factory=lambda: np.zeros(2))

    @property
    def tracked(self) -> int:
        """Number of frames in which the badge was found and registered."""
        return len(self.times_s)

    def only(self, kept: NDArray[np.bool_]) -> Track:
        """The track of some of its frames, mask (T,)."""
        cells = kept[self.cell_frames]
        return replace(
            self,
            frame_numbers=self.frame_numbers[kept],
            times_s=self.times_s[kept],
            homographies=self.homographies[kept],
            correlations=self.correlations[kept],
            profiles=tuple(
                seen[kept if strip.uniform else cells] for seen, strip in zip(self.profiles, self.strips, strict=True)
            ),
            cell_frames=(np.cumsum(kept) - 1)[self.cell_frames[cells]],
            vague=None if self.vague is None else self.vague[kept],
        )


def expected_page(before: Array, last: Array, share: float) -> Array:
    """The page after its motion from `before` to `last`, all homographies with h33 = 1, is repeated by a share of it.

    Source: to first order in the motion; the last page, where the one before has no inverse.
    """
    if not np.linalg.det(before):
        return last
    step = np.linalg.inv(before) @ last
    found = last @ (np.eye(3) + share * (step / step[2, 2] - np.eye(3)))
    found /= found[2, 2]
    return found if np.all(np.isfinite(found)) else last


def board_px(badge: Badge, page: Array, mirrored_px: int | None) -> Array:
    """Corners of the board under the homography `page`, (4, 2) px of the original film.

    Parameters: mirrored_px: width of a film that is mirrored, None for others.
    Convention: top left, top right, bottom right, bottom left of the upright board.
    """
    x0, y0, x1, y1 = badge.outline_mm
    board = np.array([[[x0, y0]], [[x1, y0]], [[x1, y1]], [[x0, y1]]])
    corners = np.asarray(cv2.perspectiveTransform(board, page).reshape(4, 2), float)
    if mirrored_px is not None:
        corners[:, 0] = mirrored_px - 1 - corners[:, 0]
    return corners


def no_track(badge: Badge, frames_read: int, image_px: tuple[int, int]) -> Track:
    """The empty track of a film without a badge."""
    none, flat = np.zeros(0, np.int64), np.zeros(0)
    return Track(badge, frames_read, none, flat, np.zeros((0, 3, 3)), flat, (), none, (), image_px)


@dataclass(frozen=True)
class FrameSighting:
    """A frame that shows the badge: its number, its time, the page, and the profiles of the uniform rows, (S, N)."""

    frame: int
    time_s: float
    registration: Registration
    rows: NDArray[np.float32]

    @property
    def page(self) -> Array:
        """The page's homography."""
        return self.registration.homography


@dataclass
class TrackEnds:
    """The first frame that shows the badge, and the last two; None if there is none yet.

    Convention: homographies page mm -> px, h33 = 1.
    """

    first: FrameSighting | None = None
    before: FrameSighting | None = None
    last: FrameSighting | None = None
    #: Whether the last frame shows the badge, and whether all frames between the last two did.
    followed: bool = False
    unbroken: bool = False

    def follow(self, seen: FrameSighting) -> None:
        """Record a frame that shows the badge."""
        self.before, self.last = self.last, seen
        self.followed, self.unbroken = True, self.followed
        self.first = self.first or seen

    def lose(self) -> None:
        """Record that this frame does not show the badge: its place is no longer known."""
        self.followed = False

    def expected(self, frame: int) -> Array | None:
        """The expected homography in a frame; None if the last frame did not show the badge.

        Source: the last motion, applied once more; over another number of frames, in proportion to first order.  Where
            it was not seen, or for less than half as long, the last place.
        """
        if not self.followed or self.last is None:
            return None
        last, before = self.last, self.before
        if before is None or not self.unbroken:
            return last.page
        share = (frame - last.frame) / (last.frame - before.frame)
        return expected_page(before.page, last.page, share) if 0 < share <= 2 else last.page
