"""Registering the known page: the homography that makes the picture's markers match the printed ones.

Corners alone throw most of a marker away; here every edge of every module counts, which at 1 m places the page to
some thousandths of a pixel's worth of tilt more than corners do, and goes on where a marker no longer decodes.

Source: inverse compositional alignment (Baker and Matthews, Lucas-Kanade 20 Years On, 2004), with a gain and an
offset of brightness solved for in each marker.  Deviation: the template is drawn from the badge, not taken from a
frame, so nothing drifts.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers

Array = NDArray[np.float64]
#: White kept around a marker, in modules; the grating begins 1.05 modules away.
BORDER_MODULES = 0.7
#: Standard deviation of the picture's own blur, px: the pixel's box (0.29), demosaicing, lens and codec.
BLUR_PX = 0.8
MAX_STEPS = 12
#: Steps stop when no point of the page moves by more than this, px.
STOP_PX = 0.003
#: Below this correlation between picture and print the frame is not the page.
MIN_CORRELATION = 0.80
#: A marker is seen where it correlates so far with its print; of the four, so many must be.
MARKER_CORRELATION, MIN_MARKERS = 0.5, 3
#: Least contrast of a marker's black and white, in the picture's counts.
MIN_GAIN = 2.0
#: The template is drawn anew where the picture's scale changes by more than this factor.
SCALE_STEP = 1.2


@dataclass(frozen=True)
class Registration:
    """Homography page mm -> image px, (3, 3) with h33 = 1; correlation of picture and print over the markers."""

    homography: Array
    correlation: float


@dataclass(frozen=True)
class _Template:
    """Sample places, their printed brightness, and what turns brightness residuals into warp parameters.

    Convention: one marker's samples after another's, as many of each.
    printed (4, N / 4): values of each marker about their mean; solvers: least-squares solvers (8, N) by which of the
    markers are seen, made as they are needed.
    """

    points: Array
    marker: NDArray[np.int64]
    values: Array
    printed: Array
    jacobian: Array
    px_per_mm: float
    solvers: dict[tuple[bool, ...], Array] = field(default_factory=dict)

    def solve(self, seen: tuple[bool, ...], residual: Array) -> Array:
        """Warp parameters (8,) that explain the residuals of the markers that are seen."""
        if seen not in self.solvers:
            used = np.array(seen)[self.marker]
            jacobian = np.where(used[:, None], self.jacobian, 0.0)
            self.solvers[seen] = _projector(jacobian, self.marker, self.values)
        return np.asarray(self.solvers[seen] @ residual)


class PageRegistrar:
    """Registers frames of one page; keeps the template of the last scale."""

    def __init__(self, markers: Markers) -> None:
        self._markers = markers
        centers = np.asarray(markers.centers_mm)
        self._middle = centers.mean(axis=0)
        self._extent = float(np.abs(centers - self._middle).max())
        # Warps are solved for in coordinates of about one, where their eight parameters weigh alike.
        self._to_page = np.array([[self._extent, 0, self._middle[0]], [0, self._extent, self._middle[1]], [0, 0, 1.0]])
        self._template: _Template | None = None

    def register(self, luma: NDArray[np.uint8], start: Array) -> Registration | None:
        """Refine `start` on this frame; None where the page does not match.

        Convention: as `MarkerFinder.find`.
        """
        template = self._template_for(scale_px_per_mm(start, self._middle))
        warp = start @ self._to_page
        for _ in range(MAX_STEPS):
            values = sample(luma, warp, template.points)
            if values is None:
                return None
            residual, correlation, seen = self._residual(values, template)
            # Far from its place a page's markers match badly; then all of them are asked for the way.
            step = template.solve(seen if sum(seen) >= MIN_MARKERS else (True,) * 4, residual)
            increment = np.array(
                [[1 + step[0], step[1], step[2]], [step[3], 1 + step[4], step[5]], [step[6], step[7], 1]]
            )
            try:
                warp = warp @ np.linalg.inv(increment)
            except np.linalg.LinAlgError:
                return None
            warp /= warp[2, 2]
            if np.abs(step).max() * self._extent * template.px_per_mm < STOP_PX:
                break
        else:
            # A last step that was not small may have led anywhere, so what is seen there is looked at once more.
            values = sample(luma, warp, template.points)
            if values is None:
                return None
            _, correlation, seen = self._residual(values, template)
        if sum(seen) < MIN_MARKERS:
            # Two markers of one side leave the page free to turn about them, and the pose is worth nothing.
            return None
        homography = warp @ np.linalg.inv(self._to_page)
        if not (correlation >= MIN_CORRELATION and np.all(np.isfinite(homography))):
            return None
        return Registration(homography / homography[2, 2], float(correlation))

    def _residual(self, values: Array, template: _Template) -> tuple[Array, float, tuple[bool, ...]]:
        """Picture less print in units of print contrast, their correlation, and which of the markers are seen.

        Gain and offset are fitted a marker.  One that is hidden has no say: what covers it has edges of its own.
        """
        picture = values.reshape(4, -1)
        picture = picture - picture.mean(axis=1, keepdims=True)
        power = np.einsum("mn,mn->m", template.printed, template.printed)
        along = np.einsum("mn,mn->m", picture, template.printed)
        gain, most = along / power, np.sqrt(power * np.einsum("mn,mn->m", picture, picture))
        # A marker that is washed out must not be blown up to full contrast.
        clear = gain > MIN_GAIN
        seen = clear & (along >= MARKER_CORRELATION * most)
        share = 1 / np.where(clear, gain, np.inf)
        residual = picture * share[:, None] - template.printed * clear[:, None]
        explained, total = float(along[seen].sum()), float(most[seen].sum())
        return residual.ravel(), explained / total if total > 0 else 0.0, tuple(seen.tolist())

    def _template_for(self, px_per_mm: float) -> _Template:
        kept = self._template
        if kept and kept.px_per_mm / SCALE_STEP < px_per_mm < kept.px_per_mm * SCALE_STEP:
            return kept
        self._template = self._draw(px_per_mm)
        return self._template

    def _draw(self, px_per_mm: float) -> _Template:
        """Print the four markers at about one sample a pixel, blurred as a picture blurs, with their gradients."""
        points, owner, values, gradients = [], [], [], []
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self._markers.dictionary))
        modules = known.markerSize + 2
        size_mm = self._markers.size_mm
        module_mm = size_mm / modules
        reach_mm = size_mm / 2 + BORDER_MODULES * module_mm
        count = int(np.clip(2 * reach_mm * px_per_mm, 24, 160))
        pitch_mm = 2 * reach_mm / count
        fine = 8
        offsets = (np.arange(count * fine) + 0.5) / fine * pitch_mm - reach_mm
        column = np.floor((offsets + size_mm / 2) / module_mm).astype(int)
        inside = (column >= 0) & (column < modules)
        blur = BLUR_PX / px_per_mm / pitch_mm * fine
        for index, (identity, center) in enumerate(zip(self._markers.ids, self._markers.centers_mm, strict=True)):
            bits = np.asarray(cv2.aruco.generateImageMarker(known, identity, modules)) > 127
            picture = np.ones((count * fine, count * fine), np.float32)
            picture[np.ix_(inside, inside)] = bits[np.ix_(column[inside], column[inside])]
            picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), blur, borderType=cv2.BORDER_REPLICATE))
            gradient_y, gradient_x = np.gradient(picture, pitch_mm / fine)
            middle = slice(fine // 2, None, fine)
            x, y = np.meshgrid(offsets[middle], offsets[middle])
            points.append(np.column_stack([x.ravel() + center[0], y.ravel() + center[1]]))
            values.append(picture[middle, middle].ravel())
            gradients.append(np.column_stack([gradient_x[middle, middle].ravel(), gradient_y[middle, middle].ravel()]))
            owner.append(np.full(x.size, index))
        place = (np.concatenate(points) - self._middle) / self._extent
        marker = np.concatenate(owner)
        printed = np.concatenate(values).astype(float)
        jacobian = _warp_jacobian(place, np.concatenate(gradients).astype(float) * self._extent)
        apart = printed.reshape(4, -1) - printed.reshape(4, -1).mean(axis=1, keepdims=True)
        return _Template(place, marker, printed, apart, jacobian, px_per_mm)


def _warp_jacobian(place: Array, gradient: Array) -> Array:
    """Change of printed brightness with each of the eight warp parameters, (N, 8)."""
    x, y = place.T
    gx, gy = gradient.T
    inward = gx * x + gy * y
    return np.column_stack([gx * x, gx * y, gx, gy * x, gy * y, gy, -inward * x, -inward * y])


def _projector(jacobian: Array, marker: NDArray[np.int64], printed: Array) -> Array:
    """Least-squares solver (8, N) for the warp, blind to each marker's gain and offset."""
    free = jacobian.copy()
    for index in range(4):
        here = marker == index
        basis, _ = np.linalg.qr(np.column_stack([np.ones(here.sum()), printed[here]]))
        free[here] -= basis @ (basis.T @ free[here])
    # A hundred times cheaper than the inverse of the tall table itself, and eight parameters of like weight allow it.
    return np.asarray(np.linalg.pinv(free.T @ free, hermitian=True) @ free.T)


