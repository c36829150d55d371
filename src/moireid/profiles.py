"""Lens sheets and printers, by their names on the command line: those sold (`sheets`), and measured ones.

A label gives nominal figures; a real sheet's pitch differs by some tenths of a percent, and its thickness by some
percent.  A lens profile is a file with the measured figures of one sheet (`moireid calibrate` writes it), and can be
used in place of a label.  Enrolment as built still measures each badge.  A printer profile is the same of a printer: by
how much it widens lines, and its scale.  Such a file is kept for this user under a bare name, too.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, Struct

from moireid.badge import Badge, Lens
from moireid.errors import SpecError
from moireid.files import AnyPath, planned, read_regular, whole_file
from moireid.models import check_format, parse_json, read_model
from moireid.sheets import ACRYLIC_INDEX, MM_PER_INCH, PRODUCTS
from moireid.user_settings import data_folder, nearest

#: Family of a pitch test sheet's grating: uniform bands and no code.
CHART_FAMILY = "pitch-test"
#: Format of a lens profile's file, and of a printer profile's.
PROFILE_FORMAT = 1
#: Largest relative standard deviation of a measured pitch; a worse one would be no better than a label.
MAX_PITCH_SD_SHARE = 0.02
#: Dots per inch of a page that states none, and of printers.
DEFAULT_DPI, DPI_RANGE = 1200, (72, 9600)
#: How lines are put on a page; see `fabrication.page`.
FORMS = ("dots", "vector")
Profile = TypeVar("Profile", "LensProfile", "PrinterProfile")
#: Pitch, mm, thickness, mm, and refractive index of sheets of glass or plastic, least and most.
SHEET_RANGES = ((0.127, 2.54), (0.05, 20.0), (1.2, 2.0))
#: Paper sizes, width by height, mm (ISO 216 and 217; ANSI A); from SRA3 on, those of print shops.
PAPERS_MM = {
    "a4": (210.0, 297.0),
    "letter": (215.9, 279.4),
    "a3": (297.0, 420.0),
    "sra3": (320.0, 450.0),
    "a2": (420.0, 594.0),
    "a1": (594.0, 841.0),
}


def find_dpi(badge: Badge) -> int:
    """Dots per inch of the printer that a badge or a pitch test is drawn for.

    Raises: SpecError where the badge states a resolution that no printer has.
    """
    dpi = (badge.print or {}).get("dpi", DEFAULT_DPI)
    low, high = DPI_RANGE
    if not (isinstance(dpi, int | float) and low <= dpi <= high):
        raise SpecError(f"print.dpi={dpi!r} of badge {badge.name!r} is no printer's; correct it to {low} to {high}")
    return int(dpi)


def find_dot_mm(badge: Badge) -> float:
    """Width of one dot of that printer, mm."""
    return MM_PER_INCH / find_dpi(badge)


def drawn_dot_mm(badge: Badge) -> float | None:
    """Width of the printer's dots on which lines are drawn, mm; None where they are drawn free of them.

    Raises: SpecError as `find_dpi`, or for a form that is none of `FORMS`.
    """
    form = (badge.print or {}).get("form", FORMS[0])
    if form not in FORMS:
        raise SpecError(f"form {form!r} of the page is not known; choose one of {', '.join(FORMS)}")
    return None if form == "vector" else find_dot_mm(badge)


class LensProfile(Struct, frozen=True, tag_field="kind", tag="lens-profile", rename={"found": "from"}):
    """One measured lens sheet; pitch_sd_mm: standard deviation of its pitch; found: how it was measured, for people."""

    name: str
    lens: Lens
    pitch_sd_mm: Annotated[float, Meta(ge=0)]
    found: dict[str, Any] = {}

    def __post_init__(self) -> None:
        """Raises: ValueError for what is no sheet of 10 to 200 lenses to the inch, or no better known than a label."""
        lens, most_mm = self.lens, MAX_PITCH_SD_SHARE * self.lens.pitch_mm
        figures = (lens.pitch_mm, lens.thickness_mm, lens.refractive_index)
        if lens.kind != "lenticular" or any(
            not low <= value <= high for value, (low, high) in zip(figures, SHEET_RANGES, strict=True)
        ):
            raise ValueError(f"holds a lens that no lens sheet has: {figures}; allowed are {SHEET_RANGES}")
        if self.pitch_sd_mm > most_mm:
            raise ValueError(f"pitch_sd_mm={self.pitch_sd_mm:g} must be a number from 0 to {most_mm:g}")


def lens_named(label: str) -> Lens:
    """The lens sheet of that label, or of the lens profile at that path, which ends in .json.

    Raises: SpecError, with the known labels, if there is none; and as `load_lens_profile`.
    """
    if label.lower().endswith(".json"):
        return load_lens_profile(Path(label)).lens
    if label.lower() not in PRODUCTS:
        raise SpecError(
            f"lens {label!r} is not known; choose one of {', '.join(PRODUCTS)}, or give the .json file of a lens "
            "profile"
        )
    return PRODUCTS[label.lower()]


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


def load_lens_profile(path: AnyPath) -> LensProfile:
    """Read a lens profile.  Raises: SpecError if the file is missing or no lens profile, or has impossible figures."""
    return _read_profile(path, f"lens profile {path}", LensProfile)


def _read_profile(path: AnyPath, source: str, model: type[Profile]) -> Profile:
    """The content of a profile's file.  Raises: SpecError."""
    advice = "correct it, or give a file that moireid calibrate wrote"
    try:
        text = read_regular(path).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise SpecError(f"{source} cannot be read ({reason}); {advice}") from error
    document = parse_json(text, source, advice)
    check_format(document, PROFILE_FORMAT, source)
    return read_model(document, model, source, advice)


