"""Reading a pitch test sheet: from pictures of it to the lens's line frequency that each band tells.

1. Find the chart's markers, shrink a fine picture, register the page.
2. Find where the camera was.
3. Read the brightness profiles of each band in parts, lens ribs and printed lines blurred away.
4. Search the one lens frequency that explains the fringes of all bands at once.
5. Refine it band by band.

Convention: page millimetres; the phase of band k at the page's point X is 2 pi [(x + s) / p_k - x q], with x where the
sight line crosses the lens plane and s the traced shift (`predict`); q = 1 / p_f is the lens's line frequency, cycles
per mm of the *printed page*.  So a band's sign is known: its fringes are those of one q for all bands.
Source: nonlinear least squares, the linear part solved for exactly (variable projection), as in `fringe`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from moireid.badge import Badge
from moireid.dots import realised
from moireid.errors import MediaError, SpecError
from moireid.lenticule import view_law
from moireid.profiles import CHART_FAMILY, Printer
from moireid.verifier.camera.plane_pose import start_poses
from moireid.verifier.fringes.sinusoid import fit_rows
from moireid.verifier.tracking.markers import FAINT_EVERY, MarkerFinder, marker_corners_mm
from moireid.verifier.tracking.profiles import LINEAR_COUNTS, ProfileReader, counts_of
from moireid.verifier.tracking.registration import PageRegistrar, scale_px_per_mm

Array = NDArray[np.float64]
#: Finer pictures are shrunk to this: no fringe of a chart needs more, and registration expects a sharp edge.
WORK_PX_PER_MM = 3.0
#: Blur before sampling, mm: leaves ribs and lines of 0.3 to 0.7 mm less than 1 %, and a fringe of 10 mm 95 %.
BLUR_MM = 0.5
#: Fewer fringes across a band are not told from shading.
MIN_FRINGES = 1.5
#: A band is readable where its fringes explain this share of what shading leaves, and are so many counts strong.
MIN_EXPLAINED, MIN_CONTRAST = 0.6, 2.5
HARMONICS = 3
#: A band is read in parts about so high: a sheet that lies askew shifts the fringes from part to part, and from how
#: fast it does so the twist is told, up to half a turn a part (4.5 degrees at 50 lines per inch).
PART_MM = 3.0
#: How far beyond its outermost bands a chart is searched, in its own steps.
BEYOND_STEPS = 3.0
#: Focal length over a picture's longer side, from the widest phone lens to the longest tele lens; a distance that asks
#: for another is a slip, such as centimetres for metres.
LENS_RANGE = (0.25, 20.0)
#: Samples two to the millimetre, blurred by `BLUR_MM`: the noise of 2 sqrt(pi) BLUR_MM 2 = 3.5 of them is one.
SAMPLE_INFLATION = 3.5


@dataclass(frozen=True)
class View:
    """One registered picture of the chart: camera centre, page mm (z negative), and a profile a part, (P, N).

    Convention: parts as `parts_of` has them.
    """

    camera_mm: Array
    profiles: Array


@dataclass(frozen=True)
class BandReading:
    """One band: its number, printed frequency 1/p_k, and what it says of the lens.

    lens_per_mm: q, cycles per mm of page; sd: of it, from the picture's noise; fringes: across the band, signed;
    parts: of each part its place across the fringes, mm, and its phase at the field's middle, rad; explained: share of
    the profiles' variance, 0 to 1; readable: fit to be used.
    """

    number: int
    printed_per_mm: float
    lens_per_mm: float
    sd: float
    fringes: float
    parts: tuple[tuple[float, float], ...]
    explained: float
    readable: bool


def check_chart(chart: Badge) -> None:
    """Raise SpecError unless the badge is a pitch test sheet."""
    grating = chart.gratings[0]
    if len(chart.gratings) != 1 or grating.family != CHART_FAMILY or grating.axis != "x" or len(grating.cells) < 3:
        raise SpecError(
            f"{chart.name!r} is no pitch test sheet; give the pitch-test.json that moireid pitch-test wrote"
        )
    if chart.lens.kind != "lenticular":
        raise SpecError("a pitch test sheet of a line mask cannot be read; give one of a lenticular sheet")
    rects, pitches = np.array([cell.rect_mm for cell in grating.cells]), [cell.pitch_mm for cell in grating.cells]
    in_order = np.all(np.diff(pitches) < 0) and np.all(rects[1:, 1] >= rects[:-1, 3] - 1e-6)
    if not in_order or np.ptp(rects[:, [0, 2]], axis=0).max() > 1e-6:
        raise SpecError(
            f"{chart.name!r} is no pitch test sheet, whose bands lie below one another and grow finer downwards; give "
            "the pitch-test.json that moireid pitch-test wrote"
        )


def printed_frequencies(chart: Badge) -> Array:
    """Line frequency of every band as drawn, cycles per mm: on whole dots where the form says so.

    Convention: in the order of the cells, which is that of the bands' numbers.  Source: `dots.realised`.
    """
    grating, dot_mm = chart.gratings[0], printed_dot_mm(chart)
    pitches = np.array([cell.pitch_mm for cell in grating.cells])
    if dot_mm is not None:
        pitches = pitches * [
            1 + realised(grating, cell, chart.lens.pitch_mm, dot_mm).pitch_error for cell in grating.cells
        ]
    return np.asarray(1 / pitches)


def printed_dot_mm(chart: Badge) -> float | None:
    """The printer's dot on whose borders the lines were drawn, None where they were not."""
    told = chart.print or {}
    dpi = told.get("dpi")
    on_dots = told.get("form") in ("dots", "bitmap") and isinstance(dpi, (int, float)) and dpi > 0
    return Printer(int(dpi)).dot_mm if on_dots and dpi is not None else None


