"""Lens sheets as they are sold, and how far fringes can move under one.

A label names one product: lines per inch and thickness as its seller lists them.  These are nominal figures.  The law
of a sheet is *traced* (`lenticule`), and what one built badge really does is measured when it is enrolled.

What sellers do not list is the radius of the lenses.  A sheet for print focuses on its back, so R = g (n - 1) / n; the
thinnest sheets of a pitch would need steeper lenses for that than any that are known, and focus a little behind it.

Sellers state a viewing angle, and no radius can be solved for it: fringes repeat after the angle of `repeat_deg`, and
whatever radius is in focus, that is wider than the angle stated (`angles_in_focus_deg`; a test holds it).  So a stated
angle names a product, and says nothing of its law.

Source of the table: `materials.toml` has each sheet with its sources.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.lenticule import view_response
from moireid.materials import materials

MM_PER_INCH = 25.4
#: Radius over pitch of the steepest lenses that are known: 190.5 um, of an example 336.65 um wide, 457 um thick, index
#: 1.557 (Wikipedia, Lenticular lens, before 2010 Lenticular optics), over the 1/75 inch of the sheet sold so thick; and
#: of lenses that are almost half circles, than which none can be steeper.
LEAST_RADIUS_RATIO, HALF_CIRCLE_RATIO = 0.5625, 0.5025
#: A lens that keeps this share of contrast counts as in focus.
IN_FOCUS = 0.9
#: Refractive index of PMMA, of which a mask's spacer is.
ACRYLIC_INDEX = 1.49
#: The sheet of boards, and of what is printed or measured where none is named (docs/decisions/printing.md).
DEFAULT_LENS = "62lpi-27mil"


def sheet_lens(pitch_mm: float, thickness_mm: float, refractive_index: float) -> Lens:
    """The lens of a sheet, focused on its back as nearly as its pitch lets it.

    Convention: a sheet that can focus has the default radius of `badge.Lens`; a thinner one the least that is known.
    Raises: SpecError where the thickness is no sheet's.
    Source: module docstring.
    """
    if not 0 < thickness_mm < math.inf:
        raise SpecError(f"thickness_mm={thickness_mm:g} is no sheet's; give what a calliper reads, in mm")
    least_mm = LEAST_RADIUS_RATIO * pitch_mm
    focused_mm = thickness_mm * (refractive_index - 1.0) / refractive_index
    if thickness_mm < least_mm:
        raise SpecError(
            f"thickness_mm={thickness_mm:g} is less than the height of lenses of {pitch_mm:.4g} mm pitch; give what a "
            f"calliper reads, in mm, {least_mm:.2g} or more",
            least_mm=least_mm,
            most_pitch_mm=thickness_mm / LEAST_RADIUS_RATIO,
        )
    radius_mm = None if focused_mm >= least_mm else least_mm
    return Lens("lenticular", pitch_mm, thickness_mm, refractive_index, radius_mm)


#: Lens sheets by their labels: all rows of the table of materials that have one.
PRODUCTS = {
    row.label: sheet_lens(MM_PER_INCH / row.lines_per_inch, row.thick_mm, row.refractive_index)
    for row in materials()
    if row.label and row.lines_per_inch and row.thick_mm and row.refractive_index
}


def repeat_deg(lens: Lens) -> float:
    """The angle from side to side after which lines of a sheet's own pitch look the same again.

    Source: `lenticule.view_response`, as far as its phase turns by a half on each side.
    """
    tangents = np.linspace(0.0, 1.0, 100)
    phase = np.unwrap(np.angle(view_response(lens, lens.pitch_mm, tangents)))
    return 2 * math.degrees(math.atan(np.interp(math.pi, phase - phase[0], tangents)))


def angles_in_focus_deg(lens: Lens) -> tuple[float, float]:
    """Least and greatest `repeat_deg` of a sheet over all radii that keep `IN_FOCUS` of the lines' contrast."""
    sheets = [replace(lens, radius_mm=share * lens.pitch_mm) for share in np.linspace(HALF_CIRCLE_RATIO, 2.0, 40)]
    angles = [repeat_deg(one) for one in sheets if abs(view_response(one, one.pitch_mm, 0.0)) >= IN_FOCUS]
    return min(angles), max(angles)


