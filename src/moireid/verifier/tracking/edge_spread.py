"""How sharp a film is: the spread of the page's printed edges.

Lens, focus, motion and codec blur page and fringes alike, and no lens sheet lies over the page's squares or frame.  So
their straight edges show what the film itself takes from fine fringes.

Convention: along x, of upright edges, and along y, of level ones; mm of the page, so that a far badge is less sharp.
Source: slanted-edge method (ISO 12233): an edge's profile is the integral of the line spread, whose Fourier transform
    is the modulation transfer.  Deviations: places across an edge come from the page's homography, so that edges may
    lie at any angle; profiles are interpolated as those of strips are; the line spread is taken for a Gaussian, as
    there is other print a module away.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from moireid.badge import CodedFrame, Fiducial
from moireid.verifier.kernel.page import PageRows, Points
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.patches import module_of

Array = NDArray[np.float64]
#: Edges are read in one frame of so many, at so many places across, every so many mm along.
EVERY_FRAMES, ACROSS, ALONG_MM = 8, 33, 1.0
#: Spreads that are looked for, in modules.
SPREADS = np.geomspace(0.03, 1.0, 48)


class EdgeReader:
    """Reads a page's mean edge along each axis, and measures its spread."""

    def __init__(self, fiducial: Fiducial) -> None:
        self._module_mm = reach = module_of(fiducial)
        across = np.linspace(-reach, reach, ACROSS)
        rows: tuple[list[Array], list[Array]] = ([], [])
        notches = fiducial.notches_mm if isinstance(fiducial, CodedFrame) else ()
        for rect in fiducial.dark_mm:
            for axis, own in enumerate(rows):
                along = np.arange(rect[1 - axis] + reach, rect[3 - axis] - reach, ALONG_MM)
                hidden = [(along > n[1 - axis] - reach) & (along < n[3 - axis] + reach) for n in notches]
                free = along[~np.any(hidden, axis=0)] if hidden else along
                for edge, outward in ((rect[axis], -1), (rect[axis + 2], 1)):
                    grid = np.stack(np.meshgrid(edge + outward * across, free if len(free) else along), axis=-1)
                    own.append(grid[..., :: 1 - 2 * axis].reshape(-1, 2))
        points = [np.concatenate(own) for own in rows]
        counts = np.array([len(own) // ACROSS for own in points], np.int32)
        self._rows = PageRows(Points(np.concatenate(points)), counts, ACROSS, 1.0)

    def read(self, luma: Picture, homography: Array) -> NDArray[np.float32]:
        """Brightness across the edges in a frame, from black to white, (2, N), in `LINEAR_COUNTS`."""
        return self._rows.read(luma.in_light.struct, homography)

    def spread_mm(self, edges: Array) -> Array:
        """Standard deviation of the line spread, (2,), from profiles (2, N) as `read`; the least where there are none.

        Source: least squares over a module of black, one of white, and other print next to both.
        """
        place = np.linspace(-1, 1, ACROSS)[:, None] - np.array([-1.0, 0.0, 1.0])
        left = []
        for spread in SPREADS:
            steps = [math.erf(z) for z in (place / (math.sqrt(2) * spread)).ravel()]
            table = np.column_stack([np.ones(ACROSS), np.reshape(steps, place.shape)])
            left.append(np.sum((edges.T - table @ np.linalg.lstsq(table, edges.T, rcond=None)[0]) ** 2, axis=0))
        return np.asarray(self._module_mm * SPREADS[np.argmin(left, axis=0)])