def view_chart(luma: NDArray[np.uint8], chart: Badge, *, focal_px: float, distance_mm: float | None = None) -> View:
    """Find the chart in a picture and read its bands.

    Parameters: focal_px: of this picture, for the direction and, unless distance_mm is given, for the distance.
    Convention: distance_mm from the camera to the middle of the sheet; the principal point is the picture's centre.
    Raises: MediaError where the picture does not show the chart; SpecError where no camera could show it so large from
        that distance.
    Source: `markers`, `register`, `plane_pose`, `strips`.
    """
    finder = MarkerFinder(chart.markers)
    # Every third search looks for faded print too.
    start = next((found for _ in range(FAINT_EVERY) if (found := finder.find(luma)) is not None), None)
    if start is None:
        raise MediaError(
            f"the picture does not show this chart (markers {list(chart.markers.ids)} are not found); photograph the "
            "whole board, sharp and evenly lit, and give the pitch-test.json of this very chart"
        )
    corners_mm = marker_corners_mm(chart.markers).reshape(-1, 2)
    middle_mm = corners_mm.mean(axis=0)
    shrink = WORK_PX_PER_MM / scale_px_per_mm(start, middle_mm)
    # Light is averaged, not counts: where a mean runs over ink and paper, that of coded counts is off by a tenth.
    light = LINEAR_COUNTS[luma]
    if shrink < 1:
        light, start = _shrunk(light, start, shrink)
        luma = counts_of(light)
        focal_px *= shrink
    registered = PageRegistrar(chart.markers).register(luma, start)
    if registered is None:
        raise MediaError(
            "the picture's markers do not match the chart's page; photograph it flat, sharp, with all four squares "
            "free, and give the pitch-test.json of this very chart"
        )
    homography = registered.homography
    centre = ((luma.shape[1] - 1) / 2, (luma.shape[0] - 1) / 2)
    mapped = np.column_stack([corners_mm, np.ones(len(corners_mm))]) @ homography.T
    plane = np.column_stack([corners_mm - middle_mm, np.zeros(len(corners_mm))])
    poses = start_poses(plane, (mapped[:, :2] / mapped[:, 2:])[None], focal_px, centre)
    camera = poses.camera[0, int(poses.error_px[0].argmin())]
    if distance_mm is not None:
        guessed_mm = float(np.linalg.norm(camera))
        least, most = (share * max(luma.shape) / focal_px * guessed_mm / 1000 for share in LENS_RANGE)
        if not least <= distance_mm / 1000 <= most:
            raise SpecError(
                f"a distance of {distance_mm / 1000:g} m does not go with the picture, in which a camera shows the "
                f"chart so large from {least:.2g} to {most:.2g} m; give --distance in metres, or leave it out"
            )
        camera = camera * distance_mm / np.linalg.norm(camera)
    camera = camera + np.append(middle_mm, 0.0)
    blur_px = BLUR_MM * scale_px_per_mm(homography, middle_mm)
    smooth = np.asarray(cv2.GaussianBlur(light, (0, 0), blur_px))
    profiles = ProfileReader(parts_of(chart)).read_light(smooth, homography)
    return View(np.asarray(camera, float), np.asarray(profiles, float))


