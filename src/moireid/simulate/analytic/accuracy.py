"""How far one picture of a badge is from another: fringe phase in radians, brightness as a share of the contrast.

Phase is measured as a reader of the badge would: the cells that hold uniform lines are cut along their lenses into
strips of `STRIP_MM`; over each strip the brightness, less its mean, is projected on the fringes that the law predicts,
exp(-i phi), with phi = `optics.fringe_phase_rad` at each pixel's place on the lens plane, tapered at both ends.  The
angle between the projections of two pictures is the strip's phase error; a strip whose fringes keep less than
`LEAST_CONTRAST` has none.  What is reported is the root mean square over all strips of the frame.

Convention: pictures are `Rendered`s of the same frame; radiance error is relative to paper less ink.
Source: demodulation at a known carrier; the carrier's own error cancels between two pictures of one frame.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid import optics
from moireid.simulate.analytic.page import printed_scales
from moireid.simulate.analytic.renderer import Rendered
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Height of a strip along the lenses; a row of a badge's cells is about as high.
STRIP_MM = 8.0
#: Pixels nearer than this to a cell's border also see the neighbour's lines.
BORDER_MM, BORDER_PX = 0.6, 1.5
#: A strip must show this amplitude of the fringes, as a share of the contrast, to have a phase.
LEAST_CONTRAST = 0.05
#: A strip has at least this many pixels.
LEAST_PIXELS = 24


@dataclass(frozen=True)
class Strip:
    """Pixels of a frame (N,) by row and column, and the weight that projects their brightness on the fringes."""

    grating: int
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    weight: NDArray[np.complex128]


@dataclass(frozen=True)
class Difference:
    """Of two pictures: RMS phase error over the strips, None where no strip shows fringes; RMS radiance error as a
    share of the contrast; and the number of strips."""

    phase_rad: float | None
    image: float
    strips: int


def difference(pairs: list[tuple[Strip, Array, Array]], contrast: float) -> Difference:
    """Compare brightness (N,) at each strip's pixels in two pictures; the second one counts as the truth.

    Parameters: contrast: paper less ink; where it is 0, as without light, brightness errors are not divided by it.
    Convention: module docstring; a pixel that is NaN in either picture is left out.
    Source: module docstring.
    """
    phases, squares, pixels = [], 0.0, 0
    for strip, one, other in pairs:
        known = np.isfinite(one) & np.isfinite(other)
        if np.count_nonzero(known) < LEAST_PIXELS:
            continue
        a, b, weight = one[known], other[known], strip.weight[known]
        squares, pixels = squares + float(((a - b) ** 2).sum()), pixels + len(a)
        size = np.abs(weight)
        first, second = (np.sum((v - np.average(v, weights=size)) * weight) / size.sum() for v in (a, b))
        if min(abs(first), abs(second)) > LEAST_CONTRAST * contrast:
            phases.append(np.angle(first / second))
    phase = float(np.sqrt(np.mean(np.square(phases)))) if phases else None
    return Difference(phase, math.sqrt(squares / pixels) / (contrast or 1.0) if pixels else 0.0, len(phases))


def brightness(picture: Rendered, strip: Strip) -> Array:
    """A rendered picture's radiance at a strip's pixels (N,), which must lie within it."""
    return picture.radiance[strip.rows - picture.top, strip.columns - picture.left].astype(float)


def strips_of(scene: Scene, instant: Instant, box: tuple[int, int, int, int]) -> list[Strip]:
    """All strips of a frame in a box (left, top, right, bottom) px of its picture.

    Convention: places are those of the lens plane, seen from the middle of first and last row's pose.
    """
    x, y = _places(scene, instant, box)
    found = []
    for place, grating in enumerate(scene.badge.gratings):
        frame, (scales, shear) = scene.badge.frame_of(grating), printed_scales(scene, grating)
        across, along = np.moveaxis(frame.directions(np.stack([x, y], axis=-1)), -1, 0)
        across, along = across + shear[0] * along, along + shear[1] * across
        eye = float(frame.directions(instant.shown_from_mm[:2])[0]), float(instant.shown_from_mm[2])
        for number, cell in enumerate(grating.cells):
            if grating.code is None or grating.code.roles[number] != "phase":
                rect = np.array(scene.own_rect_mm(grating, cell.rect_mm)) * np.tile(scales, 2)
                sides = rect[[0, 2]], rect[[1, 3]]
                carrier = _carrier(scene, cell.pitch_mm * scales[0], across, eye)
                cut = _cut(across, along, sides, carrier)
                found += [Strip(place, rows + box[1], columns + box[0], weight) for rows, columns, weight in cut]
    return found


def _places(scene: Scene, instant: Instant, box: tuple[int, int, int, int]) -> tuple[Array, Array]:
    """Where on the lens plane each pixel of a box looks, x and y (rows, columns)."""
    camera = scene.camera
    columns, rows = np.meshgrid(np.arange(box[0], box[2]), np.arange(box[1], box[3]))
    share = (rows - (camera.height - 1) / 2) / camera.height + 0.5
    turn = instant.first.rotation[0] * (1 - share[..., None, None]) + instant.last.rotation[0] * share[..., None, None]
    centre = instant.first.camera_mm[0] * (1 - share[..., None]) + instant.last.camera_mm[0] * share[..., None]
    sight = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(camera.matrix).T
    way = np.einsum("...ji,...j->...i", turn, sight)
    fall = (-scene.height_mm - centre[..., 2]) / way[..., 2]
    return centre[..., 0] + fall * way[..., 0], centre[..., 1] + fall * way[..., 1]


def _carrier(scene: Scene, pitch_mm: float, across: Array, eye_mm: tuple[float, float]) -> Array:
    """Phase of the fringes of lines of that printed pitch at places of the lens plane, seen from (across, depth)."""
    lens, build = scene.lens, scene.build
    depth = -eye_mm[1] - lens.thickness_mm
    return optics.fringe_phase_rad(
        across,
        (across - eye_mm[0]) / depth,
        front_pitch_mm=lens.pitch_mm * build.lens_scale,
        rear_pitch_mm=pitch_mm,
        effective_gap_mm=optics.paraxial_effective_gap_mm(lens),
    )


def _cut(
    across: Array, along: Array, sides: tuple[Array, Array], carrier: Array
) -> list[tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.complex128]]]:
    """Rows, columns and weights of one uniform cell's strips; sides: its printed extent across and along, board mm."""
    footprint = max(float(np.abs(np.diff(along, axis=k)).max(initial=0.0)) for k in (0, 1))
    edge = BORDER_MM + BORDER_PX * footprint
    (low, high), (begin, end) = (side + np.array([edge, -edge]) for side in sides)
    if high <= low or end <= begin:
        return []
    cuts = np.linspace(begin, end, max(1, round((end - begin) / STRIP_MM)) + 1)
    # A squared half cosine over the span: then the strip's ends and its mean hardly matter.
    taper = np.sin(math.pi * np.clip((across - low) / (high - low), 0, 1)) ** 2
    strips = []
    for first, last in itertools.pairwise(cuts):
        rows, columns = np.nonzero((across > low) & (across < high) & (along > first) & (along < last))
        if len(rows) >= LEAST_PIXELS:
            strips.append((rows, columns, (taper * np.exp(-1j * carrier))[rows, columns]))
    return strips
