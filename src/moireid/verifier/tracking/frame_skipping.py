"""Which frames of a badge that hardly changes need not be measured.

A film of 60 frames a second shows each moment of a hand twice.  Once some seconds are measured in full, every second
frame is enough, as long as it looks like the last one that was measured: 30 a second, at which a hand's tremor is still
seen.  A film of 240 a second comes to that rate step by step.

A badge is calm if its page goes on as it did and its fringes hardly move from one measured frame to the next; of one
that trembles all frames are needed.  A frame that is passed by is looked at all the same: its markers and gratings,
block by block.  If any differs, because of a fast hand or of a picture that was put between the others, it is
measured, and so is each frame of the next half second.

A forger can read this source.  So each pixel of a block counts: if only some places were compared, a forger would have
to get only those right.  And time counts, not the number of frames: times in the file may slow down at any frame.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.registration import scale_px_per_mm
from moireid.verifier.tracking.sampling import hull_of, part_around, within_picture

Array = NDArray[np.float64]
Grey = NDArray[np.float32]
#: Every second frame is left out once this many are measured, 4 s at 60 a second, and this many in a row are calm.  So
#: twice as many are left as a verdict needs at least.
FULL_FRAMES, CALM_FRAMES = 240, 60
#: Frames are not left out if the others would be further apart than this; 30 a second are 0.033 s.
LONGEST_STEP_S = 0.036
#: ... and of those that are measured already, none are left out if that would leave a gap beyond this: one of 60 frames
#: a second may be missing.
LONGEST_GAP_S = 0.054
#: A page that goes on as it did is found within this of where it is expected, px.  Set by hand: its place between two
#: frames is then known to an eighth of that, and a registration errs by 0.02 to 0.05 px.  A camera in one hand moves
#: pages by 1 to 5 px more or less than expected, at 60 frames a second.
CALM_PX = 0.5
#: Each frame is measured for so long after one that differs, s.
RESTLESS_S = 0.5
#: Samples along the longer side of markers and gratings together, and along a block of a grating: about a millimetre
#: and 16 mm of a badge in hand format.
SAMPLES, BLOCK = 128, 16
#: Least correlation with the last measured frame, of each block of a grating, and of each strip that both frames
#: measured.  Derived: fringes that have moved by 0.3 rad, a tenth of the half turn by which their motion could be
#: mistaken, still have cos 0.3 = 0.955.
ALIKE = 0.95
#: A frame halfway to the next measured one may have moved by half of that, or it is measured as well: 0.22 rad of
#: fringes.  In every second frame put off by so much, a motion test of all frames finds hardly anything.  No less is
#: asked of an earlier one, as noise and coding take some.
LEAST_SHARE = 0.5
#: The same of a whole marker.  Set by hand: it drops by that if a marker of 25 px is off by half a pixel.
SAME_MARKER = 0.9


def strips_differ(seen: Grey, last: Grey) -> bool:
    """Whether a strip's brightness profile is not that of the last measured frame; both (S, N)."""
    here, there = (values - values.mean(axis=1, keepdims=True) for values in (seen, last))
    size = np.sqrt((here**2).sum(axis=1) * (there**2).sum(axis=1))
    return bool(((here * there).sum(axis=1) < ALIKE * size).any())


