"""What a film shows of one badge, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.tracking.profiles import Strip

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Track:
    """The badge over the film: T tracked frames of the `frames_read` that were read.

    badge: whose layout was looked for, and which all that is measured of the track is held against; homographies
    (T, 3, 3) page mm -> px; correlations (T,) of picture and print; profiles: one array a strip, counts: (T, N) of a
    uniform strip, (K, N) of a row of phase cells, whose K frames are `cell_frames` of the T; snapshot: the board of the
    best registered frame, straightened, for people to look at; mirrored: whether the film shows the badge mirror-wise
    (a self-view) and was turned back before it was measured; vague (T, 2): as `Registration.vague`, None where every
    frame is 1.
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

    @property
    def tracked(self) -> int:
        """Number of frames in which the badge was found and registered."""
        return len(self.times_s)


def no_track(badge: Badge, frames_read: int, image_px: tuple[int, int]) -> Track:
    """The track of a film in which no badge was followed."""
    none, flat = np.zeros(0, np.int64), np.zeros(0)
    return Track(badge, frames_read, none, flat, np.zeros((0, 3, 3)), flat, (), none, (), image_px)
