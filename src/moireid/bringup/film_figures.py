"""What films say about a badge as it was built: each figure with its error bar, and what to do about it.

Convention: lengths in mm of the printed page, as markers are printed with the lines; gains over the design.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from moireid.asbuilt import AsBuilt, merge
from moireid.badge import Badge, Lens
from moireid.bringup.build_folder import Figure
from moireid.lenticule import view_law
from moireid.sheets import air_mm_per_gain, effective_gap_mm
from moireid.verifier.fringes.signals import Measurement
from moireid.verifier.identity.compare_built import agree
from moireid.verifier.session.result import Report

#: Figures within these need no action: air, mm; twist, degrees; share of the sharpest third harmonic; difference of two
#: films in standard deviations.  Set by hand.
GOOD_AIR_MM, GOOD_TWIST_DEG, GOOD_SHARPNESS, GOOD_SDS = 0.05, 0.3, 0.6, 3.0
#: The pitch that the badge is printed for may be off by this share.
GOOD_PITCH_SHARE = 0.003
#: Error of one film's third harmonic as a share, at least.  Set by hand.
SHARPNESS_SD_SHARE = 0.15


def film_figures(
    reports: Sequence[Report], built: Sequence[AsBuilt], badge: Badge, thickness: Figure | None
) -> list[Figure]:
    """All figures that films show.

    Parameters: built: as-built figures of those that were accepted; thickness: of the sheet, as it was measured without
        the badge; None or without value if it was not.
    """
    films = [report.measurement for report in reports if report.measurement]
    if not built:
        return _focal(reports)
    found = merge(list(built))
    return [
        _gain(found),
        _air(found, badge, thickness),
        _focus(built, badge),
        _twist(found, badge),
        _pitch(films, found, badge),
        *([_repeats(built, badge)] if len(built) > 1 else []),
        *_focal(reports),
    ]


def _gain(found: AsBuilt) -> Figure:
    words = "How far the fringes move, over the design. Any sheet from 0.5 to 1.6 can be enrolled."
    return Figure("Fringe motion", found.gain_ratio, found.gain_sd, "x design", words)


def _air(found: AsBuilt, badge: Badge, thickness: Figure | None) -> Figure:
    """Air under the sheet, from the gain beyond what the sheet's thickness gives."""
    lens = badge.lens
    per_gain_mm = air_mm_per_gain(lens, badge.gratings[0].pitch_mm)
    air_mm, sd_mm = (found.gain_ratio - 1) * per_gain_mm, found.gain_sd * per_gain_mm
    if thickness is None or thickness.sd is None:
        words = (
            f"Motion as if by {air_mm:+.3f} mm of air; so does a sheet of another thickness, and its thickness was not "
            "measured."
        )
        advice = "Measure the sheet with a calliper, and give its thickness."
        return Figure("Air under the sheet", None, None, "mm", words, advice)
    # A sheet that is thicker by its error moves fringes as much more.
    sd_mm = math.hypot(sd_mm, thickness.sd / lens.thickness_mm * per_gain_mm)
    good = air_mm - 2 * sd_mm < GOOD_AIR_MM
    advice = "" if good else "Press the sheet flat, or glue it with clear film; dust and bubbles hold it up."
    words = "From the fringes' motion beyond what the measured thickness gives. Elliptical lenses hide some air."
    return Figure("Air under the sheet", air_mm, sd_mm, "mm", words, advice)


def _focus(built: Sequence[AsBuilt], badge: Badge) -> Figure:
    """Focus, from the third harmonic: lenses that focus on the page show its lines with sharp edges.

    Source: `lenticule.view_law`; Fourier series of lines that cover a share d: |sin 3 pi d| / (3 sin pi d).
    """
    seen = [one.third_harmonic for one in built if one.third_harmonic is not None]
    if not seen:
        words = "The films do not show the fringes' third harmonic."
        return Figure(
            "Focus", None, None, "contrasts", words, "Film nearer, sharp, with fringes that pass by whole turns."
        )
    sharpest = third_harmonic_expected(badge.lens, badge.gratings[0].pitch_mm, badge.gratings[0].cells[0].duty)
    value = float(np.mean(seen))
    scatter = float(np.std(seen, ddof=1)) if len(seen) > 1 else 0.0
    sd = max(scatter, SHARPNESS_SD_SHARE * value) / math.sqrt(len(seen))
    good = value >= GOOD_SHARPNESS * sharpest
    words = f"The fringes' third harmonic; a sheet that focuses on the page shows {sharpest:.2f}."
    advice = "" if good else "Sheets for flip pictures are soft on purpose; this one can be enrolled by its films."
    return Figure("Focus", value, sd, "contrasts", words, advice)