def parts_of(chart: Badge) -> Badge:
    """The chart with every band cut into parts about `PART_MM` high, the same number each, from top to bottom."""
    grating = chart.gratings[0]
    cells = []
    for cell in grating.cells:
        x0, y0, x1, y1 = cell.rect_mm
        count = parts_in_a_band(chart)
        edges = np.linspace(y0, y1, count + 1)
        cells += [replace(cell, rect_mm=(x0, float(edges[k]), x1, float(edges[k + 1]))) for k in range(count)]
    return replace(chart, gratings=(replace(grating, cells=tuple(cells)),))


def parts_in_a_band(chart: Badge) -> int:
    """Number of parts of every band; at least two, or no twist could be told."""
    lowest = min(cell.rect_mm[3] - cell.rect_mm[1] for cell in chart.gratings[0].cells)
    return max(2, round(lowest / PART_MM))


def _shrunk(light: NDArray[np.float32], homography: Array, share: float) -> tuple[NDArray[np.float32], Array]:
    """The picture and its homography, smaller by `share`; areas are averaged, and pixel edges stay in place."""
    size = (round(light.shape[1] * share), round(light.shape[0] * share))
    x, y = size[0] / light.shape[1], size[1] / light.shape[0]
    change = np.array([[x, 0, (x - 1) / 2], [0, y, (y - 1) / 2], [0, 0, 1.0]])
    moved = change @ homography
    return np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_AREA)), moved / moved[2, 2]


