"""Following a page whose markers are garbled by its own print, as the frame shows it in which its corners were given.

A person says where the striped region's corners are in one frame; from there the page is followed by what is printed
beside the gratings: what is left of the markers, the name, the board's outline.  Following the corners themselves, as
the published protocol does, is no use to a test of motion: half of the window about a corner shows fringes, which move
by themselves and drag it along, by 4 to 7 px on true films at 1 m.

1. Between two frames features at known places of the page are followed, and a homography is fitted to those that come
   back when followed back: where the page is within a pixel or so.
2. There the page is registered to the print of the given frame, which is never renewed, so nothing drifts.

A page that is lost is looked for where it was seen last, in every frame that comes.  Where corners are given again, the
page is registered near them to the print that is known already, so that it stays wrong by the same warp; only where
that fails the print is taken anew.

Convention: as `corners`; homographies page mm -> px.  Where the corners were given wrongly, the page is wrong by one
and the same warp in all frames (`page_warp`).
Source: step 1: Shi and Tomasi's features, pyramidal Lucas-Kanade, MAGSAC as OpenCV has it; step 2: as `register`.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Rect
from moireid.verifier.corners import MOST_RETURN_PX, Corners
from moireid.verifier.tracking.registration import PageRegistrar, Registration, sample, scale_px_per_mm
from moireid.verifier.tracking.template import Template, warp_jacobian

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
#: Print so near to a grating is not looked at: a sheet that is cut larger, and what blur carries over, mm.
GRATING_MARGIN_MM = 2.0
#: What is looked at beyond the board's edge, px, or the edge itself would not be seen where corners were given wrongly.
BEYOND_PX = 4.0
#: Samples to a pixel's side, and the most of them.
SAMPLES_PER_PX, MOST_SAMPLES = 1.0, 60000
#: Least contrast of what is looked at, counts: less is noise.
LEAST_CONTRAST = 12.0
#: Features followed from frame to frame, their least distance and the side of their window, px.
MOST_FEATURES, APART_PX, SIDE_PX, LEVELS = 80, 4, 15, 4
#: Fewer that come back tell no homography; agreement with it, px.
LEAST_FEATURES, AGREE_PX = 8, 2.0


class OwnPage:
    """Follows one page from where its corners were given."""

    def __init__(self, badge: Badge, corners: Corners) -> None:
        self._badge, self._given = badge, dict(corners)
        self._registrar = PageRegistrar(badge.markers)
        printer = self._registrar.printer
        self._middle, self._extent = printer.middle, printer.extent
        x0, y0, x1, y1 = badge.gratings[0].rect_mm
        self._region = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        self._template: Template | None = None
        self._places = np.zeros((0, 2))  # Of the features, page mm.
        self._last: tuple[Luma, Array] | None = None

    def find(self, index: int, luma: Luma) -> Registration | None:
        """The page in the next frame, None where it is not seen near its last place."""
        found: Registration | None = None
        if index in self._given:
            found = self._set_right(luma, self._given[index])
        elif self._last is not None and self._template is not None:
            found = self._registrar.register(luma, self._moved(luma, *self._last), self._template)
        if found is not None:
            self._last = luma, found.homography
        return found

    def _set_right(self, luma: Luma, corners: Array) -> Registration | None:
        """The page where somebody says that it is: by the print known already, or by the print of this frame."""
        homography = np.asarray(
            cv2.getPerspectiveTransform(self._region.astype(np.float32), corners.astype(np.float32)), float
        )
        known = self._registrar.register(luma, homography, self._template) if self._template is not None else None
        if known is not None:
            return known
        taken = self._taken(luma, homography)
        if taken is None:
            return None
        self._template, self._places = taken
        return Registration(homography, 1.0)

    def _moved(self, luma: Luma, before: Luma, homography: Array) -> Array:
        """Where the page is by its features, or where it was if too few of them are seen."""
        if len(self._places) < LEAST_FEATURES:
            return homography
        start = cv2.perspectiveTransform(self._places[:, None], homography).astype(np.float32)
        window = (SIDE_PX, SIDE_PX)
        there, seen, _ = cv2.calcOpticalFlowPyrLK(before, luma, start, start.copy(), winSize=window, maxLevel=LEVELS)
        back, seen_back, _ = cv2.calcOpticalFlowPyrLK(
            luma, before, there, there.copy(), winSize=window, maxLevel=LEVELS
        )
        apart = np.linalg.norm(back - start, axis=-1).ravel()
        good = (seen.ravel() > 0) & (seen_back.ravel() > 0) & (apart < MOST_RETURN_PX)
        if good.sum() < LEAST_FEATURES:
            return homography
        moved, _ = cv2.findHomography(self._places[good], there[good], cv2.USAC_MAGSAC, AGREE_PX)
        return homography if moved is None or not np.all(np.isfinite(moved)) else np.asarray(moved, float)

    def _taken(self, luma: Luma, homography: Array) -> tuple[Template, Array] | None:
        """The print beside the gratings as this frame shows it, and its features; None where it is not in view."""
        px_per_mm = scale_px_per_mm(homography, self._middle)
        x0, y0, x1, y1 = np.array(self._badge.outline_mm) + BEYOND_PX / px_per_mm * np.array([-1, -1, 1, 1])
        area = (x1 - x0) * (y1 - y0)
        pitch = max(1 / (SAMPLES_PER_PX * px_per_mm), float(np.sqrt(area / MOST_SAMPLES)))
        across, down = (np.arange(low + pitch / 2, high, pitch) for low, high in ((x0, x1), (y0, y1)))
        grid = np.stack(np.meshgrid(across, down), axis=-1)
        kept = np.ones(grid.shape[:2], bool)
        for grating in self._badge.gratings:
            kept &= _outside(grid, grating.rect_mm, GRATING_MARGIN_MM)
        values = sample(luma, homography, grid.reshape(-1, 2))
        if values is None:
            return None
        flat = cv2.GaussianBlur(values.reshape(kept.shape).astype(np.float32), (0, 0), 0.7)
        quarter = (grid[..., 0] > self._middle[0]) + 2 * (grid[..., 1] > self._middle[1])
        parts = [flat[kept & (quarter == k)] for k in range(4)]
        if min(map(len, parts)) < 2 or np.ptp(flat[kept]) < LEAST_CONTRAST or min(map(np.ptp, parts)) <= 0:
            return None
        # In units of its own contrast, as a drawn template is.
        flat = (flat - flat[kept].min()) / max(float(np.ptp(flat[kept])), 1e-6)
        gy, gx = np.gradient(flat.astype(float), pitch)
        order = np.argsort(quarter[kept], kind="stable")
        group = quarter[kept][order]
        places = (grid[kept][order] - self._middle) / self._extent
        shown = flat[kept][order].astype(float)
        slopes = np.column_stack([gx[kept], gy[kept]])[order] * self._extent
        first = np.searchsorted(group, np.arange(4))
        printed = np.concatenate([part - part.mean() for part in np.split(shown, first[1:])])
        template = Template(
            places, group.astype(np.int64), shown, first, printed, warp_jacobian(places, slopes), px_per_mm
        )
        corners = cv2.goodFeaturesToTrack(flat, MOST_FEATURES, 0.02, APART_PX, mask=kept.astype(np.uint8))
        features = np.zeros((0, 2)) if corners is None else corners.reshape(-1, 2) * pitch + (across[0], down[0])
        return template, np.asarray(features, float)


def _outside(grid: Array, rect: Rect, margin_mm: float) -> NDArray[np.bool_]:
    x, y = grid[..., 0], grid[..., 1]
    x0, y0, x1, y1 = rect
    return np.asarray((x < x0 - margin_mm) | (x > x1 + margin_mm) | (y < y0 - margin_mm) | (y > y1 + margin_mm))