def third_harmonic_expected(lens: Lens, pitch_mm: float, duty: float) -> float:
    """The third harmonic of fringes under such a sheet, in contrasts of the first one, seen from the front.

    Parameters: pitch_mm, duty: of the printed lines.
    """
    zero = np.zeros(1)
    first, third = (float(view_law(lens, pitch_mm / k).contrast_kept(zero, zero)[0]) for k in (1, 3))
    return float(abs(math.sin(3 * math.pi * duty)) / (3 * abs(math.sin(math.pi * duty))) * third / max(first, 1e-9))


def _twist(found: AsBuilt, badge: Badge) -> Figure:
    """Twist between sheet and page: phase runs along the lenses by 2 pi a / p_f per mm."""
    degrees, sd = (
        math.degrees(value * badge.lens.pitch_mm / (2 * math.pi)) for value in (found.twist_rad_per_mm, found.twist_sd)
    )
    good = abs(degrees) < GOOD_TWIST_DEG
    advice = "" if good else "Turn the sheet until the fringes are upright, then fix it."
    words = "Between lenses and lines. It is measured at enrolment, so a small one does no harm."
    return Figure("Twist", degrees, sd, "degrees", words, advice)


def _pitch(films: Sequence[Measurement], found: AsBuilt, badge: Badge) -> Figure:
    """Pitch of the lenses on the badge, from the beat with the printed lines: 1/p_f = 1/p_r - f.

    The beat is that for a camera far away, with the design's effective gap.  A sheet that moves fringes `gain` times as
    far adds (gain - 1) g_eff / (D p_r), and an error of the distance D its share of gain g_eff / (D p_r).
    """
    pitch_mm = _reference(badge)
    near, focal_sd = _nearness(films, effective_gap_mm(badge.lens, pitch_mm) / pitch_mm)
    lens_per_mm = 1 / pitch_mm - found.beat_frequency_per_mm + (found.gain_ratio - 1) * near
    sd = math.hypot(found.beat_frequency_sd, found.gain_sd * near, found.gain_ratio * focal_sd * near)
    off = abs(1 / lens_per_mm / badge.lens.pitch_mm - 1)
    words = (
        f"From the beat of {found.beat_period_mm:.1f} mm with the printed lines; the badge is printed for "
        f"{badge.lens.pitch_mm:.4f} mm."
    )
    good = off < GOOD_PITCH_SHARE
    advice = "" if good else "Begin again in another folder, with a new photo of the pitch test under this sheet."
    return Figure("Pitch on the badge", 1 / lens_per_mm, sd / lens_per_mm**2, "mm", words, advice)


def _nearness(films: Sequence[Measurement], beats: float) -> tuple[float, float]:
    """What the camera's nearness adds to the beat frequency, cycles per mm, and the distance's error as a share.

    Parameters: beats: g_eff / p_r.
    """
    if not films:
        return 0.0, 0.0
    distance_mm = float(np.median(np.concatenate([np.abs(one.camera_mm[:, 2]) for one in films])))
    return beats / distance_mm, max(one.camera.focal_sd_px / one.camera.focal_px for one in films)


def _reference(badge: Badge) -> float:
    """Pitch of the reference cell of the first grating with a code, mm."""
    grating = next(one for one in badge.gratings if one.code is not None)
    assert grating.code is not None
    return grating.cells[grating.code.reference_cell].pitch_mm


def _repeats(built: Sequence[AsBuilt], badge: Badge) -> Figure:
    """Whether the first two films agree, over their error bars."""
    pairs = agree(built[1], built[0], badge)
    worst = max(pairs[name].apart_sds or 0.0 for name in ("gain", "offset", "twist"))
    good = worst < GOOD_SDS
    words = "Of gain, offset and twist, the two films' greatest difference over its error bar."
    advice = "" if good else "The sheet moved, or the page bends: fix it, and film again."
    return Figure("Two films differ by", worst, None, "error bars", words, advice)


def _focal(reports: Sequence[Report]) -> list[Figure]:
    """The camera's focal length over the picture's longer side, as the first film gives it; none where no film does."""
    seen = [(report.measurement.camera, report.track.image_px) for report in reports if report.measurement]
    if not seen:
        return []
    camera, long_px = seen[0][0], max(seen[0][1])
    given = "as calibrated" if camera.focal_given else "solved from the badge; a film of the camera chart is finer"
    words = f"Focal length, {given}. Shutter from first to last row: {1000 * camera.shutter_s:.0f} ms."
    advice = "Calibrate the camera by a film of its chart, and save it as camera.yaml." if camera.focal_at_limit else ""
    return [Figure("Camera", camera.focal_px / long_px, camera.focal_sd_px / long_px, "x long side", words, advice)]