class BandFit:
    """Least squares of every band's fringes over all views, for any lens frequency q."""

    def __init__(self, views: list[View], chart: Badge) -> None:
        strips = ProfileReader(parts_of(chart)).strips
        grating, lens = chart.gratings[0], chart.lens
        law = view_law(lens, grating.pitch_mm)
        middle_mm = (grating.rect_mm[0] + grating.rect_mm[2]) / 2
        self.printed, self.views = printed_frequencies(chart), views
        self._parts = parts_in_a_band(chart)
        self.across_mm = np.array([strip.across_mm for strip in strips])
        along = strips[0].along_mm
        self.length_mm = float(along[-1] - along[0])
        self._place = place = (along - along.mean()) / (self.length_mm / 2)
        # Shading: light that falls off to the sides is no fringe.
        self._shading = np.linalg.qr(np.column_stack([np.ones_like(place), place, place**2]))[0].T
        self._lens_x, self._line_x = [], []
        for view in views:
            distance = abs(float(view.camera_mm[2]))
            tangent = (along - view.camera_mm[0]) / distance
            across = (self.across_mm - view.camera_mm[1]) / distance
            shift = law.phase_rad(tangent[None, :], across[:, None]) * grating.pitch_mm / (2 * np.pi)
            self._lens_x.append(along - middle_mm - lens.thickness_mm * tangent)
            self._line_x.append(self._lens_x[-1] + shift)

    def phase_rad(self, view: int, parts: slice, lens_per_mm: float) -> Array:
        """Phase over some parts of one band, (P, N), less the constant that the sheet's place decides."""
        printed = self._line_x[view][parts] * self.printed[parts.start // self._parts]
        return np.asarray(2 * np.pi * (printed - self._lens_x[view] * lens_per_mm))

    def left(self, band: int, lens_per_mm: float, harmonics: int) -> tuple[float, float, NDArray[np.complex128]]:
        """Sums of squares of a band over its parts in all views: left by shading and fringes, and by shading alone.

        Returns also the first view's fringes, one complex figure a part: contrast in counts, and phase at the middle.
        """
        parts = slice(band * self._parts, (band + 1) * self._parts)
        profiles = np.stack([view.profiles[parts] for view in self.views])
        argument = np.stack([self.phase_rad(k, parts, lens_per_mm) for k in range(len(self.views))])
        found = fit_rows(profiles, argument, harmonics, self._shading)
        shaded = profiles - profiles @ self._shading.T @ self._shading
        return float(found.left.sum()), float((shaded**2).sum()), found.harmonics[0, :, 0]

    def search(self, low: float, high: float) -> float:
        """The q whose fringes explain the bands best, all together, to a tenth of a fringe across a band."""
        grid = np.arange(low, high, 0.1 / self.length_mm)
        scores = np.zeros(len(grid))
        for band in range(len(self.printed)):
            for k, q in enumerate(grid):
                # A band near the match looks like shading, and one that is not covered explains nothing.
                if abs(self.printed[band] - q) * self.length_mm >= 0.5:
                    rest, shaded, _ = self.left(band, q, 1)
                    scores[k] += 1 - rest / max(shaded, 1e-9)
        return float(grid[int(np.argmax(scores))])

    def read(self, band: int, near: float) -> BandReading:
        """What one band says of q, near the place that all bands agree on."""
        reach = 0.35 / self.length_mm
        found = float(
            minimize_scalar(
                lambda q: self.left(band, q, HARMONICS)[0],
                bounds=(near - reach, near + reach),
                method="bounded",
                options={"xatol": 1e-4 * reach},
            ).x
        )
        rest, shaded, seen = self.left(band, found, HARMONICS)
        step = 0.05 / self.length_mm
        bend = self.left(band, found - step, HARMONICS)[0] + self.left(band, found + step, HARMONICS)[0] - 2 * rest
        profiles = self._parts * len(self.views)
        free = max((len(self._place) / SAMPLE_INFLATION - 2 * HARMONICS - 4) * profiles, 1.0)
        # Near the least sum of squares S, the variance of q is 2 (S / free) / S'' for independent samples.
        sd = float(np.sqrt(2 * rest / free * step**2 / bend)) if bend > 0 else float("inf")
        explained = 1 - rest / max(shaded, 1e-9)
        parts = slice(band * self._parts, (band + 1) * self._parts)
        fringes = (self.printed[band] - found) * self.length_mm
        readable = (
            abs(fringes) >= MIN_FRINGES
            and explained >= MIN_EXPLAINED
            and float(np.median(np.abs(seen))) >= MIN_CONTRAST
            and abs(found - near) < 0.95 * reach
            and np.isfinite(sd)
        )
        return BandReading(
            band + 1,
            float(self.printed[band]),
            found,
            sd,
            float(fringes),
            tuple(zip(self.across_mm[parts].tolist(), np.angle(seen).tolist(), strict=True)),
            explained,
            bool(readable),
        )


def read_bands(views: list[View], chart: Badge) -> list[BandReading]:
    """Every band of the chart, in their order.

    Convention: module docstring.
    Raises: MediaError where the pictures show no fringes that one lens could make.
    """
    fit = BandFit(views, chart)
    # Bands are few steps apart where a chart has few; three of them beyond either end are searched.
    step = float(np.abs(np.diff(fit.printed)).mean())
    low, high = fit.printed.min() - BEYOND_STEPS * step, fit.printed.max() + BEYOND_STEPS * step
    near = fit.search(float(low), float(high))
    return [fit.read(band, near) for band in range(len(fit.printed))]