class CalmWatch:
    """Compares a badge's markers and gratings in a frame with those in the last measured one."""

    def __init__(self, badge: Badge) -> None:
        dark = badge.markers.dark_mm
        rects = np.array([*dark, *(badge.bounds_of(grating) for grating in badge.gratings)])
        low, high = rects[:, :2].min(axis=0), rects[:, 2:].max(axis=0)
        self._step_mm = float((high - low).max()) / SAMPLES
        columns, rows = np.ceil((high - low) / self._step_mm).astype(int).tolist()
        self._size, self._hull, self._middle = (columns, rows), hull_of((*low, *high)), (low + high) / 2
        self._page = np.array([[self._step_mm, 0, low[0]], [0, self._step_mm, low[1]], [0, 0, 1.0]])
        # Samples at a border are mixed with what is next to it.
        first = np.ceil((rects[:, :2] - low) / self._step_mm).astype(int)
        end = np.maximum(np.floor((rects[:, 2:] - low) / self._step_mm).astype(int), first + 1)
        self._parts = [(slice(y0, y1), slice(x0, x1)) for (x0, y0), (x1, y1) in zip(first, end, strict=True)]
        self._markers = len(dark)
        self._corners = rects[self._markers :].reshape(-1, 1, 2)
        self._last: list[Grey] | None = None

    @property
    def holds(self) -> bool:
        """Whether a frame is kept."""
        return self._last is not None

    def apart(self, luma: Picture, page: Array) -> float:
        """How far a frame is from the one that is kept: 1 where a marker or a part of a grating is no longer `ALIKE`.

        Parameters: page: homography page mm -> px.
        Returns: the worst part's; infinite if there is nothing to compare.
        """
        seen, last = self._seen(luma, page), self._last
        if seen is None or last is None:
            return np.inf
        markers, gratings = slice(self._markers), slice(self._markers, None)
        squares = [_apart(a, b) / (2 * (1 - SAME_MARKER)) for a, b in zip(seen[markers], last[markers], strict=True)]
        blocks = [_blocks_apart(a, b) / (2 * (1 - ALIKE)) for a, b in zip(seen[gratings], last[gratings], strict=True)]
        return max(*squares, *blocks)

    def keep(self, luma: Picture, page: Array) -> None:
        """Keep this frame, or none if it does not show the badge as a whole."""
        self._last = self._seen(luma, page)

    def forget(self) -> None:
        """Keep no frame."""
        self._last = None

    def apart_px(self, one: Array, other: Array) -> float:
        """The most by which two homographies page mm -> px differ at the corners of the gratings."""
        return float(
            np.abs(np.subtract(*(cv2.perspectiveTransform(self._corners, page) for page in (one, other)))).max()
        )

    def _seen(self, luma: Picture, page: Array) -> list[Grey] | None:
        """Brightness of each marker and grating, without its mean and of unit size; None if one is not in the picture.

        Convention: a sample is the mean of about as many pixels as lie between two.
        """
        if not within_picture(luma, page, self._hull):
            return None
        box, warp = part_around(luma, page, self._hull)
        picture = luma.part(box)
        least = min(picture.shape)
        fewer = int(np.clip(round(self._step_mm * scale_px_per_mm(page, self._middle)), 1, least))
        if fewer > 1:
            rows, columns = (size // fewer for size in picture.shape)
            whole = picture[: rows * fewer, : columns * fewer]
            picture = cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA)
            # Scaling keeps pixel edges, not centres, in place: x' + 0.5 = (x + 0.5) / fewer.
            shift = 0.5 / fewer - 0.5
            warp = np.array([[1 / fewer, 0, shift], [0, 1 / fewer, shift], [0, 0, 1.0]]) @ warp
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        board = cv2.warpPerspective(
            picture, warp @ self._page, self._size, flags=flags, borderMode=cv2.BORDER_REPLICATE
        )
        return [_normed(board[part]) for part in self._parts]


def _normed(part: NDArray[np.uint8]) -> Grey:
    apart = part.astype(np.float32) - np.float32(part.mean())
    return np.asarray(apart / max(float(np.linalg.norm(apart)), 1e-9))


def _apart(one: Grey, other: Grey) -> float:
    """Sum of squares of the difference: of pictures of unit size, twice what is missing to a correlation of 1."""
    return float(((one - other) ** 2).sum())


def _blocks_apart(one: Grey, other: Grey) -> float:
    """As `_apart`, of the block that differs most; one of little contrast is held against the mean block."""
    apart, size = _block_sums((one - other) ** 2), _block_sums(other**2)
    return float((apart / np.maximum(np.maximum(size, size.mean()), 1e-9)).max())


def _block_sums(values: Grey) -> Grey:
    """Sums over blocks of `BLOCK` x `BLOCK` samples; those at the far ends may be smaller."""
    rows, columns = (np.arange(0, size, BLOCK) for size in values.shape)
    return np.asarray(np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1))
