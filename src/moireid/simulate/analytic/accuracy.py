"""The difference of two pictures of a badge, and the analytic renderer's error estimated from it.

`difference` gives the error of phase, rad, and of brightness, as a share of the contrast.  Phase is measured as a
reader of the badge would: the cells that hold uniform lines are cut along their lenses into strips of `STRIP_MM`; over
each strip the brightness, less its mean, is projected on the fringes that the law predicts, exp(-i phi), with phi =
`optics.fringe_phase_rad` at each pixel's place on the lens plane, tapered at both ends.  The angle between the
projections of two pictures is the strip's phase error; a strip whose fringes keep less than `LEAST_CONTRAST` has none.
What is reported is the root mean square over all strips of the frame.

`estimate_error` works before a film is made.  Some frames are rendered twice: once with the film's rays, and once with
four times as many.  Rays are spread so evenly that four times as many have a third of the error or less.  So the
difference is the error of the coarse picture to within some tenths.  The estimate is its RMS over the frames' strips.
`moireid bench simulate` compares it with an independent tracer.  The estimate does not include how far the model is
from a real sheet.  `cheapest` finds the cheapest setting whose estimate is small enough.

Convention: pictures are `BoardRadiance`s of the same frame; radiance error is relative to paper less ink.
Source: demodulation at a known carrier; the carrier's own error cancels between two pictures of one frame.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid import optics
from moireid.errors import SpecError
from moireid.simulate.analytic.analytic_renderer import RAYS, AnalyticRenderer, BoardRadiance
from moireid.simulate.analytic.traced_page import printed_scales
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
class PixelStrip:
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


def difference(pairs: list[tuple[PixelStrip, Array, Array]], contrast: float) -> Difference:
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


def brightness(picture: BoardRadiance, strip: PixelStrip) -> Array:
    """A rendered picture's radiance at a strip's pixels (N,), which must lie within it."""
    return picture.radiance[strip.rows - picture.top, strip.columns - picture.left].astype(float)


def strips_of(scene: Scene, instant: Instant, box: tuple[int, int, int, int]) -> list[PixelStrip]:
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
                found += [PixelStrip(place, rows + box[1], columns + box[0], weight) for rows, columns, weight in cut]
    return found


def compare(scene: Scene, instant: Instant, one: BoardRadiance, other: BoardRadiance) -> Difference:
    """The `difference` of two pictures of one frame on all strips in the first one's box."""
    height, width = one.radiance.shape
    strips = strips_of(scene, instant, (one.left, one.top, one.left + width, one.top + height))
    pairs = [(strip, brightness(one, strip), brightness(other, strip)) for strip in strips]
    return difference(pairs, scene.paper - scene.ink)


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


#: The finer picture has this many times the rays, across and down.
FINER = (2, 2)
#: Settings from cheap to dear; each takes about twice the time of the one before it.
LADDER = ((4, 1), (8, 1), RAYS, (32, 1), (32, 2), (64, 2), (64, 4), (128, 4))


@dataclass(frozen=True)
class Estimate:
    """Expected errors of a setting: phase, RMS over strips, None where no strip shows fringes; and brightness, RMS as
    a share of the contrast.

    rays: of a pixel, across and down; segments: of each lens, None where the lenses are true cylinders.
    """

    rays: tuple[int, int]
    phase_rad: float | None
    image: float
    segments: int | None = None


def estimate_error(scene: Scene, instants: Sequence[Instant], rays: tuple[int, int] = RAYS) -> Estimate:
    """Estimate the error of a setting on some frames of a film.

    Convention: module docstring.  Source: the difference from four times the rays.
    Raises: SpecError as `AnalyticRenderer`.
    """
    coarse = AnalyticRenderer(scene, rays=rays)
    fine = AnalyticRenderer(scene, rays=(rays[0] * FINER[0], rays[1] * FINER[1]))
    phases, images = [], []
    for instant in instants:
        one, other = coarse.render(instant), fine.render(instant)
        if one is None or other is None:
            continue
        found = compare(scene, instant, one, other)
        images.append(found.image)
        if found.phase_rad is not None:
            phases.append(found.phase_rad)
    return Estimate(rays, _rms(phases), _rms(images) or 0.0)


def cheapest(scene: Scene, instants: Sequence[Instant], error_rad: float) -> Estimate:
    """The cheapest setting whose estimated phase error is at most `error_rad`.

    Convention: a film without fringes has no phase error, and gets the cheapest setting.
    Source: `estimate_error` up the `LADDER`.
    Raises: SpecError where even the dearest setting has a larger error.
    """
    return first_within(
        (estimate_error(scene, instants, rays) for rays in LADDER),
        error_rad,
        f"is not met even by {math.prod(LADDER[-1])} rays a pixel",
        "come nearer",
    )


def first_within(estimates: Iterable[Estimate], error_rad: float, unmet: str, advice: str) -> Estimate:
    """The first estimate, from cheap to dear, with at most that phase error.  Raises: SpecError where none has."""
    for found in estimates:
        if found.phase_rad is None or found.phase_rad <= error_rad:
            return found
    raise SpecError(
        f"a phase error of {error_rad:g} rad {unmet} (estimated {found.phase_rad:.2g} rad); give a larger error_rad=, "
        f"or {advice}",
        estimated_rad=found.phase_rad,
    )


def _rms(figures: Sequence[float]) -> float | None:
    """Root mean square; None of an empty list."""
    return math.sqrt(sum(figure * figure for figure in figures) / len(figures)) if figures else None
