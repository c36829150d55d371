"""The thickness of a lens sheet, from a film of the pitch test sheet that moves sideways.

The motion of the fringes is proportional to the sheet's effective optical gap (`sheets.effective_gap_mm`).  So the gain
of a film, judged as that of an enrolment, gives the thickness.  Air or adhesive under the sheet counts as thickness
too, as it should for a badge that is built the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import msgspec
import numpy as np

from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.files import AnyPath
from moireid.profiles import LensProfile
from moireid.question import KnownCamera, Question
from moireid.sheets import effective_gap_mm, sheet_lens
from moireid.verifier.session.film import verify
from moireid.verifier.video import Progress

#: Thicknesses that are tried, over that of the label.
TRIED_RATIOS = np.linspace(0.45, 2.2, 141)


@dataclass(frozen=True)
class Thickness:
    """Of a sheet, mm, with its standard deviation; why: the reason where a film does not give it, and mm is None."""

    mm: float | None = None
    sd_mm: float = 0.0
    why: str = ""


def thickness_from_film(
    film: AnyPath,
    chart: Badge,
    matching_band: float,
    *,
    camera: KnownCamera | None = None,
    progress: Progress | None = None,
) -> Thickness:
    """The thickness of the sheet on a chart, whose pitch is that of a band; bands between two are fractions.

    Convention: in true mm, as the index is that of the label.
    Raises: MediaError where the file is no film.
    Source: module docstring; `verifier.decision.sheet_gain`.
    """
    chart = with_fringes(chart, matching_band)
    found = verify(film, Question(chart, camera=camera, enrolling=True), progress=progress).invariant
    if found.verdict != "accept" or found.gain_ratio is None or found.gain_sd is None:
        codes = ", ".join(reason.code for reason in found.reasons if reason.level in ("fail", "undecided"))
        return Thickness(
            why=f"The bands' fringes show no clear motion ({codes}): film for ten seconds, moving 20 cm to both sides."
        )
    thickness_mm = thickness_of_gain(chart, found.gain_ratio)
    if thickness_mm is None:
        return Thickness(why=f"No sheet of this pitch moves fringes {found.gain_ratio:.2f} times as far.")
    return Thickness(thickness_mm, thickness_mm * found.gain_sd / found.gain_ratio)


def with_fringes(chart: Badge, matching_band: float) -> Badge:
    """The chart with those bands that have a whole fringe or more: the others have no phase, but brightness alone."""
    grating = chart.gratings[0]
    lines = [(grating.rect_mm[2] - grating.rect_mm[0]) / cell.pitch_mm for cell in grating.cells]
    here = np.interp(matching_band - 1, range(len(lines)), lines)
    cells = tuple(cell for cell, many in zip(grating.cells, lines, strict=True) if abs(many - here) >= 1)
    return replace(chart, gratings=(replace(grating, cells=cells),))


def thickness_of_gain(chart: Badge, gain: float) -> float | None:
    """The thickness of a sheet that moves fringes that many times as far as the chart's nominal one, mm.

    Returns: None where no sheet does.
    Source: `sheets.effective_gap_mm` of sheets that focus as well as they can; linear between the thicknesses tried.
    """
    lens, pitch_mm = chart.lens, chart.gratings[0].pitch_mm
    own = effective_gap_mm(lens, pitch_mm)
    tried, gains = [], []
    for ratio in TRIED_RATIOS:
        try:
            sheet = sheet_lens(lens.pitch_mm, float(ratio) * lens.thickness_mm, lens.refractive_index)
        except SpecError:
            continue
        tried.append(sheet.thickness_mm)
        gains.append(effective_gap_mm(sheet, pitch_mm) / own)
    # Near the thinnest sheet that focuses the gain hardly changes, and the trace is a little uneven.
    rising = np.maximum.accumulate(gains)
    if not rising[0] <= gain <= rising[-1]:
        return None
    return float(np.interp(gain, rising, tried))


def with_thickness(profile: LensProfile, found: Thickness) -> LensProfile:
    """The profile with the measured thickness; unchanged where the film does not give it."""
    if found.mm is None:
        return profile
    lens = sheet_lens(profile.lens.pitch_mm, round(found.mm, 4), profile.lens.refractive_index)
    noted = {"thickness_from": "a film of the chart", "thickness_sd_mm": round(found.sd_mm, 4)}
    return msgspec.structs.replace(profile, lens=lens, found=profile.found | noted)
