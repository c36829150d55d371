"""The lens profile of a sheet from pictures of its pitch test sheet.

Convention: pitches are in units of the printed page, as markers, bands and lines are printed together.  With the scale
    measured by a ruler (`measured_scale`, printed over true size along x) they are true millimetres.
Source: the matching band has (1 + g_eff/D) / p_r = 1 / p_f (`optics`), with g_eff *traced* (`lenticule`), which is 1 to
    7 % less than the paraxial g/n.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.calibration.bands import BandReading, read_bands
from moireid.calibration.chart_reading import ChartView, check_chart, printed_frequencies
from moireid.errors import MediaError
from moireid.lenticule import view_law
from moireid.profiles import LensProfile, drawn_dot_mm
from moireid.sheets import MM_PER_INCH, sheet_lens

Array = NDArray[np.float64]
#: Least number of bands for a fit.
MIN_BANDS = 5
#: A camera's lens and the registration stretch the picture by this share at most (standard deviation).
STRETCH_SD = 0.005
#: Error of a band in fringes in addition to its noise, from the lens's focus and uneven paper.
FLOOR_FRINGES = 0.004
#: ... and as a share of a dot over the pitch: lines on dots also beat with the dots.  Traced at 300 dpi, bands of 50
#: and 75 lines per inch scatter by 0.1 to 0.25 of it, and not independently.
DOT_SHARE = 0.3
#: Bands that scatter by more, in fringes across a band, do not agree on one lens.
MAX_SCATTER_FRINGES = 0.06
#: Standard deviation of the effective gap, as a share: thickness and index are taken from the sheet's label.
GAP_SD = 0.05
#: A match this many bands beyond the chart is not trusted.
MAX_BEYOND_STEPS = 1.5
#: A twist is estimated only if the phases of the bands' middles agree this well (1: fully).  It must also be small, as
#: a far larger one looks like a small one (`chart_reading.PART_MM`).
MIN_COHERENCE, MAX_TWIST_DEG = 0.8, 2.5


def lens_from_views(
    views: list[ChartView],
    chart: Badge,
    *,
    distance_sd_share: float,
    distance_from: str = "",
    measured_scale: float | None = None,
) -> LensProfile:
    """Find a lens sheet's pitch from pictures of the chart.

    Parameters
    ----------
    views : list of View
        One or more pictures of the chart under the sheet.
    chart : Badge
        The pitch test sheet.
    distance_sd_share : float
        Standard deviation of the views' distance, as a share of it.
    distance_from : str
        Where that distance comes from, for the profile's reader.
    measured_scale : float, optional
        Printed over true size along x, measured with a ruler; None if it was not measured.

    Returns
    -------
    LensProfile
        Of the sheet; `found` says how it came about.

    Raises
    ------
    SpecError
        Where the badge is no pitch test sheet.
    MediaError
        Where too few bands are readable, or they do not agree on one lens, or the sheet is rotated or matches no band.

    Notes
    -----
    Convention: module docstring.
    Source: robust least squares over the bands (Tukey's biweight), see `_agree`.  A twist a between sheet and page
    makes the phases of the bands' middles run down the page by 2 pi sin(a) / p_f per mm, and shortens the frequency
    across it by cos a.
    """
    check_chart(chart)
    readings = read_bands(views, chart)
    across, sd, scatter, used, turn = _one_lens(readings, chart)
    lens_per_mm = math.hypot(across, turn)
    twist_deg = math.degrees(math.asin(turn / lens_per_mm))
    if abs(twist_deg) > MAX_TWIST_DEG:
        raise _too_twisted(f" by {abs(twist_deg):.1f} degrees or more", twist_deg)
    distance_mm = float(np.mean([abs(view.camera_mm[2]) for view in views])) - chart.lens.thickness_mm
    gap_mm = _gap_mm(chart)
    printed = printed_frequencies(chart)
    band = 1 + (across / (1 + gap_mm / distance_mm) - printed[0]) / float(np.diff(printed).mean())
    if not 1 - MAX_BEYOND_STEPS <= band <= len(printed) + MAX_BEYOND_STEPS:
        raise MediaError(
            f"the lens matches no band of this chart: it has about {MM_PER_INCH * lens_per_mm:.2f} lines per inch of "
            "the page; print a chart of more bands, or about another sheet",
            lines_per_inch=MM_PER_INCH * lens_per_mm,
        )
    pitch_mm = 1 / lens_per_mm
    share = math.hypot(sd / across, gap_mm / distance_mm * math.hypot(distance_sd_share, GAP_SD))
    found = {
        "how": "a picture of the chart",
        "pictures": len(views),
        "distance_mm": round(distance_mm, 1),
        "distance_sd_share": distance_sd_share,
        "distance_from": distance_from,
        "matching_band": round(float(band), 3),
        "bands": len(printed),
        "bands_used": used,
        "twist_deg": round(twist_deg, 3),
        "scatter_fringes": round(scatter, 4),
    }
    return _profile(chart, pitch_mm, share * pitch_mm, found, measured_scale)


def _one_lens(readings: list[BandReading], chart: Badge) -> tuple[float, float, float, int, float]:
    """The result of `_agree` for the readable bands, and the twist by `_twist_per_mm`.

    Raises: MediaError if too few bands are readable, or they do not agree on one lens.
    """
    usable = [reading for reading in readings if reading.readable]
    if len(usable) < MIN_BANDS:
        raise MediaError(
            f"{len(usable)} of {len(readings)} bands show fringes that can be read, and at least {MIN_BANDS} must; lay "
            "the sheet over more bands, avoid glare and blur, go nearer, or print a chart of more bands, or "
            "about another sheet",
            readable=len(usable),
        )
    across, sd, scatter, used = _agree(usable, _floor_fringes(chart))
    if used < MIN_BANDS or scatter > MAX_SCATTER_FRINGES:
        raise MediaError(
            f"the bands do not agree on one lens (they scatter by {scatter:.3f} fringes, {MAX_SCATTER_FRINGES:g} at "
            "most are allowed); lay the sheet flat, and give the pitch-test.json of this very chart",
            scatter_fringes=scatter,
        )
    turn = _twist_per_mm(usable)
    if turn is None:
        raise _too_twisted("", None)
    return across, sd, scatter, used, turn


def _too_twisted(by: str, twist_deg: float | None) -> MediaError:
    return MediaError(
        f"the sheet is rotated against the lines{by}, and at most {MAX_TWIST_DEG:g} degrees are allowed; turn it "
        "until the fringes are upright",
        twist_deg=twist_deg,
    )


def _gap_mm(chart: Badge) -> float:
    """Effective gap of the chart's nominal sheet near the axis, traced."""
    pitch_mm = chart.gratings[0].pitch_mm
    return view_law(chart.lens, pitch_mm).effective_gap_mm(pitch_mm)


def _floor_fringes(chart: Badge) -> float:
    """Error of a band in addition to its noise, fringes."""
    dot_mm = drawn_dot_mm(chart)
    return math.hypot(FLOOR_FRINGES, DOT_SHARE * dot_mm / chart.lens.pitch_mm) if dot_mm else FLOOR_FRINGES


def _agree(readings: list[BandReading], floor_fringes: float) -> tuple[float, float, float, int]:
    """The q on which bands agree: its value, its standard deviation, the bands' scatter in fringes, the number used.

    floor_fringes: error of each band in addition to its noise.
    If the picture is stretched by a share e, band k of fringe frequency f_k gives q + e f_k.  So e is estimated
    together with q, with a prior of `STRETCH_SD`.  What counts is where the fringes vanish, not how fine they are.
    """
    q = np.array([reading.lens_per_mm for reading in readings])
    beat = np.array([reading.printed_per_mm for reading in readings]) - q
    length_mm = abs(readings[0].fringes / beat[0])
    sd = np.hypot([reading.sd for reading in readings], floor_fringes / length_mm)
    weight = 1 / sd**2
    value = np.array([np.median(q), 0.0])
    table = np.column_stack([np.ones_like(beat), beat])
    prior = np.diag([0.0, 1 / STRETCH_SD**2])
    robust = np.ones_like(q)
    for _ in range(20):
        apart = (q - table @ value) / sd
        # At least 1: a fit that looks better than its noise is chance.
        scale = max(1.0, 1.4826 * float(np.median(np.abs(apart))))
        robust = np.clip(1 - (apart / (4.685 * scale)) ** 2, 0, None) ** 2
        normal = table.T @ ((weight * robust)[:, None] * table) + prior
        value = np.linalg.solve(normal, table.T @ (weight * robust * q))
    apart = q - table @ value
    used = int((robust > 0.2).sum())
    chi2 = float((weight * robust * apart**2).sum()) / max(float(robust.sum()) - 2, 1.0)
    scatter = 1.4826 * float(np.median(np.abs(apart))) * length_mm
    return float(value[0]), float(np.sqrt(np.linalg.inv(normal)[0, 0] * max(1.0, chi2))), scatter, used


def _twist_per_mm(readings: list[BandReading]) -> float | None:
    """Slope of the phase of the bands' middles down the page, cycles per mm; None if there is no common slope.

    Convention: the phase falls by it; it is the y component of the lens's line frequency.
    Source: the strongest line of the periodogram; slopes beyond half a turn per part of a band are ambiguous.
    """
    places, phases = np.array([part for reading in readings for part in reading.parts]).T
    turns = np.exp(1j * phases)
    most = 0.5 / float(np.diff(np.sort(places)).min())
    paces = np.linspace(-most, most, 4001)
    power = np.abs(np.exp(2j * np.pi * paces[:, None] * places[None, :]) @ turns) / len(turns)
    best = int(np.argmax(power))
    return float(paces[best]) if power[best] >= MIN_COHERENCE else None


def _profile(
    chart: Badge, pitch_mm: float, pitch_sd_mm: float, found: dict[str, Any], measured_scale: float | None
) -> LensProfile:
    """The lens profile; thickness and index are those of the label, as a still chart cannot measure them."""
    scale = measured_scale or 1.0
    nominal = chart.lens
    lens = sheet_lens(scale * pitch_mm, nominal.thickness_mm, nominal.refractive_index)
    unit = {"unit": "printed page"} if measured_scale is None else {"unit": "true mm", "measured_scale": measured_scale}
    name = f"{MM_PER_INCH / lens.pitch_mm:.3f} LPI, sold as {MM_PER_INCH / nominal.pitch_mm:.4g}"
    return LensProfile(name, lens, scale * pitch_sd_mm, found | unit | {"chart": chart.name})
