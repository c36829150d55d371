"""The fabricate suite, with its table.

Error against run time of what is printed: pages by form and resolution.

Pages are painted by Poppler and Ghostscript where they are installed (`raster`); each painted edge is compared with its
place, and the identity is read from the raster alone.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from moireid.designer import Order, design_badge
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import FORMS
from moireid_lab.bench.bench_frame import Bench, Row, Wish
from moireid_lab.bench.fabricate.calibration import calibration_figures
from moireid_lab.bench.fabricate.painted import painted_figures
from moireid_lab.bench.fabricate.raster import RASTERS, paint

DPI, QUICK_DPI = (600, 1200, 2400), (600,)
BADGES, QUICK_BADGES = 20, 2
#: Greying takes ten times as long as one bit a dot, so it is done for few badges and not at the highest resolution.
GREY_BADGES, GREY_DPI = 4, 1200
RUNS = 3
#: Photographs of pitch test sheets that are read back.
PHOTOGRAPHS = 40


def rows(wish: Wish) -> Iterator[Row]:
    """Pages, and photographs of the pitch test."""
    quick = wish.quick
    for form in FORMS:
        for dpi in QUICK_DPI if quick else DPI:
            yield page_figures(form, dpi, wish.seed, QUICK_BADGES if quick else BADGES)
    yield {"photographs": calibration_figures(count=2 if quick else PHOTOGRAPHS, seed=wish.seed)}


def page_figures(form: str, dpi: int, seed: int, count: int) -> dict[str, Any]:
    """Seconds and size of one form of the page, and what rasters of its own resolution make of `count` badges.

    Badges have random payloads, of 64 and 128 bits in turn.
    """
    rng = np.random.default_rng(seed)
    seconds, kilobytes = [], 0.0
    seen: dict[str, list[dict[str, Any]]] = {raster: [] for raster in RASTERS}
    with tempfile.TemporaryDirectory() as folder:
        pdf = Path(folder) / "badge.pdf"
        for number in range(count):
            # 128 bits are smaller cells, which are read to 2.2 m.
            request = Order("Bench", lens="50lpi", printer_dpi=dpi, form=form, range_m=(0.8, 2.0))
            badge = design_badge(request, rng.bytes(8 * (1 + number % 2)))
            for _ in range(RUNS if number == 0 else 1):
                clock = time.perf_counter()
                write_badge_pdf(badge, pdf)
                seconds.append(time.perf_counter() - clock)
            kilobytes = max(kilobytes, pdf.stat().st_size / 1e3)
            for raster in RASTERS:
                if raster == "poppler-grey" and (number >= GREY_BADGES or dpi > GREY_DPI):
                    continue
                page = paint(pdf, raster, dpi)
                if page is not None:
                    seen[raster].append(painted_figures(page, badge))
    found: dict[str, Any] = {
        "form": form,
        "dpi": dpi,
        "seconds": float(np.median(seconds)),
        "seconds_spread": float(np.ptp(seconds)),
        "kilobytes": kilobytes,
    }
    return found | {raster: _together(rows, dpi) for raster, rows in seen.items() if rows}


def _together(rows: list[dict[str, Any]], dpi: int) -> dict[str, Any]:
    """The figures of several badges under one raster as one."""
    errors = np.concatenate([row["errors"] for row in rows])
    pitches = [abs(pitch) for row in rows for pitch in row["pitches"]]
    worst = float(np.abs(errors).max())
    return {
        "badges": len(rows),
        "rms_dots": float(np.sqrt(np.mean(errors**2))),
        "worst_dots": worst,
        "worst_um": 25400.0 / dpi * worst,
        "pitch_ppm": 1e6 * max(pitches),
        "read": sum(row["read"] for row in rows),
        "wrong_payloads": sum(row["wrong"] for row in rows),
        "all_markers": sum(row["markers"] == 4 for row in rows),
        "cell_phase_rad": max(row["phase_rad"] for row in rows),
    }


COLUMNS = {"page": "form <8", "dpi": ">5", "raster": "<13", "edges off, dots RMS": "rms_dots >20.2f"}
COLUMNS |= {"worst": "worst_dots >6.2f", "um": "worst_um >6.1f", "pitch, ppm": "pitch_ppm >11.1f"}
COLUMNS |= {"badges": ">7", "markers": "all_markers >8", "read": ">5", "wrong": "wrong_payloads >6", "ms": ">7.0f"}
COLUMNS |= {"kB": "kilobytes >7.0f"}


def table(rows: list[Row]) -> Iterator[Row]:
    """A row for each page and raster."""
    for row in rows:
        if "form" in row:
            for raster in RASTERS:
                if raster in row:
                    yield row | {"raster": raster, "ms": 1e3 * row["seconds"]} | row[raster]


def notes(rows: list[Row]) -> Iterator[str]:
    """What the photographs of the pitch test gave."""
    yield from (_calibration(row["photographs"]) for row in rows if "photographs" in row)


def _calibration(found: dict[str, Any]) -> str:
    """The result of the photographs of the pitch test sheet, in a sentence."""
    if not found["read"]:
        return f"pitch test sheet: none of {found['photographs']} photographs could be read"
    return (
        f"pitch test sheet: {found['read']} of {found['photographs']} photographs read, lens pitch off by "
        f"{found['median_error_percent']:.4f} % (median) and {found['worst_error_percent']:.4f} % (worst), "
        f"{found['rms_in_sd']:.2f} of the stated standard deviations (RMS)"
    )


BENCH = Bench(rows, COLUMNS, notes, table=table, plot=("dpi", "worst_um", "form", "raster"))
