"""Ray tracing through one lens of a sheet, and the table of the phase law made from it.

A pixel that covers many lenses sees the mean of the printed lines over all rays through one lens. For lines of pitch
p_r that mean turns the fringe phase by arg H and dims the fringe by |H|, where H = <exp(2 pi i s / p_r)> and s is how
far along x from the lens's axis each ray lands.  `view_response` traces H; `ViewLaw` tabulates it over view directions,
because a verifier needs it at every frame.  Rays are traced by `trace_mm`.
Less light passes a lens's flank than its top (Fresnel's equations), so rays are weighted by the share that passes: this
changes the phase by 0.003 rad at a view tangent of 0.3 and by 0.02 at 0.7, and makes the law 1 % flatter beyond.
A sheet is glued to the page, or laid on it.  Under one that is laid on is a thin gap of air, and rays that meet it
beyond the critical angle, asin(1/n) to the sheet's normal, never see the page: the back mirrors them.  The flank of a
lens leans by b = asin(p_f / 2R) and turns its rays the most, so the first are lost from b + asin(n sin(asin(1/n) - b))
across the lenses on (30 degrees for 62 lines an inch); from there on only a part of each lens works.
Not modelled here: light that leaves a lenticule through its neighbour's flank after refraction (beyond 65 degrees), the
directions of the lamp, and what the back mirrors of rays short of the critical angle.

Convention: the apex plane is z = 0, z into the page; lens 0 has its axis at x = 0.
Source: intersection with a cylinder and Snell's law in three dimensions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from moireid import optics
from moireid.badge import Lens

Array = NDArray[np.float64]
#: Rays across one lenticule.  The flanks make the response a step function of the ray, so the error falls as one over
#: the number of rays: 1e-3 rad at 512 (a test checks it).
RAYS = 512
#: The table covers view tangents up to this (63 degrees); up to here all light leaves through its own lens.  Frames
#: beyond it are not used (`verifier.fringes.strip_law.within_law`).
MAX_TANGENT = 2.0


def trace_mm(
    lens: Lens, start_mm: Array, tan_x: Array, tan_y: Array, air_mm: float | None = None
) -> tuple[Array, Array]:
    """Where rays that cross the apex plane of a sheet at start_mm land on the page, and their incidence on the lens.

    Parameters: start_mm, tan_x, tan_y: arrays that broadcast together; start 0 is the axis of lenticule 0; air_mm:
        between sheet and page, None where it is glued.
    Convention: as `moireid.optics`; the place is an absolute x, mm; NaN for a ray that misses the lens, or that the
        back mirrors.
    Returns: mm and the cosine of incidence, of the broadcast shape.
    Source: intersection with a circular cylinder and Snell's law in three dimensions.  The nearer root is computed as c
        / (-b + sqrt(b^2 - a c)), which avoids cancellation near the apex.
    """
    assert lens.radius_mm is not None
    # Where a ray meets the lens does not depend on its slope along the lens.
    start, tan_x = np.broadcast_arrays(start_mm, tan_x)
    radius, pitch = lens.radius_mm, lens.pitch_mm
    index = np.asarray(np.round(start / pitch))
    hit_x = np.zeros(start.shape)
    depth = np.full(start.shape, np.nan)
    # An oblique ray may pass over its own lenticule and meet the next; three steps reach past 75 degrees.
    for step in range(4):
        left = np.isnan(depth)
        own_tan, own_index = tan_x[left], index[left] + step * np.sign(tan_x[left])
        offset = start[left] - own_index * pitch
        a, b, c = 1.0 + own_tan**2, offset * own_tan - radius, offset**2
        root = b**2 - a * c
        nearer = c / (-b + np.sqrt(np.maximum(root, 0.0)))
        x = offset + own_tan * nearer
        found = (root >= 0) & (np.abs(x) <= pitch / 2 * (1 + 1e-12))
        hit_x[left] = np.where(found, x, 0.0)
        depth[left] = np.where(found, nearer, np.nan)
        index[left] += step * np.sign(own_tan) * found
    normal_x, normal_depth = hit_x / radius, (depth - radius) / radius
    length = np.sqrt(1.0 + tan_x**2 + tan_y**2)
    cosine = -(tan_x * normal_x + normal_depth) / length
    n = lens.refractive_index
    bend = cosine / n - np.sqrt(1.0 - (1.0 - cosine**2) / n**2)
    refracted_x = tan_x / length / n + bend * normal_x
    refracted_depth = 1.0 / length / n + bend * normal_depth
    landed = index * pitch + hit_x + refracted_x / refracted_depth * (lens.thickness_mm - depth)
    if air_mm is not None:
        leaving = 1.0 - n**2 * (1.0 - refracted_depth**2)
        landed = landed + air_mm * n * refracted_x / np.sqrt(np.where(leaving > 0, leaving, np.nan))
    return landed, cosine


def critical_tangent(lens: Lens) -> float:
    """The view's tangent from which on air beneath the sheet hides a part of each lens; infinite for a mask.

    Source: module docstring.  A view that is slanted along the lenses, too, is slanted more before it loses a ray.
    """
    if lens.radius_mm is None:
        return math.inf
    flank, critical = math.asin(min(lens.pitch_mm / 2 / lens.radius_mm, 1.0)), math.asin(1 / lens.refractive_index)
    leaning = max(lens.refractive_index * math.sin(critical - flank), -1.0)
    return math.tan(max(flank + math.asin(leaning), 0.0))


def view_response(
    lens: Lens,
    rear_pitch_mm: float,
    tan_x: ArrayLike,
    tan_y: ArrayLike = 0.0,
    *,
    air_mm: float | None = None,
    rays: int = RAYS,
    fresnel: bool = True,
) -> NDArray[np.complex128]:
    """Complex response H of the front layer to printed lines of pitch p_r, for each view direction.

    Parameters: tan_x, tan_y broadcast together; air_mm: as in `trace_mm`; rays: number across one lenticule; fresnel:
        weight rays by the share that passes the lens; otherwise all count alike, as in the analytic renderer.
    Convention: arg H is the phase that the view adds at a lens's axis (for a mask, in the middle of an opening);
        it rises with tan_x.  |H| is the contrast kept, 1 for a perfect focus.
    Returns: complex array of the broadcast shape.
    Source: average over the rays of one pitch, uniform on the apex plane, weighted by `optics.passed_share`. A lens at
        k p_f then shows phase 2 pi k p_f / p_r + arg H, which is the beat.  For a mask: Snell's slab, and the
        fundamental of its openings.
    """
    tan_x, tan_y = np.asarray(tan_x, float), np.asarray(tan_y, float)
    if lens.kind == "mask":
        assert lens.open_fraction is not None
        shift = optics.slab_shift_mm(lens.thickness_mm, lens.refractive_index, tan_x, tan_y) + (air_mm or 0.0) * tan_x
        # numpy's sinc is sin(pi x)/(pi x): the first Fourier coefficient of the openings over their mean.
        return np.asarray(np.exp(2j * math.pi * shift / rear_pitch_mm) * np.sinc(lens.open_fraction))
    across = ((np.arange(rays) + 0.5) / rays - 0.5) * lens.pitch_mm
    landed, cosine = trace_mm(lens, across, tan_x[..., None], tan_y[..., None], air_mm)
    passed = optics.passed_share(lens.refractive_index, cosine) if fresnel else np.ones_like(cosine)
    light = passed * np.exp(2j * math.pi * landed / rear_pitch_mm)
    seen = light.sum(axis=-1) if air_mm is None else np.nansum(light, axis=-1)
    return np.asarray(seen / passed.sum(axis=-1))


def bumps_of(table: Array) -> Array:
    """Sizes of the cubic B-splines through a table (R, C), mirrored at its borders, with one more on each side.

    Source: a bump is 2/3 at its place and 1/6 at the next ones.
    """
    for _ in range(2):
        count = len(table)
        share = 2 / 3 * np.eye(count) + 1 / 6 * (np.eye(count, k=1) + np.eye(count, k=-1))
        share[0, 1] = share[-1, -2] = 1 / 3
        table = np.asarray(np.linalg.solve(share, table).T, float)
    return np.pad(table, 1, mode="reflect")


def between_bumps(bumps: Array, row: Array, column: Array) -> Array:
    """Values of a table at places that broadcast together, from 0 to its last row and column; bumps: as `bumps_of`."""
    (first, highs), (left, widths) = _near(row, bumps.shape[0] - 3), _near(column, bumps.shape[1] - 3)
    flat, corner = bumps.ravel(), first * bumps.shape[1] + left
    found = np.zeros(corner.shape)
    for i, high in enumerate(highs):
        places = corner + i * bumps.shape[1]
        part = widths[0] * flat[places]
        for j, width in enumerate(widths[1:], start=1):
            part += width * flat[places + j]
        found += high * part
    return found


def _near(place: Array, last: int) -> tuple[NDArray[np.int64], tuple[Array, ...]]:
    """The first of the four bumps over each place, and the height of each of them there."""
    before = np.clip(place.astype(int), 0, last - 1)
    t = place - before
    square, cube = t * t, t * t * t
    first, third = 1 / 6 - t / 2 + square / 2 - cube / 6, 1 / 6 + (t + square - cube) / 2
    return before, (first, 2 / 3 - square + cube / 2, third, cube / 6)


@dataclass(frozen=True)
class ViewLaw:
    """Tabulated phase and contrast of one front layer over lines of one pitch, against the view tangents.

    Convention: as `view_response`.  Beyond `MAX_TANGENT` the value at the table's edge is used.
    """

    tan_x: Array
    tan_y: Array
    phase: Array
    contrast: Array

    def phase_rad(self, tan_x: ArrayLike, tan_y: ArrayLike = 0.0) -> Array:
        """Unwrapped phase added by the view; inputs broadcast together; rad."""
        return self._look_up(self._phase_bumps, tan_x, tan_y)

    def contrast_kept(self, tan_x: ArrayLike, tan_y: ArrayLike = 0.0) -> Array:
        """|H|, 0 to 1; inputs broadcast together."""
        return self._look_up(self._contrast_bumps, tan_x, tan_y)

    def effective_gap_mm(self, rear_pitch_mm: float) -> float:
        """Slope of the law near the axis as a length: phase = 2 pi g_eff tan_x / p_r.  Fitted over +-0.05."""
        near = 0.05
        return float(self.phase_rad(near) - self.phase_rad(-near)) * rear_pitch_mm / (2 * math.pi * 2 * near)

    @cached_property
    def _phase_bumps(self) -> Array:
        return bumps_of(self.phase)

    @cached_property
    def _contrast_bumps(self) -> Array:
        return bumps_of(self.contrast)

    def _look_up(self, bumps: Array, tan_x: ArrayLike, tan_y: ArrayLike) -> Array:
        """Cubic look-up; the table is even in tan_y, so only the magnitude is used."""
        x, y = np.asarray(tan_x, float), np.abs(np.asarray(tan_y, float))
        row = (np.clip(x, self.tan_x[0], self.tan_x[-1]) - self.tan_x[0]) / (self.tan_x[1] - self.tan_x[0])
        column = np.clip(y, 0.0, self.tan_y[-1]) / (self.tan_y[1] - self.tan_y[0])
        return between_bumps(bumps, row, column)


#: Laws that this process has traced or received; the oldest are dropped first.
_KNOWN: dict[tuple[Lens, float, bool], ViewLaw] = {}
MOST_KNOWN = 256


def view_law(lens: Lens, rear_pitch_mm: float, *, laid: bool = False) -> ViewLaw:
    """The law of `lens` over lines of that pitch as a table, traced once per process.

    Parameters: laid: whether the sheet is only laid on, over air much thinner than itself; else it is glued.
    Convention: as `view_response`.  Up to `critical_tangent` both laws are the same.
    Source: `trace_law`.
    """
    law = _KNOWN.get((lens, rear_pitch_mm, laid))
    if law is None:
        law = trace_law(lens, rear_pitch_mm, laid=laid)
        know_law(lens, rear_pitch_mm, law, laid=laid)
    return law


def know_law(lens: Lens, rear_pitch_mm: float, law: ViewLaw, *, laid: bool = False) -> None:
    """Store a law of this lens and pitch that another process has traced."""
    while len(_KNOWN) >= MOST_KNOWN:
        _KNOWN.pop(next(iter(_KNOWN)), None)
    _KNOWN[lens, rear_pitch_mm, laid] = law


def trace_law(lens: Lens, rear_pitch_mm: float, *, laid: bool = False) -> ViewLaw:
    """Trace the law of `lens` over lines of that pitch into a table; 0.05 s.

    Parameters: laid: as in `view_law`.
    Convention: as `view_response`.
    Source: `view_response` on a grid of 161 by 17 tangents up to `MAX_TANGENT`; the phase is unwrapped from the axis.
    """
    half = np.linspace(0.0, MAX_TANGENT, 81)
    tan_y = np.linspace(0.0, MAX_TANGENT, 17)
    # A few views at a time, whose rays fit into a processor's cache.
    air_mm, parts = 0.0 if laid else None, np.split(half, 27)
    traced = [view_response(lens, rear_pitch_mm, few[:, None], tan_y, air_mm=air_mm) for few in parts]
    response = np.concatenate(traced)
    # At tan_x = 0 the symmetric lens adds a phase of 0 or pi; unwrapping starts there, and the rest is mirrored.
    angle = np.angle(response)
    # An unfocused lens may give pi there; it must not jump between +pi and -pi along tan_y.
    angle[0] = np.unwrap(angle[0])
    phase = np.unwrap(angle, axis=0)
    odd = phase[1:] - phase[0]
    phase = np.vstack([phase[0] - odd[::-1], phase])
    contrast = np.abs(np.vstack([response[:0:-1], response]))
    tan_x = np.linspace(-MAX_TANGENT, MAX_TANGENT, 161)
    return ViewLaw(tan_x, tan_y, phase, contrast)
