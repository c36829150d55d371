"""The fabricate suite: pages by form and resolution, read back, and photographs of the pitch test.

Pages are painted by Poppler and Ghostscript where they are installed (`raster`); each painted edge is compared with its
place, and the identity is read from the raster alone.
"""

from __future__ import annotations

import time
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from moireid.designer import Order, design_badge
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import FORMS
from moireid_lab.bench.fabricate.calibration import calibration_figures
from moireid_lab.bench.fabricate.painted import painted_figures
from moireid_lab.bench.fabricate.raster import RASTERS, paint
from moireid_lab.bench.part import OWN, RIGHT, WRONG, Asked, Part, Row, interleaved

DPI = (600, 1200, 2400)
#: Greying takes ten times as long as one bit a dot, so it is not done at the highest resolution.
GREY_DPI = 1200
#: A photograph is right whose pitch is within so many of its own standard deviations.
MOST_SDS = 3.0


def judged(job: tuple[str, int, int] | int, folder: Path) -> Row:
    """A page, or the photograph of that number."""
    return photograph_row(job) if isinstance(job, int) else page_row(*job, folder)


def page_row(form: str, dpi: int, number: int, folder: Path) -> Row:
    """Seconds and size of one page, and what rasters of its own resolution make of it; 64 and 128 bits in turn."""
    pdf, rng = folder / f"{form}_{dpi}_{number}.pdf", np.random.default_rng([dpi, number])
    # 128 bits are smaller cells, which are read to 2.2 m.
    request = Order("Bench", lens="50lpi", printer_dpi=dpi, form=form, range_m=(0.8, 2.0))
    badge = design_badge(request, rng.bytes(8 * (1 + number % 2)))
    clock = time.perf_counter()
    write_badge_pdf(badge, pdf)
    row: Row = {"kind": f"{form}, {dpi} dpi", "write s": time.perf_counter() - clock, "kB": pdf.stat().st_size / 1e3}
    seen: list[dict[str, Any]] = []
    for raster in RASTERS:
        page = None if raster == "poppler-grey" and dpi > GREY_DPI else paint(pdf, raster, dpi)
        if page is not None:
            seen.append(painted_figures(page, badge))
    pdf.unlink()
    read, wrong = (sum(one[name] for one in seen) for name in ("read", "wrong"))
    errors = np.concatenate([one["errors"] for one in seen]) if seen else np.zeros(1)
    row |= {"edges off, dots RMS": float(np.sqrt(np.mean(errors**2))), "worst": float(np.abs(errors).max())}
    row |= {"pitch off, ppm": 1e6 * max((abs(pitch) for one in seen for pitch in one["pitches"]), default=0.0)}
    return row | {"answers": {"page": (read, len(seen) - read - wrong, wrong)}}


def photograph_row(number: int) -> Row:
    """One photograph of a pitch test sheet."""
    (found,) = calibration_figures(count=1, seed=number)["rows"]
    row: Row = {"kind": "pitch test sheet", "why": []}
    if found["in_sd"] is None:
        return row | {"answers": {"pitch": (0, 1, 0)}}
    answer = RIGHT if abs(found["in_sd"]) <= MOST_SDS else WRONG
    return row | {"answers": {"pitch": answer}, "pitch off, %": found["error_percent"]}


def cases(asked: Asked) -> dict[str, Any]:
    """Pages of each form and resolution, and ten times as many photographs."""
    count = asked.clips or 2
    pages = {f"{form}, {dpi} dpi|{k}": (form, dpi, k) for k, form, dpi in product(range(count), FORMS, DPI)}
    return interleaved(pages, {f"photograph {k}": k for k in range(10 * count)})


QUESTIONS = {
    "page": "Is a page's identity read from its raster, at 600 to 2400 dpi?",
    "pitch": "Is a sheet's pitch read from a photograph of the pitch test within three error bars?",
}
PART = Part(QUESTIONS, {"page": "no film: painted pages", "pitch": OWN}, cases, judged)
