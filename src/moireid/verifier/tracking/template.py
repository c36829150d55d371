"""The four markers as a picture shows them: brightness at sample places, and its change as the page moves.

Motion during the exposure smears the print in a frame.  The template is smeared in the same way, so that a shaken frame
is registered at the middle of the smear.

Convention: places in units of the markers' extent about their middle, so that a warp's eight parameters are of like
    size.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers
from moireid.verifier.tracking.sampling import Places
from moireid.verifier.tracking.search_work import DRAWN_NS, SMEAR_STEP_NS, SMEARED_NS

Array = NDArray[np.float64]
#: White kept around a marker, in modules; the grating begins 1.05 modules away.
BORDER_MODULES, FREE_MODULES = 0.7, 1.05
#: Standard deviation of the picture's own blur, px: the pixel's box (0.29), demosaicing, lens and codec.
BLUR_PX = 0.8
#: Samples along a marker's side: at least this many, and more than this tell no more.
SIDE_SAMPLES = (24, 96)
#: The print is drawn with this many fine samples per sample of the template.
FINE = 8


@dataclass(frozen=True)
class Drawing:
    """The four markers, finely drawn: sample pitch of the template, mm, each marker's brightness (side, side), and its
    gradient along x, and along y, per mm.
    """

    pitch_mm: float
    pictures: tuple[NDArray[np.float32], ...]
    along_x: tuple[NDArray[np.float32], ...]
    along_y: tuple[NDArray[np.float32], ...]


@dataclass(frozen=True)
class Template:
    """Sample places, their printed brightness, and what turns brightness residuals into warp parameters.

    Convention: one marker's samples after another's.
    first (4,): where each marker's samples begin; printed (N,): values of each marker about their mean; gradient:
    gives the gradient (N, 2) of the values, per mm; extent: a unit of the points, mm; drawing: the source of values and
    gradient; smeared: whether motion smear is drawn; solvers: least-squares solvers (8, N) for each set of visible
    markers, made as they are needed.
    """

    points: Array
    marker: NDArray[np.int64]
    values: Array
    first: NDArray[np.int64]
    printed: Array
    gradient: Callable[[], Array]
    extent: float
    px_per_mm: float
    drawing: Drawing
    smeared: bool = False
    solvers: dict[tuple[bool, ...], Array] = field(default_factory=dict)

    @cached_property
    def places(self) -> Places:
        """The points, as a warp takes them."""
        return Places(self.points)

    @cached_property
    def parts(self) -> tuple[slice, ...]:
        """Samples of each marker."""
        return tuple(slice(*ends) for ends in pairwise([*self.first.tolist(), len(self.values)]))

    @cached_property
    def count(self) -> NDArray[np.int64]:
        """Number of samples of each marker, (4,)."""
        return np.diff(np.append(self.first, len(self.values)))

    @cached_property
    def power(self) -> Array:
        """Sum of the squares of `printed` over each marker, (4,)."""
        return np.asarray(np.add.reduceat(self.printed**2, self.first), float)

    @cached_property
    def jacobian(self) -> Array:
        """Change of the values with each of the eight warp parameters, (N, 8).  A smear that is only compared with the
        picture does without it.
        """
        return warp_jacobian(self.points, self.gradient() * self.extent)

    def solver(self, seen: tuple[bool, ...]) -> Array:
        """Least-squares solver (8, N) from residuals to warp parameters, independent of markers' gains and offsets."""
        if seen not in self.solvers:
            used = np.array(seen)[self.marker]
            columns = self.jacobian if all(seen) else np.where(used[:, None], self.jacobian, 0.0)
            free = without_gains(columns, self.marker, self.values)
            self.solvers[seen] = np.asarray(np.linalg.pinv(free.T @ free, hermitian=True) @ free.T)
        return self.solvers[seen]