def profile_document(profile: LensProfile | PrinterProfile) -> dict[str, Any]:
    """What the file of a profile holds."""
    # Figures may be numpy's.
    return {"format": PROFILE_FORMAT, **msgspec.to_builtins(profile, enc_hook=float)}


def save_profile(profile: Profile, path: AnyPath) -> None:
    """Write a profile, whole or not at all.  Raises: SpecError if it could not be read back."""
    text = json.dumps(profile_document(profile), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
        if _read_profile(temporary, f"profile {path}", type(profile)) != profile:
            raise SpecError(f"profile {path} does not read back as it was written; report this")


class PrinterProfile(Struct, frozen=True, tag_field="kind", tag="printer-profile", rename={"found": "from"}):
    """One printer with its paper.

    ink_growth_um, ink_growth_sd_um: by how much it widens a line, both edges together, and its standard deviation; None
    where that was not measured.  measured_scale: measured over true size along x and y, None likewise; found: how it
    was measured, for people.
    """

    name: str
    dpi: Annotated[int, Meta(ge=DPI_RANGE[0], le=DPI_RANGE[1])]
    ink_growth_um: Annotated[float, Meta(ge=-100, le=150)] | None = None
    ink_growth_sd_um: Annotated[float, Meta(ge=0, le=100)] | None = None
    measured_scale: tuple[Annotated[float, Meta(ge=0.9, le=1.1)], Annotated[float, Meta(ge=0.9, le=1.1)]] | None = None
    found: dict[str, Any] = {}

    @property
    def words(self) -> str:
        """What pages drawn for the printer have by it."""
        scale = "true size" if self.measured_scale is None else "1/{:g} wide, 1/{:g} high".format(*self.measured_scale)
        growth = "as designed" if self.ink_growth_um is None else f"{self.drawn_growth_um:.0f} um narrower"
        return f"{self.name}: lines {growth}, {self.dpi} dpi, {scale}"

    @property
    def drawn_growth_um(self) -> float:
        """The growth that pages are drawn for: none where it was not measured, or where lines become narrower."""
        return max(self.ink_growth_um or 0.0, 0.0)


def printer_file(name: AnyPath) -> Path:
    """Where a printer's profile is: at a path; of a bare name, among what is kept for this user.

    Raises: SpecError for a bare name where the user has no home folder.
    """
    path = Path(name)
    if path.suffix.lower() == ".json" or len(path.parts) > 1:
        return path
    if (data := data_folder()) is None:
        raise SpecError(f"printer {str(path)!r} can be kept by name only in a home folder; give a .json file")
    return data / "printers" / f"{path}.json"


def keep_printer(printer: PrinterProfile, name: AnyPath, *, overwrite: bool = False) -> PrinterProfile:
    """Write a printer's profile as `printer_file` has it; returned with that name.

    Raises: SpecError where there is one, and it is not to be replaced.
    """
    path = printer_file(name)
    planned([path], overwrite=overwrite)
    kept = msgspec.structs.replace(printer, name=path.stem)
    save_profile(kept, path)
    return kept


def load_printer_profile(name: AnyPath) -> PrinterProfile:
    """Read a printer profile by its path or name.

    Raises: SpecError if it is missing or none, or has impossible figures.
    """
    path = printer_file(name)
    if path != Path(name) and not path.exists():
        kept = sorted(one.stem for one in path.parent.glob("*.json"))
        raise SpecError(
            f"no printer is kept as {str(name)!r}{nearest(str(name), kept)}; kept: {', '.join(kept) or 'none yet'}; "
            "first-badge and calibrate measure a printer, and keep it by a name"
        )
    return _read_profile(path, f"printer profile {path}", PrinterProfile)
