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
    """The badge over the film: T tracked frames out of `frames_read`.

    badge: its layout is searched in the frames, and the measurements are compared with it; homographies (T, 3, 3) page
    mm -> px; correlations (T,) of picture and print; profiles: one array per strip, counts: (T, N) for a uniform strip,
    (K, N) for a row of phase cells, in the K frames `cell_frames`; snapshot: the rectified board of the best registered
    frame, for people to look at; mirrored: whether the film is mirrored (a self-view), and was unmirrored before the
    measurement; vague (T, 2): as `Registration.vague`, None if it is 1 everywhere;
    passed: frames that show the badge as their neighbours do, and were not measured.
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
    passed: int = 0

    @property
    def tracked(self) -> int:
        """Number of frames in which the badge was found and registered."""
        return len(self.times_s)


def no_track(badge: Badge, frames_read: int, image_px: tuple[int, int]) -> Track:
    """The empty track of a film without a badge."""
    none, flat = np.zeros(0, np.int64), np.zeros(0)
    return Track(badge, frames_read, none, flat, np.zeros((0, 3, 3)), flat, (), none, (), image_px)
