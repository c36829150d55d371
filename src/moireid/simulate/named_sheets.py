"""What a shop, a shelf, the weather or a printer make of a badge's sheet and page, each by its name and magnitude.

thin      75 lines per inch are sold at 0.457 mm as well as at 0.67 mm: the sheet is 0.68 times as thick, and fringes
          move 0.6 to 0.7 times as far
gap       0.1 mm of air between sheet and page, as where a sheet is held at its edges: a fifth more gain at 1 mm
bowed     sheet and page bent together to a radius of 1.5 m, edges away from the camera: 1.8 mm at the board's edge
warm      20 K warmer than when the badge was made: the sheet is wider by 0.14 %, the paper is not
jittered  each lens 0.5 % wider or narrower than the next, by itself, so that places wander over the sheet
fed       the sheet is as designed, but the printer fed the page 0.3 % too far, so that all is higher by that

Source: thicknesses as `moireid.sheets`; growth of PMMA, PETG and PET by 7e-5 a kelvin, makers' data; gap, bow and
jitter set by hand, as what one sees of a sheet in a clip.  Along the feed, Canon's service manual of the GP160 office
copier, p. 2-20, passes a page that is 1 mm too long or short: 0.3 % of A4.
"""

from __future__ import annotations

from dataclasses import replace

from moireid.errors import SpecError
from moireid.simulate.scene import Build

THIN_RATIO = 0.457 / 0.67
GAP_MM, BOW_RADIUS_M, WARMER_K, PITCH_JITTER = 0.1, 1.5, 20.0, 0.005
FED_ASPECT = 1.003
#: Thermal growth of acrylic and polyester sheet, per kelvin.
GROWTH_PER_K = 7e-5


def sheet_named(name: str, build: Build) -> Build:
    """The build with the named sheet in place of its own.

    Convention: what the build says of place and twist, and of the print's width, stays.
    Raises: SpecError for a name that is none.
    Source: module docstring.
    """
    made = {
        "thin": replace(build, thickness_ratio=THIN_RATIO),
        "gap": replace(build, air_gap_mm=GAP_MM),
        "bowed": replace(build, bow_radius_m=BOW_RADIUS_M),
        "warm": replace(build, lens_scale=build.lens_scale * (1 + WARMER_K * GROWTH_PER_K)),
        "jittered": replace(build, pitch_jitter=PITCH_JITTER),
        "fed": replace(build, print_aspect=FED_ASPECT),
    }
    if name not in made:
        raise SpecError(f"sheet {name!r} is not known; choose one of {', '.join(made)}")
    return made[name]
