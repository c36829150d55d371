"""Nominal lens sheets and printers, by the names that the command line takes.

A profile says what the trade's label says; a real sheet's pitch and thickness differ by some tenths of a percent
and some percent, and a badge as built is measured, never assumed.
"""

from __future__ import annotations

from dataclasses import dataclass

from moireid.badge import Lens
from moireid.errors import SpecError

MM_PER_INCH = 25.4
#: How lines are put on a page; see `fabrication.page`.
FORMS = ("dots", "vector", "bitmap")
#: Paper sizes, width by height, mm (ISO 216; ANSI A).
PAPERS_MM = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}

#: Lens sheets by label: lines per inch, thickness in mm, refractive index.  "50lpi" is the published prototype's
#: sheet (Qing et al., Moiré Video Authentication, 2026); the others keep its shape, so that R / pitch is the same.
_SHEETS = {
    "40lpi": (40.0, 1.25, 1.56),
    "50lpi": (50.0, 1.00, 1.56),
    "60lpi": (60.0, 0.84, 1.56),
    "75lpi": (75.0, 0.67, 1.56),
}


@dataclass(frozen=True)
class Printer:
    """A printer as far as the lines care: dots per inch."""

    dpi: int

    @property
    def dot_mm(self) -> float:
        """Width of one dot, mm."""
        return MM_PER_INCH / self.dpi


def lens_named(label: str) -> Lens:
    """The lens sheet of that label.  Raises: SpecError with the known labels where there is none."""
    try:
        lines_per_inch, thickness_mm, refractive_index = _SHEETS[label.lower()]
    except KeyError as error:
        raise SpecError(f"lens {label!r} is not known; choose one of {', '.join(_SHEETS)}") from error
    return Lens("lenticular", MM_PER_INCH / lines_per_inch, thickness_mm, refractive_index)


#: Acrylic sheets as sold: refractive index of PMMA, and thicknesses that can serve as a mask's gap, mm.
ACRYLIC_INDEX = 1.49
GAP_RANGE_MM = (0.5, 6.0)


def mask_named(label: str, gap_mm: float) -> Lens:
    """A line mask of a lens sheet's pitch, printed on clear film over an acrylic spacer of that thickness.

    Convention: half of it is open, which passes half of the light and gives fringes of the most contrast.
    Raises: SpecError for an unknown label, or a gap that no spacer has.
    """
    if not GAP_RANGE_MM[0] <= gap_mm <= GAP_RANGE_MM[1]:
        raise SpecError(
            f"a gap of {gap_mm:g} mm is no acrylic spacer's; give {GAP_RANGE_MM[0]:g} to {GAP_RANGE_MM[1]:g} mm"
        )
    return Lens("mask", lens_named(label).pitch_mm, gap_mm, ACRYLIC_INDEX)


def lens_labels() -> tuple[str, ...]:
    """Every label that `lens_named` knows."""
    return tuple(_SHEETS)