class TemplatePrinter:
    """Draws templates of one page at any scale; between them it keeps only `work_ns`, the work of all of them."""

    def __init__(self, markers: Markers) -> None:
        self._markers = markers
        centers = np.asarray(markers.centers_mm)
        self.middle = centers.mean(axis=0)
        self.extent = float(np.abs(centers - self.middle).max())
        self.work_ns = 0.0
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
        self._modules = known.markerSize + 2
        self.module_mm = markers.size_mm / self._modules
        self._bits = [
            np.asarray(cv2.aruco.generateImageMarker(known, identity, self._modules)) > 127 for identity in markers.ids
        ]

    def draw(self, px_per_mm: float) -> Template:
        """The four markers at about one sample per pixel, blurred like a picture."""
        return self._sampled(px_per_mm, self._drawn(px_per_mm), None)

    def smeared(self, template: Template, smear_mm: Array) -> Template:
        """The same template, smeared by motion.

        Parameters: smear_mm (4, 2): displacement of each marker during the exposure, page mm.
        """
        steps = _smear_steps(float(np.linalg.norm(smear_mm, axis=1).max()), template.drawing.pitch_mm)
        self.work_ns += len(template.values) * (SMEARED_NS + SMEAR_STEP_NS * steps)
        return self._sampled(template.px_per_mm, template.drawing, smear_mm)

    def _sampled(self, px_per_mm: float, drawing: Drawing, smear_mm: Array | None) -> Template:
        pitch_mm, pictures = drawing.pitch_mm, drawing.pictures
        side = pictures[0].shape[0]
        offsets = (np.arange(FINE // 2, side, FINE) + 0.5 - side / 2) / FINE * pitch_mm
        x, y = (part.ravel() for part in np.meshgrid(offsets, offsets))
        smears = np.zeros((4, 2)) if smear_mm is None else smear_mm
        sampled, owner = [], []
        for index, smear in enumerate(smears):
            # Beyond the white border lies the grating; a smear mixes it in.
            length = float(np.linalg.norm(smear)) / self.module_mm
            margin = min(BORDER_MODULES, max(FREE_MODULES - length / 2, 0.0)) * self.module_mm
            kept = np.maximum(np.abs(x), np.abs(y)) < self._markers.size_mm / 2 + margin
            sampled.append(np.column_stack([x[kept], y[kept]]))
            owner.append(np.full(len(sampled[-1]), index))
        points = [places + center for places, center in zip(sampled, self._markers.centers_mm, strict=True)]
        shown = _all_smeared(drawing.pictures, sampled, smears, pitch_mm)
        printed = np.concatenate([part - part.mean() for part in shown])
        return Template(
            points=(np.concatenate(points) - self.middle) / self.extent,
            marker=np.concatenate(owner),
            values=np.concatenate(shown).astype(float),
            first=np.cumsum([0, *(len(part) for part in shown[:-1])]),
            printed=printed,
            gradient=partial(_gradient, drawing, sampled, smears),
            extent=self.extent,
            px_per_mm=px_per_mm,
            drawing=drawing,
            smeared=smear_mm is not None,
        )

    def _drawn(self, px_per_mm: float) -> Drawing:
        size_mm = self._markers.size_mm
        reach_mm = size_mm / 2 + BORDER_MODULES * self.module_mm
        count = int(np.clip(2 * reach_mm * px_per_mm, *SIDE_SAMPLES))
        pitch_mm = 2 * reach_mm / count
        offsets = (np.arange(count * FINE) + 0.5) / FINE * pitch_mm - reach_mm
        column = np.floor((offsets + size_mm / 2) / self.module_mm).astype(int)
        inside = (column >= 0) & (column < self._modules)
        blur = BLUR_PX / px_per_mm / pitch_mm * FINE
        drawn = []
        for bits in self._bits:
            picture = np.ones((count * FINE, count * FINE), np.float32)
            picture[np.ix_(inside, inside)] = bits[np.ix_(column[inside], column[inside])]
            picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), blur, borderType=cv2.BORDER_REPLICATE))
            gradient_y, gradient_x = np.gradient(picture, pitch_mm / FINE)
            drawn.append((picture, gradient_x, gradient_y))
            self.work_ns += DRAWN_NS * picture.size
        return Drawing(pitch_mm, *zip(*drawn, strict=True))


def _gradient(drawing: Drawing, sampled: list[Array], smears: Array) -> Array:
    """Gradient (N, 2) of smeared brightness along x and y, per mm."""
    # Each by itself: OpenCV rounds the places of pictures with two channels to 1/32 pixel.
    both = [_all_smeared(planes, sampled, smears, drawing.pitch_mm) for planes in (drawing.along_x, drawing.along_y)]
    return np.column_stack([np.concatenate(parts) for parts in both]).astype(float)


def _all_smeared(
    pictures: tuple[NDArray[np.float32], ...], sampled: list[Array], smears: Array, pitch_mm: float
) -> list[NDArray[np.float32]]:
    each = zip(pictures, sampled, smears, strict=True)
    return [_smeared(picture, places, smear, pitch_mm) for picture, places, smear in each]


def _smeared(picture: NDArray[np.float32], places: Array, smear: Array, pitch_mm: float) -> NDArray[np.float32]:
    """Mean (N,) of a fine drawing over the page's motion during the exposure."""
    side = picture.shape[0]
    steps = _smear_steps(float(np.linalg.norm(smear)), pitch_mm)
    shares = (np.arange(steps) + 0.5) / steps - 0.5
    # A row for each step: OpenCV reads along rows, and a column of places would cost three times as much.
    fine = FINE / pitch_mm
    x, y = (
        np.subtract(fine * part + (side / 2 - 0.5), (fine * along * shares)[:, None], dtype=float).astype(np.float32)
        for part, along in zip(places.T, smear, strict=True)
    )
    shown = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(np.add.reduce(shown, axis=0) / np.float32(steps), np.float32)


def _smear_steps(smear_mm: float, pitch_mm: float) -> int:
    """Places at which a smeared print is drawn."""
    # The print is blurred already by most of a sample, so a step of a sample leaves no steps to be seen.
    return max(1, math.ceil(smear_mm / pitch_mm))


def warp_jacobian(place: Array, gradient: Array) -> Array:
    """Change of printed brightness with each of the eight warp parameters, (N, 8)."""
    x, y = place.T
    gx, gy = gradient.T
    inward = gx * x + gy * y
    return np.column_stack([gx * x, gx * y, gx, gy * x, gy * y, gy, -inward * x, -inward * y])


def without_gains(columns: Array, marker: NDArray[np.int64], printed: Array) -> Array:
    """What of some columns (N, K) no marker's own gain and offset of brightness could make."""
    free = columns.copy()
    # The samples of a marker follow each other.
    for here in (slice(*ends) for ends in pairwise(np.searchsorted(marker, np.arange(5)))):
        if here.start == here.stop:
            continue
        mine, shown = free[here], printed[here] - printed[here].mean()
        mine -= mine.mean(axis=0)
        power = float(shown @ shown)
        if power > 0:
            mine -= np.outer(shown, shown @ mine) / power
    return free
