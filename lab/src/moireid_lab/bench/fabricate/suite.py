"""Error against run time of what is printed: pages by form and resolution, mounts by the tolerance of their facets.

Pages are painted by Poppler and Ghostscript where they are installed (`raster`); each painted edge is compared with its
place, and the identity is read from the raster alone.  A mount's facets are compared with its exact solid.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from moireid.designer import Request, design_badge
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.profiles import FORMS
from moireid_lab.bench.fabricate.calibration import calibration_figures
from moireid_lab.bench.fabricate.mount_extremes import BUILT, extremes
from moireid_lab.bench.fabricate.page_extremes import extreme_rows
from moireid_lab.bench.fabricate.painted import painted_figures
from moireid_lab.bench.fabricate.raster import RASTERS, paint

DPI, QUICK_DPI = (600, 1200, 2400), (600,)
BADGES, QUICK_BADGES = 20, 2
#: Greying takes ten times as long as one bit a dot, so it is done for few badges and not at the highest resolution.
GREY_BADGES, GREY_DPI = 4, 1200
RUNS = 3
#: Photographs of pitch test sheets that are read back.
PHOTOGRAPHS = 40
#: Angles between neighbouring facets of a mount, rad.  They decide how fine a mount's mesh is, not the tolerance in mm,
#: because a mount's bends are so small that OpenCASCADE reaches the angle's limit long before the distance's.
ANGLES_RAD = (0.5, 0.2, 0.1, 0.05, 0.02)
#: Number of facets whose middles are compared with the solid.
MOST_POINTS = 150


def run(*, quick: bool, seed: int, progress: Callable[[int, int | None], None]) -> dict[str, Any]:
    """All figures as one JSON object."""
    cases = [(form, dpi) for form in FORMS for dpi in (QUICK_DPI if quick else DPI)]
    total = len(cases) + 3
    pages = []
    for done, (form, dpi) in enumerate(cases, start=1):
        pages.append(page_figures(form, dpi, seed, QUICK_BADGES if quick else BADGES))
        progress(done, total)
    page_rows = extreme_rows(quick=quick)
    progress(total - 2, total)
    alone = command_seconds(1 if quick else RUNS)
    progress(total - 1, total)
    mounts = mount_figures(ANGLES_RAD[:3:2], 1) if quick else mount_figures(ANGLES_RAD, RUNS)
    progress(total, total)
    mount_rows = extremes(BUILT[:1] if quick else BUILT)
    photographs = calibration_figures(count=2 if quick else PHOTOGRAPHS, seed=seed, progress=lambda: None)
    return {
        "suite": "fabricate",
        "seed": seed,
        "pages": pages,
        "page_extremes": page_rows,
        "pdf_alone": alone,
        "mounts": mounts,
        "mount_extremes": mount_rows,
        "calibration": photographs,
    }


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
            request = Request("Bench", printer_dpi=dpi, form=form, range_m=(0.8, 2.0))
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


def command_seconds(runs: int) -> dict[str, float]:
    """Seconds of `print NAME --mount none` as a command of its own, interpreter and imports included.

    cpu_seconds: of processor time, which other work on the machine does not lengthen; bare_seconds: of an interpreter
    that imports numpy and reportlab alone, to compare with.
    """
    wall: dict[str, list[float]] = {"command": [], "bare": []}
    cpu = []
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            print_it = f"['moireid', 'print', 'Bench', '--mount', 'none', '--out', {str(Path(folder) / 'b')!r}]"
            for name, code in (
                ("bare", "import numpy, reportlab.pdfgen.canvas"),
                ("command", f"import sys; sys.argv = {print_it}; from moireid.cli.main import main; main()"),
            ):
                clock, before = time.perf_counter(), os.times()
                subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
                wall[name].append(time.perf_counter() - clock)
                after = os.times()
            spent = after.children_user + after.children_system - before.children_user - before.children_system
            cpu.append(spent)
    command, bare = (float(np.median(wall[name])) for name in ("command", "bare"))
    return {"seconds": command, "bare_seconds": bare, "ratio": command / bare, "cpu_seconds": float(np.median(cpu))}


def mount_figures(angles_rad: tuple[float, ...], runs: int) -> list[dict[str, Any]]:
    """Seconds of meshing and writing, size and chord error of the lanyard mount's mesh at each angle of its facets."""
    import trimesh

    from moireid.fabrication.printed.mount import lanyard_mount
    from moireid.fabrication.solids import FACET_ANGLE_RAD, cad_package, export_stl

    b3d = cad_package("build123d")
    badge = design_badge(Request("Bench"), bytes(8))
    skin = lanyard_mount(badge).shells()[0]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for angle in angles_rad:
            file = Path(folder) / "mount.stl"
            seconds = []
            for _ in range(runs):
                # The kernel keeps the finest mesh that a shape ever had, so each run meshes a fresh one.
                part = lanyard_mount(badge)
                clock = time.perf_counter()
                export_stl(part, file, tolerance_mm=0.05, angle_rad=angle)
                seconds.append(time.perf_counter() - clock)
            mesh = trimesh.load_mesh(file)
            # Facets that look along an axis are flat ones of the design; only bent surfaces have a chord.
            bent = np.sort(np.abs(mesh.face_normals), axis=1)[:, 1] > 0.01
            middles = mesh.triangles_center[bent]
            middles = middles[:: max(1, len(middles) // MOST_POINTS)]
            error = max(float(skin.distance_to(b3d.Vertex(*point))) for point in middles)
            found.append(
                {
                    "angle_rad": angle,
                    "seconds": float(np.median(seconds)),
                    "kilobytes": file.stat().st_size / 1e3,
                    "triangles": len(mesh.faces),
                    "chord_error_mm": error,
                    "default": angle == FACET_ANGLE_RAD,
                }
            )
    return found
