"""How sharp a film is: the spread of the page's printed edges.

Lens, focus, motion and codec blur page and fringes alike, and no lens sheet lies over the page's squares or frame.  So
their straight edges show what the film itself takes from fine fringes.

Convention: along x, of upright edges, and along y, of level ones; mm of the page, so that a far badge is less sharp.
Source: slanted-edge method (ISO 12233): an edge's profile is the integral of the line spread, whose Fourier transform
    is the modulation transfer.  Deviations: places across an edge come from the page's homography, so that edges may
    lie at any angle; profiles are interpolated as those of strips are; the line spread is a Gaussian, fitted to the
    known print, as there is other print a module away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Fiducial
from moireid.verifier.kernel.page import PageRows, Points
from moireid.verifier.picture import Picture
from moireid.verifier.tracking.patches import module_of, patches_of

Array = NDArray[np.float64]
#: Edges are read in one frame of so many, at so many places across, every so many mm along.
EVERY_FRAMES, ACROSS, ALONG_MM = 8, 33, 1.0
#: In modules: places across that are read, those at which the print is known, and spreads that are looked for.
PLACES, PRINTED, SPREADS = np.linspace(-1, 1, ACROSS), (np.arange(128) + 0.5) / 16 - 4, np.geomspace(0.05, 1.0, 40)


class EdgeReader:
    """Reads a page's mean edge along each axis, and measures its spread."""

    def __init__(self, fiducial: Fiducial) -> None:
        self._module_mm = module_of(fiducial)
        rows: tuple[list[Array], list[Array]] = ([], [])
        shown: tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]] = ([], [])
        for rect, patch in zip(fiducial.dark_mm, patches_of(fiducial), strict=False):
            for axis, other in ((0, 1), (1, 0)):
                along = np.arange(rect[other] + self._module_mm, rect[other + 2] - self._module_mm, ALONG_MM)
                for edge, outward in ((rect[axis], -self._module_mm), (rect[axis + 2], self._module_mm)):
                    grid = np.stack(np.meshgrid(edge + outward * PLACES, along), axis=-1)
                    rows[axis].append(grid[..., [axis, other]].reshape(-1, 2))
                    offsets = edge + outward * PRINTED - patch.center_mm[axis], along - patch.center_mm[other]
                    shown[axis].append(patch.print(offsets[axis], offsets[other]).swapaxes(0, axis))
        points = [np.concatenate(own) for own in rows]
        counts = np.array([len(own) // ACROSS for own in points], np.int32)
        self._rows = PageRows(Points(np.concatenate(points)), counts, ACROSS)
        self._print = [np.concatenate(own).mean(axis=0) for own in shown]

    def read(self, luma: Picture, homography: Array) -> NDArray[np.float32]:
        """Brightness across the edges in a frame, from black to white, (2, N), in `LINEAR_COUNTS`."""
        return self._rows.read(luma.in_light.struct, homography)

    def spread_mm(self, edges: Array) -> Array:
        """Standard deviation of the line spread, (2,), from profiles (2, N) as `read`; the least where there are none.

        Source: least squares of black, white, and what is printed a module outside.
        """
        left = []
        for spread in SPREADS:
            blur = np.exp(-(((PLACES[:, None] - PRINTED) / spread) ** 2) / 2)
            blur /= blur.sum(axis=1, keepdims=True)
            for edge, printed in zip(edges, self._print, strict=True):
                table = np.column_stack([np.ones(ACROSS), blur @ printed, blur @ (PRINTED > 1)])
                left.append(np.sum((edge - table @ np.linalg.lstsq(table, edge, rcond=None)[0]) ** 2))
        return np.asarray(self._module_mm * SPREADS[np.argmin(np.reshape(left, (-1, 2)), axis=0)])
