"""The borders of the gratings, which register the page where only two markers are seen.

With two markers alone, the tilt across them rests on differences over one marker's width.  The badge file also gives
the borders of each grating, which are printed in the page's plane.  (Fringes cannot help: their motion is what is
tested.)  Only the borders that the lens sheet does not magnify are used: those across the lines, beyond which the page
is white.  Fringes make such a border dark and bright in turn, so it is cut into short segments, each with its own
brightness and contrast.  A segment whose fringe is as white as the page is not visible.

Convention: the sheet displaces the print under it with the view direction, print and sheet end within some tenths of a
    millimetre of each other, and codecs move an edge by a tenth of a pixel.  So a displacement of each border is
    estimated, and one rotation of each sheet against the page.  It is enough to know that the borders are straight and
    parallel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, CodedFrame, Rect
from moireid.frames import own_frame, own_rect
from moireid.verifier.tracking.print_template import BLUR_PX, warp_jacobian

Array = NDArray[np.float64]
#: Brightness is sampled this far to either side of a border; length of a segment and distance to the next, mm.
REACH_MM, SEGMENT_MM = 2.0, 1.5
#: Samples along and across a segment.
ALONG, ACROSS = 2, 9
#: A segment is visible if it has this correlation with a border and this share of the markers' contrast.
SEGMENT_CORRELATION, SEGMENT_GAIN = 0.85, 0.15
#: Visible segments that a border needs, and the share of its length that they span; two borders must be visible.
LEAST_SEGMENTS, LEAST_SPAN = 8, 0.25
#: Weight of a sample at a border against one of a marker: fringes are not an even grey.
BORDER_WEIGHT = 0.25
#: Standard deviations of a border's displacement, mm (a sheet of 1 mm, put on by hand, seen at up to 15 degrees), and
#: of its rotation, rad (the twist that a sheet may have).
SHIFT_SD_MM, TURN_SD = 0.3, 0.004


@dataclass(frozen=True)
class Borders:
    """Segments of all borders: S segments of M samples.

    places (S, M, 2) page mm; inward (S, M): distance from the border towards the grating, mm; normal (S, 2): unit
    vector inward; border (S,): the border it belongs to; freedom (S, K): its shift inward, mm, per unit of each of the
    K possible displacements; freedom_sd (K,): their standard deviations.
    """

    places: Array
    inward: Array
    normal: Array
    border: NDArray[np.int64]
    freedom: Array
    freedom_sd: Array

    def equations(
        self, values: Array, freed: Array, middle: Array, extent: float, px_per_mm: float, contrast: float
    ) -> tuple[Array, Array] | None:
        """Rows (N, 8 + K) and right side (N,) of least squares for a warp's step and the displacements, in units of the
        markers' contrast; None if too little of the borders is visible.

        Parameters: values (S, M): brightness seen at the places; freed (K,): as found so far; middle, extent: of the
            template's coordinates; contrast: of the markers, counts.
        """
        inward = self.inward - (self.freedom @ freed)[:, None]
        # SciPy's takes longer to load than a short film to verify.
        edge = map(math.erf, (inward * px_per_mm / BLUR_PX / math.sqrt(2)).ravel().tolist())
        printed = -0.5 * np.fromiter(edge, float).reshape(inward.shape)
        apart, own = values - values.mean(axis=1, keepdims=True), printed - printed.mean(axis=1, keepdims=True)
        power = (own**2).sum(axis=1)
        # A segment far from its border has no contrast across it.
        gain = (apart * own).sum(axis=1) / np.where(power > 0, power, np.inf)
        agree = (apart * own).sum(axis=1) / np.maximum(np.sqrt(power * (apart**2).sum(axis=1)), 1e-12)
        seen = (agree >= SEGMENT_CORRELATION) & (gain >= SEGMENT_GAIN * contrast)
        if not self._enough(seen):
            return None
        share = BORDER_WEIGHT * np.minimum(gain[seen] / contrast, 1.0)[:, None]
        slope = -np.exp(-0.5 * (inward[seen] * px_per_mm / BLUR_PX) ** 2) * px_per_mm / BLUR_PX / np.sqrt(2 * np.pi)
        gradient = slope[..., None] * self.normal[seen][:, None, :]
        place = (self.places[seen] - middle) / extent
        rows = warp_jacobian(place.reshape(-1, 2).T, gradient.reshape(-1, 2).T * extent).T
        # If a border is displaced inward, a sample shows the print further out, hence the minus.
        freed_rows = (-slope[..., None] * self.freedom[seen][:, None, :]).reshape(len(rows), -1)
        rows = np.column_stack([rows, freed_rows]).reshape(*slope.shape, -1)
        free = rows - rows.mean(axis=1, keepdims=True)
        shape = own[seen][..., None]
        free -= shape * ((shape * free).sum(axis=1, keepdims=True) / power[seen][:, None, None])
        residual = apart[seen] / contrast - gain[seen][:, None] / contrast * own[seen]
        residual *= BORDER_WEIGHT
        return (share[..., None] * free).reshape(-1, free.shape[-1]), residual.ravel()

    def _enough(self, seen: NDArray[np.bool_]) -> bool:
        """Whether at least two borders are visible over enough of their length."""
        held = 0
        for border in np.unique(self.border):
            mine = self.border == border
            along = self.places[mine].mean(axis=1)
            shown = along[seen[mine]]
            if len(shown) >= LEAST_SEGMENTS and np.ptp(shown, axis=0).max() >= LEAST_SPAN * np.ptp(along, axis=0).max():
                held += 1
        return held >= 2


def borders_of(badge: Badge) -> Borders | None:
    """The usable borders of a badge; None if there are none."""
    if isinstance(badge.markers, CodedFrame):
        # Of a frame, a part of each side is seen, or the page is not followed.
        return None
    upright = own_frame("x", badge.page_mm)
    dark = [(badge.frame_of(g), own_rect(g.axis, g.rect_mm)) for g in badge.gratings]
    dark += [(upright, rect) for rect in badge.markers.dark_mm]
    across = (np.arange(ACROSS) + 0.5) / ACROSS * 2 * REACH_MM - REACH_MM
    along = (np.arange(ALONG) + 0.5) / ALONG * SEGMENT_MM - SEGMENT_MM / 2
    lengthwise, crosswise = (grid.ravel() for grid in np.meshgrid(along, across))
    places, normals, owner = [], [], []
    for g in range(len(badge.gratings)):
        frame, (low, top, high, bottom) = dark[g]
        middles = np.arange(low + 2 * SEGMENT_MM, high - 2 * SEGMENT_MM, SEGMENT_MM)[:, None]
        for edge, sign in ((top, 1.0), (bottom, -1.0)):
            own = np.stack(np.broadcast_arrays(middles + lengthwise, edge + sign * crosswise), axis=-1)
            grid = frame.on_page(own)
            outside, others = grid[:, crosswise < 0], dark[:g] + dark[g + 1 :]
            free = ~np.any([_meet(other.places(outside), rect) for other, rect in others], axis=0)
            places.append(grid[free])
            normals += [sign * np.array(frame.rows[1])] * int(free.sum())
            owner += [len(places)] * int(free.sum())
    if not owner:
        return None
    normal, border_of = np.array(normals), np.array(owner)
    away = (segments := np.concatenate(places)).mean(axis=1) - np.asarray(badge.markers.centers_mm).mean(axis=0)
    turns = normal[:, 1] * away[:, 0] - normal[:, 0] * away[:, 1]
    freedom = np.column_stack([border_of[:, None] == np.unique(border_of), turns]).astype(float)
    sd = np.array([*np.full(freedom.shape[1] - 1, SHIFT_SD_MM), TURN_SD])
    return Borders(segments, np.tile(crosswise, (len(owner), 1)), normal, border_of, freedom, sd)


def _meet(points: Array, rect: Rect) -> NDArray[np.bool_]:
    """Which segments (S, M, 2) have a point within a rectangle, (S,)."""
    x, y = np.moveaxis(points, -1, 0)
    return np.asarray(np.any((x > rect[0]) & (x < rect[2]) & (y > rect[1]) & (y < rect[3]), axis=1))
