"""Frames of a clip, put where another trajectory asks for their views.

Each frame of the forged film shows the nearest frame of the clip, or those on either side cross-faded in coded
brightness.  The badge is taken whole, by the parallaxes that its fields sense; or field by field, each field by its own
parallax as seen from its own middle.  Rows may be stretched, so that their fringes have the spacing of the frame's
distance: one number for each frame, from which each row's follows by its design.

Convention: a place X on the page, counted from where the parallax is taken, shows the phase 2 pi (X f - K u) and a
constant, with the beat f = 1/p - 1/p_f + K/d and K = g_eff/p + g (1/p_f - 1/p), cycles per mm.
Source: the law followed at points of the page, where the markers are, instead of the lens plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from moireid.badge import Badge, Grating
from moireid.frames import Rect
from moireid.layers import Lens
from moireid.lenticule import view_law
from moireid.simulate.forgeries.rear_layer import ShownViews
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Scene
from true_films.clip import Array, Clip, Picture, board_to_page, print_of

Weights = list[tuple[int, float]]
#: The sheet hides or shows this much of the paper next to a field, mm.
RIM_MM = 1.0


def turns_per_view(lens: Lens, pitch_mm: float) -> float:
    """K: by how many fringes a change of the parallax coordinate by 1 moves them, at points of the page."""
    gap = view_law(lens, pitch_mm).effective_gap_mm(pitch_mm)
    return gap / pitch_mm + lens.thickness_mm * (1 / lens.pitch_mm - 1 / pitch_mm)


def beat_per_mm(lens: Lens, pitch_mm: float, distance_mm: float) -> float:
    """f: cycles per mm of page, signed, as seen from a distance."""
    return 1 / pitch_mm - 1 / lens.pitch_mm + turns_per_view(lens, pitch_mm) / distance_mm


def along(grating: Grating) -> int:
    """0 for a field that senses x, 1 for y."""
    return 0 if grating.axis == "x" else 1


def box_px(badge: Badge, rect_mm: Rect, rim_mm: float = 0.0) -> tuple[slice, slice]:
    """Rows and columns of a rectangle of the page in a picture of the board."""
    (step, _, left), (_, _, top), _ = board_to_page(badge)
    x0, y0, x1, y1 = np.array(rect_mm) + rim_mm * np.array([-1, -1, 1, 1])
    (c0, c1), (r0, r1) = ((np.array(ends) - low) / step + 0.5 for ends, low in (((x0, x1), left), ((y0, y1), top)))
    return slice(round(r0), round(r1)), slice(round(c0), round(c1))


def page_mm(badge: Badge, box: tuple[slice, slice]) -> tuple[Array, Array]:
    """Places on the page, x (columns,) and y (rows,), of a part of a picture of the board."""
    (step, _, left), (_, _, top), _ = board_to_page(badge)
    rows, columns = (np.arange(part.start, part.stop) for part in box)
    return left + step * columns, top + step * rows


@dataclass(frozen=True)
class Replay:
    """How a clip of the scene's badge is shown.

    by_field: each field by its own parallax; faded: the frames on either side, instead of the nearest; stretched: rows.
    """

    clip: Clip
    by_field: bool = False
    faded: bool = False
    stretched: bool = False

    def shown(self, scene: Scene, motion: Motion, camera_mm: Array, fps: float) -> ShownViews:
        """What shows it in a film, as `simulate.filming.film` takes it."""
        away = np.abs(camera_mm[:, 2:])
        views = np.column_stack([camera_mm[:, :2] / away, away])
        blank = print_of(scene, float(away.mean()))
        fields = [_Field(scene, grating, self, views) for grating in scene.badge.gratings]

        def picture(frame: int) -> Picture:
            made = blank.copy()
            for field in fields:
                made[field.box] = field.at(frame)
            return np.square(made)

        return ShownViews(camera_mm, camera_mm, picture=picture)


class _Field:
    """One field of the badge in each frame of the forged film."""

    def __init__(self, scene: Scene, grating: Grating, how: Replay, views: Array) -> None:
        badge, axis = scene.badge, along(grating)
        self._clip, self._axis, self._views = how.clip, axis, views
        left, top, right, bottom = badge.outline_mm
        centre = np.array([left + right, top + bottom]) / 2
        rect = grating.rect_mm
        middle = np.array([rect[0] + rect[2], rect[1] + rect[3]]) / 2
        self._from_mm = middle if how.by_field else centre
        senses = [axis] if how.by_field else sorted({along(one) for one in badge.gratings})
        aside = self._from_mm - centre
        wanted, there = (some[:, :2] - aside / some[:, 2:] for some in (views, how.clip.views))
        self._weights = _weights(there[:, senses], wanted[:, senses], faded=how.faded)
        self.box = box_px(badge, rect, RIM_MM)
        self._places = page_mm(badge, self.box)
        self._share = _share(scene, grating, self._places) if how.stretched else None

    def at(self, frame: int) -> Picture:
        """The field's picture."""
        parts = [np.float32(weight) * self._stretched(frame, number) for number, weight in self._weights(frame)]
        return np.asarray(sum(parts[1:], start=parts[0]), np.float32)

    def _stretched(self, frame: int, number: int) -> Picture:
        picture = self._clip.picture(number)
        if self._share is None:
            return picture[self.box]
        nearer = 1 / self._views[frame, 2] - 1 / self._clip.views[number, 2]
        x, y = (some.astype(float) for some in np.meshgrid(*self._places))
        moving = (x, y)[self._axis]
        moving += (moving - self._from_mm[self._axis]) * nearer * self._share
        return looked_up(picture, x - self._places[0][0], y - self._places[1][0], self.box, self._places)


def looked_up(picture: Picture, x: Array, y: Array, box: tuple[slice, slice], places: tuple[Array, Array]) -> Picture:
    """The picture of the board at places x, y, mm from the corner of a box in it."""
    step = float(places[0][1] - places[0][0])
    columns, rows = (x / step + box[1].start).astype(np.float32), (y / step + box[0].start).astype(np.float32)
    return np.asarray(cv2.remap(picture, columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE), np.float32)


def _share(scene: Scene, grating: Grating, places: tuple[Array, Array]) -> Array:
    """K/f of the row at each place of a field: by how much a row is stretched for a change of 1/d, mm."""
    lens, (x, y) = scene.badge.lens, places
    found = np.full((len(y), len(x)), np.nan)
    for cell in grating.cells:
        k = turns_per_view(lens, cell.pitch_mm)
        x0, y0, x1, y1 = cell.rect_mm
        inside = ((y >= y0) & (y < y1))[:, None] & ((x >= x0) & (x < x1))[None]
        found[inside] = k / (1 / cell.pitch_mm - 1 / lens.pitch_mm)
    return np.nan_to_num(found, nan=float(np.nanmedian(found)))


def _weights(there: Array, wanted: Array, *, faded: bool) -> Callable[[int], Weights]:
    """Which pictures make a frame, and with which weights; there (N, K), wanted (T, K)."""
    if not faded or len(there) < 2 or there.shape[1] > 1:
        nearest = np.argmin(np.linalg.norm(wanted[:, None] - there[None], axis=2), axis=1)
        return lambda frame: [(int(nearest[frame]), 1.0)]
    order = np.argsort(there[:, 0])
    rank = np.interp(wanted[:, 0], there[order, 0], np.arange(len(there)))
    before = np.minimum(rank.astype(int), len(there) - 2)
    return lambda frame: [
        (int(order[before[frame]]), float(1 - rank[frame] + before[frame])),
        (int(order[before[frame] + 1]), float(rank[frame] - before[frame])),
    ]
