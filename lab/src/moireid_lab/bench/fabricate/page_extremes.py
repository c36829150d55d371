"""Pages for extreme and impossible wishes: each must be right, or be refused with advice that works.

The advice of a refusal is tried: every figure in the error's `details` is put into the wish, and the next answer is
treated in the same way, until a page is made.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import DesignError, MoireIdError
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import Printer
from moireid_lab.bench.fabricate.painted import painted_figures
from moireid_lab.bench.fabricate.raster import paint

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
#: Advice is followed this many times; no user would try a fifth time.
MOST_STEPS = 4
#: An edge on the border between two dots may be counted to either.
HALF_DOT = 0.5 + 1e-3
#: Painted in a quick run too, up to this resolution.
QUICK_DPI = 600


@dataclass(frozen=True)
class PageCase:
    """A wish, and the sheet that it is for where no label names it: pitch and thickness, mm."""

    name: str
    request: Order = field(default_factory=lambda: Order("Al", lens="50lpi"))
    sheet_mm: tuple[float, float] | None = None


def cases() -> list[PageCase]:
    """The table's rows, in its order."""
    wish = Order("Al", lens="50lpi", range_m=(0.8, 2.5))
    found = [PageCase(f"{dpi} dpi", replace(wish, printer_dpi=dpi)) for dpi in (150, 300, 600, 1200, 2400, 4800)]
    found += [
        PageCase("badge of 30 x 30 mm", replace(wish, size_mm=(30.0, 30.0))),
        PageCase("badge of 30 x 150 mm", replace(wish, size_mm=(30.0, 150.0))),
        PageCase("badge of 300 x 300 mm", replace(wish, size_mm=(300.0, 300.0))),
        PageCase("badge of 200 x 280 mm on letter", replace(wish, size_mm=(200.0, 280.0), paper="letter")),
        PageCase("sheet of 0.2 mm, 50 LPI", wish, (0.508, 0.2)),
        PageCase("sheet of 0.2 mm, 180 LPI", wish, (25.4 / 180, 0.2)),
        PageCase("sheet of 0.2 mm, 180 LPI, 600 dpi", replace(wish, printer_dpi=600), (25.4 / 180, 0.2)),
        PageCase("sheet of 6 mm, 50 LPI", wish, (0.508, 6.0)),
        PageCase("sheet of 6 mm, 10 LPI", wish, (2.54, 6.0)),
    ]
    for dpi in (600, 1200):
        dot, asked = Printer(dpi).dot_mm, replace(wish, printer_dpi=dpi)
        for whole in (0.508 // dot, 0.508 // dot + 1):
            for off in (-1e-3, 1e-3):
                dots = f"{whole + off:.3f} dots of {dpi} dpi"
                found.append(PageCase(f"lens pitch {dots}", asked, ((whole + off) * dot, 1.0)))
                found.append(PageCase(f"printed pitch {dots}", asked, (_lens_for((whole + off) * dot), 1.0)))
    return found


def extreme_rows(*, quick: bool) -> list[dict[str, Any]]:
    """One row for each case: outcome, all refusals, and the figures of the page that was made in the end."""
    if quick:
        return [extreme_row(case, ("poppler",)) for case in cases() if case.request.printer_dpi <= QUICK_DPI]
    return [extreme_row(case) for case in cases()]


def extreme_row(case: PageCase, rasters: tuple[str, ...] = ("poppler", "ghostscript")) -> dict[str, Any]:
    """The outcome of one wish.

    Returns: outcome "right" (all of its edges within half a dot, all markers found, identity read off the raster),
        "refused" where it was refused and following the advice ended in a page that is right, else "wrong"; said: the
        refusals, in order; asked: the wish that was granted.
    """
    row: dict[str, Any] = {"case": case.name}
    with tempfile.TemporaryDirectory() as folder:
        granted, badge, said = settle(case, Path(folder))
        row["said"] = said
        if badge is None:
            return row | {"outcome": "wrong", "asked": None}
        row["asked"] = _in_words(granted)
        pdf = Path(folder) / "badge.pdf"
        write_badge_pdf(badge, pdf)
        right = True
        for raster in rasters:
            page = paint(pdf, raster, granted.request.printer_dpi)
            if page is None:
                continue
            seen = painted_figures(page, badge)
            worst = float(np.abs(seen["errors"]).max())
            right &= worst <= HALF_DOT and seen["read"] and seen["markers"] == 4
            row[raster] = {"worst_dots": worst, "read": seen["read"], "markers": seen["markers"]}
            row[raster]["cell_phase_rad"] = seen["phase_rad"]
    return row | {"outcome": "wrong" if not right else "refused" if said else "right"}


def settle(case: PageCase, folder: Path) -> tuple[PageCase, Badge | None, list[str]]:
    """The wish as granted, its badge (None where advice ran out), and all refusals on the way."""
    said: list[str] = []
    for _ in range(MOST_STEPS):
        try:
            return case, design_badge(_with_lens(case, folder), PAYLOAD), said
        except MoireIdError as error:
            said.append(str(error))
            advised = follow(case, error)
            if advised == case:
                break
            case = advised
    return case, None, said


def follow(case: PageCase, error: MoireIdError) -> PageCase:
    """The wish changed as an error advises; the same one where it advises nothing."""
    details: dict[str, Any] = error.details
    request = case.request
    if isinstance(details.get("least_dpi"), int):
        request = replace(request, printer_dpi=details["least_dpi"])
    if "size_mm" in details:
        request = replace(request, size_mm=details["size_mm"])
    elif "near_m" in details:
        near, far = float(details["near_m"]), float(details["far_m"])
        asked = request.range_m or (near, far)
        wanted = max(near, asked[0]), min(far, asked[1])
        request = replace(request, range_m=wanted if wanted[0] <= wanted[1] else (near, far))
    sheet = case.sheet_mm
    if sheet and "most_pitch_mm" in details:
        # The sheet's thickness is what is extreme, so its pitch gives way.
        sheet = (float(details["most_pitch_mm"]), sheet[1])
    return replace(case, request=request, sheet_mm=sheet)


def _with_lens(case: PageCase, folder: Path) -> Order:
    """The request with the sheet as a lens profile's file, which is not checked here but by who reads it."""
    if case.sheet_mm is None:
        return case.request
    lens = {"kind": "lenticular", "pitch_mm": case.sheet_mm[0], "thickness_mm": case.sheet_mm[1]}
    document = {
        "format": 1,
        "kind": "lens-profile",
        "name": "extreme",
        "lens": lens | {"refractive_index": 1.56},
        "pitch_sd_mm": 0.0,
        "from": {},
    }
    path = folder / "extreme.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return replace(case.request, lens=str(path))


def _lens_for(printed_mm: float) -> float:
    """The lens pitch whose badge has that printed pitch in its reference row; it is nearly proportional."""
    lens_mm = printed_mm / 1.0157
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(6):
            # In vector form, which ignores the printer's dots: with dots, the wish may be refused.
            wish = PageCase("", replace(Order("Al", lens="50lpi"), form="vector"), (lens_mm, 1.0))
            lens_mm *= printed_mm / design_badge(_with_lens(wish, Path(folder)), PAYLOAD).gratings[0].pitch_mm
    if not 0.5 < lens_mm / printed_mm < 1:
        raise DesignError(f"no lens sheet gives a printed pitch of {printed_mm:g} mm")
    return lens_mm


def _in_words(case: PageCase) -> str:
    """The wish in words."""
    request, sheet = case.request, case.sheet_mm
    (wide, high), (near, far) = request.size_mm or (146.0, 160.0), request.range_m or (0.8, 2.5)
    words = f"{wide:g}x{high:g} mm, {near:g}-{far:g} m"
    return f"{words}, {request.printer_dpi} dpi" + (f", lens {sheet[0]:.4f} x {sheet[1]:g} mm" if sheet else "")
