"""What may stand around a badge in Mitsuba's scene: clear plates of acrylic, and something behind them.

The plates are those of a screwed acrylic stack: a base behind the page, a frame around page and sheet, and a cover with
lips over the sheet's left and right edge.  Screws, their holes and the lanyard's slot are left out, and corners are
square.

Convention: board frame of `motion`, mm: the page at z = 0, the lenses' apexes at -thickness, the camera towards -z.
Between plates, and between them and the badge, is air: two faces at one place would confuse a tracer, and real plates
that touch have a film of air between them too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Rect
from moireid.errors import SpecError

Array = NDArray[np.float64]
#: Refractive index of cast acrylic (PMMA) at 589 nm.
ACRYLIC_INDEX = 1.49
#: Each plate is drawn smaller by this on every side; more than twice what Mitsuba moves a ray off a face (0.008 mm).
AIR_MM = 0.02


@dataclass(frozen=True)
class Plate:
    """A flat plate, sides square to the board: its outline, a window through it or None, and its faces' depths."""

    rect: Rect
    window: Rect | None
    near_mm: float
    far_mm: float


@dataclass(frozen=True)
class Acrylic:
    """Plates around a badge, and the background that is seen beside the board and through them.

    behind: radiance of a plane behind the badge, one figure or a picture (rows, columns) of it, seen upright;
    behind_mm: how far behind the page; width_mm: of the plane; its height is in the picture's proportion.
    """

    plates: tuple[Plate, ...]
    behind: float | Array = field(default=0.25, compare=False)
    behind_mm: float = 300.0
    width_mm: float = 2000.0
    refractive_index: float = ACRYLIC_INDEX

    def __post_init__(self) -> None:
        if not self.plates:
            raise SpecError("acrylic without a plate is none; give one plate or more, or leave acrylic away")
        picture = self.picture
        if picture.ndim != 2 or not picture.size or not (np.isfinite(picture).all() and picture.min() >= 0):
            raise SpecError("a background is one radiance or rows and columns of them, 0 or more; give such figures")
        deepest = max(plate.far_mm for plate in self.plates)
        if not self.behind_mm > deepest or not self.width_mm > 0:
            raise SpecError(
                f"a background {self.width_mm:g} mm wide, {self.behind_mm:g} mm behind the page, does not stand behind "
                f"plates that reach {deepest:g} mm; give a greater behind_mm and a positive width_mm"
            )

    @property
    def picture(self) -> Array:
        """The background as rows and columns of radiance; one of each where it is even."""
        return np.atleast_2d(np.asarray(self.behind, float))

    @property
    def half_mm(self) -> tuple[float, float]:
        """Half width and half height of what the plates cover, counted from the board's centre."""
        rects = np.abs([plate.rect for plate in self.plates])
        return float(rects[:, [0, 2]].max()), float(rects[:, [1, 3]].max())


def plates_around(
    badge: Badge,
    *,
    base_mm: float = 3.0,
    frame_mm: float = 1.0,
    cover_mm: float = 2.0,
    rim_mm: float = 10.0,
    card_mm: float = 0.3,
    clearance_mm: float = 0.1,
    lip_mm: float = 2.0,
) -> tuple[Plate, ...]:
    """The plates of an acrylic stack around a badge.

    Parameters: base_mm, frame_mm, cover_mm, card_mm: thicknesses; rim_mm: how far the plates reach beyond the board and
        the clearance_mm around it; lip_mm: how far the cover reaches over the board's left and right edge.
    Convention: module docstring; the base first, then frame, cover and lips.
    Source: the stack that `moireid print-your-badge` plans, whose contours a test compares.
    """
    x0, y0, x1, y1 = badge.outline_mm
    half, middle = ((x1 - x0) / 2, (y1 - y0) / 2), (y0 + y1) / 2
    window = _rect(half[0] + clearance_mm, half[1] + clearance_mm)
    outer = _rect(half[0] + clearance_mm + rim_mm, half[1] + clearance_mm + rim_mm)
    top = -badge.lens.thickness_mm
    plates = [
        Plate(outer, None, card_mm, card_mm + base_mm),
        Plate(outer, window, card_mm - frame_mm, card_mm),
        Plate(outer, window, top - cover_mm, top),
    ]
    for low, high in _spans(badge) if lip_mm > 0 else []:
        for left, right in ((-window[2], lip_mm - half[0]), (half[0] - lip_mm, window[2])):
            plates.append(Plate((left, low - middle, right, high - middle), None, top - cover_mm, top))
    return tuple(plates)


def _rect(x: float, y: float) -> Rect:
    return -x, -y, x, y


def _spans(badge: Badge) -> list[tuple[float, float]]:
    """Rows of the page that gratings cover; gratings that share rows make one span."""
    spans: list[tuple[float, float]] = []
    for low, high in sorted((grating.rect_mm[1], grating.rect_mm[3]) for grating in badge.gratings):
        if spans and low <= spans[-1][1]:
            spans[-1] = spans[-1][0], max(spans[-1][1], high)
        else:
            spans.append((low, high))
    return spans


def plate_faces(plate: Plate) -> Array:
    """The plate's faces as quadrangles (N, 4, 3), mm, turning so that each looks outwards.

    Raises: SpecError for a plate that the air around it leaves nothing of, or a window that is not within it.
    Convention: module docstring; `AIR_MM` is taken off on every side.
    """
    x0, y0, x1, y1 = (edge + air for edge, air in zip(plate.rect, (AIR_MM, AIR_MM, -AIR_MM, -AIR_MM), strict=True))
    near, far = plate.near_mm + AIR_MM, plate.far_mm - AIR_MM
    if not (x0 < x1 and y0 < y1 and near < far):
        raise SpecError(f"a plate {plate.rect} from {plate.near_mm:g} to {plate.far_mm:g} mm is empty; make it larger")
    outline = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    if plate.window is None:
        return np.concatenate([_lid(outline, near, far), _sides(outline, near, far)])
    u0, v0, u1, v1 = (edge - air for edge, air in zip(plate.window, (AIR_MM, AIR_MM, -AIR_MM, -AIR_MM), strict=True))
    if not (x0 < u0 < u1 < x1 and y0 < v0 < v1 < y1):
        raise SpecError(f"a window {plate.window} is not within its plate {plate.rect}; make it smaller")
    window = np.array([(u0, v0), (u1, v0), (u1, v1), (u0, v1)])
    rings = [
        _lid(np.array([outline[k], outline[(k + 1) % 4], window[(k + 1) % 4], window[k]]), near, far) for k in range(4)
    ]
    return np.concatenate([*rings, _sides(outline, near, far), _sides(window, near, far)[:, ::-1]])


def _lid(corners: Array, near: float, far: float) -> Array:
    """Front and back of four corners that turn from x towards y."""
    front, back = (np.column_stack([corners, np.full(4, depth)]) for depth in (near, far))
    return np.stack([front[::-1], back])


def _sides(corners: Array, near: float, far: float) -> Array:
    """The four walls under corners that turn from x towards y, looking away from their middle."""
    walls = [
        [(*corners[k], near), (*corners[(k + 1) % 4], near), (*corners[(k + 1) % 4], far), (*corners[k], far)]
        for k in range(4)
    ]
    return np.array(walls)