def scale_px_per_mm(homography: Array, place_mm: Array) -> float:
    """Pixels to the millimetre around a place of the page: the root of the area scale."""
    x, y = place_mm
    w = homography[2] @ (x, y, 1.0)
    # The Jacobian determinant of a homography is det(H) / w^3.
    return float(np.sqrt(abs(np.linalg.det(homography) / w**3)))


def sample(luma: NDArray[np.uint8], warp: Array, points: Array) -> Array | None:
    """Bilinear brightness at warp(points), (N,); None where one lies outside the picture.

    Source: OpenCV's remap of a float picture, which from OpenCV 5 on takes places as they are; before, it rounded them
    to 1/32 pixel, which is more than registration resolves (a test holds it).
    """
    mapped = warp[:, :2] @ points.T + warp[:, 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = mapped[:2] / mapped[2]
    if not (x.min() >= 0 and y.min() >= 0 and x.max() < luma.shape[1] - 1 and y.max() < luma.shape[0] - 1):
        return None
    # Counted from a corner nearby, because single precision resolves no more than 1e-4 px at 2000 px.
    left, top = int(x.min()), int(y.min())
    near = luma[top : int(y.max()) + 2, left : int(x.max()) + 2].astype(np.float32)
    # Remap takes at most 32767 places in a row.
    rows = 4 if x.size % 4 == 0 else 1
    across, down = (x - left).reshape(rows, -1).astype(np.float32), (y - top).reshape(rows, -1).astype(np.float32)
    return np.asarray(cv2.remap(near, across, down, cv2.INTER_LINEAR), float).ravel()
