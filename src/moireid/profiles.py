"""Lens sheets and printers, by their names on the command line: those sold (`sheets`), and measured sheets.

A label gives nominal figures; a real sheet's pitch differs by some tenths of a percent, and its thickness by some
percent.  A lens profile is a file with the measured figures of one sheet (`moireid calibrate` writes it), and can be
used in place of a label.  Enrolment as built still measures each badge.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.files import whole_file
from moireid.sheets import ACRYLIC_INDEX, MM_PER_INCH, PRODUCTS, sheet_lens

#: Family of a pitch test sheet's grating: uniform bands and no code.
CHART_FAMILY = "pitch-test"
#: Format of a lens profile's file.
PROFILE_FORMAT, PROFILE_KIND = 1, "lens-profile"
#: Largest relative standard deviation of a measured pitch; a worse one would be no better than a label.
MAX_PITCH_SD_SHARE = 0.02
#: Bounds of a lens profile, mm and 1: 10 to 200 lines per inch, and thickness and index of glass or plastic sheets.
PROFILE_LIMITS = {"pitch_mm": (0.127, 2.54), "thickness_mm": (0.05, 20.0), "refractive_index": (1.2, 2.0)}
#: How lines are put on a page; see `fabrication.page`.
FORMS = ("dots", "vector")
#: Paper sizes, width by height, mm (ISO 216; ANSI A).
PAPERS_MM = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}


@dataclass(frozen=True)
class Printer:
    """A printer: dots per inch."""

    dpi: int

    @property
    def dot_mm(self) -> float:
        """Width of one dot, mm."""
        return MM_PER_INCH / self.dpi


@dataclass(frozen=True)
class LensProfile:
    """One measured lens sheet; pitch_sd_mm: standard deviation of its pitch; found: how it was measured, for people."""

    name: str
    lens: Lens
    pitch_sd_mm: float
    found: dict[str, Any] = field(default_factory=dict, hash=False)

    def to_json(self) -> str:
        """The text of a lens profile's file, with a final newline."""
        lens = {key: getattr(self.lens, key) for key in ("kind", *PROFILE_LIMITS)}
        document = {
            "format": PROFILE_FORMAT,
            "kind": PROFILE_KIND,
            "name": self.name,
            "lens": lens,
            "pitch_sd_mm": self.pitch_sd_mm,
            "from": self.found,
        }
        return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def lens_named(label: str) -> Lens:
    """The lens sheet of that label, or of the lens profile at that path, which ends in .json.

    Raises: SpecError, with the known labels, if there is none; and as `load_lens_profile`.
    """
    if label.lower().endswith(".json"):
        return load_lens_profile(Path(label)).lens
    product = PRODUCTS.get(label.lower())
    if product is None:
        raise SpecError(
            f"lens {label!r} is not known; choose one of {', '.join(PRODUCTS)}, or give the .json file of a lens "
            "profile"
        )
    return sheet_lens(product.pitch_mm, product.thickness_mm, product.refractive_index)


def sheet_of_thickness(lens: Lens, thickness_mm: float) -> Lens:
    """The same lens sheet of another thickness, as a calliper reads it.

    Raises: SpecError for a thickness that is no sheet's.
    """
    return sheet_lens(lens.pitch_mm, thickness_mm, lens.refractive_index)


#: Thicknesses of acrylic sheet that can serve as a mask's gap, mm.
GAP_RANGE_MM = (0.5, 6.0)


def mask_named(label: str, gap_mm: float) -> Lens:
    """A line mask of a lens sheet's pitch, printed on clear film over an acrylic spacer of that thickness.

    Convention: half of it is open, which passes half of the light and gives the most contrast.
    Raises: SpecError for an unknown label, or a gap for which there is no spacer.
    """
    if not GAP_RANGE_MM[0] <= gap_mm <= GAP_RANGE_MM[1]:
        raise SpecError(
            f"a gap of {gap_mm:g} mm is no acrylic spacer's; give {GAP_RANGE_MM[0]:g} to {GAP_RANGE_MM[1]:g} mm"
        )
    return Lens("mask", lens_named(label).pitch_mm, gap_mm, ACRYLIC_INDEX)


#: An array's lenses are this much flatter than they must be to meet; half spheres would lose the light of the corners.
ARRAY_RADIUS_RATIO = 1.2


def array_named(label: str) -> Lens:
    """An array of round lenses (fly's-eye sheet) of a lens sheet's pitch, focused on its back.

    Convention: as thick as the sheet of that label, or thicker, as round lenses of a thin sheet would not meet.
    Raises: SpecError for an unknown label.
    """
    sheet = lens_named(label)
    least_mm = ARRAY_RADIUS_RATIO * math.sqrt(0.5) * sheet.pitch_mm
    thinnest_mm = least_mm * sheet.refractive_index / (sheet.refractive_index - 1)
    return Lens("array", sheet.pitch_mm, max(sheet.thickness_mm, round(thinnest_mm, 2)), sheet.refractive_index)


def load_lens_profile(path: Path) -> LensProfile:
    """Read a lens profile.  Raises: SpecError if the file is missing or no lens profile, or has impossible figures."""
    advice = "give a file that moireid calibrate wrote"
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SpecError(f"lens profile {path} cannot be read ({error.strerror}); {advice}") from error
    except (ValueError, RecursionError) as error:
        raise SpecError(f"lens profile {path} is not JSON ({error}); {advice}") from error
    if not isinstance(document, dict) or document.get("kind") != PROFILE_KIND:
        raise SpecError(f'{path} is no lens profile, which would say "kind": "{PROFILE_KIND}"; {advice}')
    if document.get("format") != PROFILE_FORMAT:
        raise SpecError(
            f"{path}: format: {document.get('format')!r} is not known to this version; it reads format {PROFILE_FORMAT}"
        )
    entry = document.get("lens")
    if not isinstance(entry, dict) or entry.get("kind") != "lenticular":
        raise SpecError(f"{path}: lens.kind must be lenticular, the only front layer that is printed for; {advice}")
    figures = {
        key: _figure(entry.get(key), f"{path}: lens.{key}", low, high) for key, (low, high) in PROFILE_LIMITS.items()
    }
    most_mm = MAX_PITCH_SD_SHARE * figures["pitch_mm"]
    pitch_sd_mm = _figure(document.get("pitch_sd_mm"), f"{path}: pitch_sd_mm", 0.0, most_mm)
    name, found = document.get("name"), document.get("from", {})
    if not isinstance(name, str) or not isinstance(found, dict):
        raise SpecError(f"{path}: name must be text and from an object; {advice}")
    return LensProfile(name, sheet_lens(**figures), pitch_sd_mm, found)


def save_lens_profile(profile: LensProfile, path: Path) -> None:
    """Write a lens profile, whole or not at all.  Raises: SpecError if it could not be read back."""
    with whole_file(path) as temporary:
        temporary.write_text(profile.to_json(), encoding="utf-8")
        if load_lens_profile(temporary) != profile:
            raise SpecError(f"lens profile {path} does not read back as it was written; report this")


def _figure(value: object, where: str, low: float, high: float) -> float:
    """A number of a lens profile.  Raises: SpecError if it is not a number or out of bounds."""
    # Python counts True as 1, but JSON's true is not a number.
    number = float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
    if not low <= number <= high:
        raise SpecError(f"{where}={value!r} must be a number from {low:g} to {high:g}; correct it or calibrate anew")
    return number
