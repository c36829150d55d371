"""Which frames of a badge that hardly changes need not be measured.

A film of 60 frames a second shows each moment of a hand twice.  Once some seconds are measured in full, every second
frame is enough, as long as it looks like the last one that was measured: 30 a second, at which a hand's tremor is still
seen.  A film of 240 a second comes to that rate step by step.

A badge is calm if its page goes on as it did and its fringes hardly move from one measured frame to the next; of one
that trembles all frames are needed.  A frame that is passed by is looked at all the same, at some places within the
gratings.  If it differs, be it by a fast hand or by a picture that somebody put between the others, it is measured, and
so is each frame of the next half second.
"""

from __future__ import annotations

import itertools

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.sampling import Places, Sampler

Array = NDArray[np.float64]
Grey = NDArray[np.float32]
#: Every second frame is left out once this many are measured, 4 s at 60 a second, and this many in a row are calm.  So
#: twice as many are left as a verdict needs at least.
FULL_FRAMES, CALM_FRAMES = 240, 60
#: Frames are not left out if the others would be further apart than this; 30 a second are 0.033 s.
LONGEST_STEP_S = 0.036
#: A page that goes on as it did is found within this of where it is expected, px.  Set by hand: its place between two
#: frames is then known to an eighth of that, and a registration errs by 0.02 to 0.05 px.  A camera in one hand moves
#: pages by 1 to 5 px more or less than expected, at 60 frames a second.
CALM_PX = 0.5
#: Each frame is measured for so long after one that differs, s.
RESTLESS_S = 0.5
#: Places of a grating, along and across the fringes.
ALONG, ACROSS = 32, 8
#: Least correlation of a grating in a frame with that in the last measured one.  Derived: fringes that have moved by
#: 0.3 rad, a tenth of the half turn by which their course could be mistaken, still have cos 0.3 = 0.955.
ALIKE = 0.95


class CalmWatch:
    """Compares a badge's gratings in a frame with those in the last measured one."""

    def __init__(self, badge: Badge) -> None:
        spots = []
        for grating in badge.gratings:
            x0, y0, x1, y1 = grating.rect_mm
            across, down = (ALONG, ACROSS) if grating.axis == "x" else (ACROSS, ALONG)
            xs, ys = (
                low + (np.arange(n) + 0.5) / n * (high - low) for low, high, n in ((x0, x1, across), (y0, y1, down))
            )
            spots.append(np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2))
        self._places, self._ends = Places(np.concatenate(spots)), ALONG * ACROSS * np.arange(len(spots) + 1)
        self._corners = np.array([grating.rect_mm for grating in badge.gratings], float).reshape(-1, 1, 2)
        self._last: list[Grey] | None = None

    def differs(self, luma: Picture, page: Array) -> bool:
        """Whether a grating does not look as it did in the frame that was kept last, if there is one.

        Parameters: page: homography page mm -> px.
        """
        return _differ(self._gratings(luma, page), self._last)

    def keep(self, luma: Picture, page: Array) -> bool:
        """Keep this frame; returns whether it differs from the one that was kept last."""
        last, self._last = self._last, self._gratings(luma, page)
        return _differ(self._last, last)

    def forget(self) -> None:
        """Keep no frame."""
        self._last = None

    def apart_px(self, one: Array, other: Array) -> float:
        """The most by which two homographies page mm -> px differ at the corners of the gratings."""
        return float(
            np.abs(np.subtract(*(cv2.perspectiveTransform(self._corners, page) for page in (one, other)))).max()
        )

    def _gratings(self, luma: Picture, page: Array) -> list[Grey] | None:
        """Brightness of each grating, without its mean and of unit size; None outside the picture."""
        values = Sampler(luma).at(page, self._places)
        if values is None:
            return None
        parts = [values[start:end] for start, end in itertools.pairwise(self._ends.tolist())]
        parts = [part - part.mean() for part in parts]
        return [part / max(float(np.sqrt(part @ part)), 1e-9) for part in parts]


def _differ(seen: list[Grey] | None, last: list[Grey] | None) -> bool:
    if seen is None or last is None:
        return last is not None
    return any(float(a @ b) < ALIKE for a, b in zip(seen, last, strict=True))