# --- How far can fringes move under a sheet as sold? -----------------------------------------------------------------

#: Sheets of one nominal pitch: in practice a sheet of 60 lines per inch is placed over lines for 62, and the reverse.
SAME_PITCH_SHARE = 0.04
#: Between sheet and page: at most this much of air, or of clear adhesive (films of 25 to 200 um; index of acrylates).
MOST_GAP_MM = 0.2
#: Radii of one sheet, as multiples of the one that focuses.  Set by hand: sellers do not list them.
RADIUS_RATIOS = (1.0, 1.06, 1.12)
#: The slope of the law near the axis is taken over this view tangent, as `lenticule.ViewLaw.effective_gap_mm` does.
NEAR = 0.05


#: Air for which the gain's slope is traced, mm.
TRIED_AIR_MM = 0.1


def effective_gap_mm(lens: Lens, rear_pitch_mm: float, gap_mm: float = 0.0) -> float:
    """Slope of the law near the axis as a length, with an air gap between sheet and page.

    Convention: as `lenticule.ViewLaw.effective_gap_mm`, which is the same without a gap.
    Source: `lenticule.view_response`; seen from the other side, it is the conjugate.
    """
    turned = np.angle(view_response(lens, rear_pitch_mm, NEAR, air_mm=gap_mm or None) ** 2)
    return float(turned) * rear_pitch_mm / (2 * math.pi * 2 * NEAR)


@cache
def possible_gains(lens: Lens, rear_pitch_mm: float) -> tuple[float, float]:
    """Least and greatest gain that a badge designed for this lens can have under a sheet sold for that pitch.

    Convention: gain is fringe motion over that of the design.
    Returns: two ratios around 1.
    Source: products of that pitch (`PRODUCTS`), and the design's own sheet; the thinnest sheet of that pitch that can
        focus, as not every product is in the table; radii by `RADIUS_RATIOS`; and up to `MOST_GAP_MM` of air.
         An adhesive moves fringes less than air.
    """
    own = effective_gap_mm(lens, rear_pitch_mm)
    sheets = [lens]
    if lens.kind == "lenticular":
        index, pitch = lens.refractive_index, lens.pitch_mm
        thinnest = Lens("lenticular", pitch, HALF_CIRCLE_RATIO * pitch * index / (index - 1.0), index)
        alike = [one for one in PRODUCTS.values() if abs(one.pitch_mm / pitch - 1) <= SAME_PITCH_SHARE]
        focused = [thinnest, *(sheet_lens(pitch, one.thickness_mm, one.refractive_index) for one in alike)]
        sheets += [replace(one, radius_mm=ratio * (one.radius_mm or 0)) for one in focused for ratio in RADIUS_RATIOS]
    bare = [effective_gap_mm(sheet, rear_pitch_mm) for sheet in sheets]
    apart = [effective_gap_mm(sheet, rear_pitch_mm, MOST_GAP_MM) for sheet in sheets]
    return min(bare) / own, max(apart) / own


def air_mm_per_gain(lens: Lens, pitch_mm: float) -> float:
    """Air beneath a sheet, mm, that adds 1 to its gain: fringes move in proportion to the effective gap.

    Parameters
    ----------
    lens : Lens
        The sheet as designed.
    pitch_mm : float
        Pitch of the printed lines, mm.
    """
    own = effective_gap_mm(lens, pitch_mm)
    return own * TRIED_AIR_MM / (effective_gap_mm(lens, pitch_mm, TRIED_AIR_MM) - own)
