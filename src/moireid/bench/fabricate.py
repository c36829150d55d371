"""Error against run time of what is printed: pages by form and resolution, mounts by the tolerance of their facets.

Pages are painted by Poppler and Ghostscript where they are installed, which paint every dot that is touched; each
painted edge is compared with its place.  A mount's facets are compared with the solid that they stand for.
"""

from __future__ import annotations

import math
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from moireid.badge import Badge
from moireid.bench.mount_extremes import BUILT, extremes
from moireid.designer import Request, design_badge
from moireid.dots import line_edges_mm
from moireid.fabrication.page import write_badge_pdf
from moireid.profiles import FORMS, MM_PER_INCH

DPI, QUICK_DPI = (600, 1200, 2400), (600,)
RUNS = 3
#: A strip of the page, across all rows of cells, is enough and fits the memory at 2400 dpi.
STRIP_MM = 4.0
TOLERANCES_MM = (0.4, 0.2, 0.1, 0.05, 0.02)
#: Facets whose middles are held against the solid.
MOST_POINTS = 150


def run(*, quick: bool, seed: int, progress: Callable[[int, int | None], None]) -> dict[str, Any]:
    """All figures as one JSON object."""
    cases = [(form, dpi) for form in FORMS for dpi in (QUICK_DPI if quick else DPI)]
    total = len(cases) + 1
    pages = []
    for done, (form, dpi) in enumerate(cases, start=1):
        pages.append(page_figures(form, dpi, seed))
        progress(done, total)
    mounts = mount_figures(TOLERANCES_MM[:2] if quick else TOLERANCES_MM)
    progress(total, total)
    rows = extremes(BUILT[:1] if quick else BUILT)
    return {"suite": "fabricate", "seed": seed, "pages": pages, "mounts": mounts, "mount_extremes": rows}


def page_figures(form: str, dpi: int, seed: int) -> dict[str, Any]:
    """Seconds, size and edge error of one form of the page, painted at its own resolution."""
    payload = np.random.default_rng(seed).bytes(8)
    badge = design_badge(Request("Bench", printer_dpi=dpi, form=form), payload)
    with tempfile.TemporaryDirectory() as folder:
        pdf = Path(folder) / "badge.pdf"
        seconds = []
        for _ in range(RUNS):
            clock = time.perf_counter()
            write_badge_pdf(badge, pdf)
            seconds.append(time.perf_counter() - clock)
        found: dict[str, Any] = {
            "form": form, "dpi": dpi, "seconds": float(np.median(seconds)),
            "seconds_spread": float(np.ptp(seconds)), "kilobytes": pdf.stat().st_size / 1e3,
        }  # fmt: skip
        for raster in ("poppler", "ghostscript"):
            dark = painted(pdf, raster, dpi)
            if dark is not None:
                errors = edge_errors_dots(dark, badge, dpi)
                found[raster] = {
                    "rms_dots": float(np.sqrt(np.mean(errors**2))), "worst_dots": float(np.abs(errors).max()),
                    "worst_um": float(1e3 * np.abs(errors).max() * MM_PER_INCH / dpi),
                }  # fmt: skip
    return found


def painted(pdf: Path, raster: str, dpi: int) -> NDArray[np.bool_] | None:
    """A strip through the middle of page 1 as dots, True where dark; None where the raster is not installed."""
    height = math.ceil(297.0 / MM_PER_INCH * dpi)
    first, rows = int(height / 2), max(int(STRIP_MM / MM_PER_INCH * dpi), 2)
    out = pdf.with_suffix(".pbm")
    if raster == "poppler":
        program = shutil.which("pdftoppm")
        where = ["-x", "0", "-W", str(math.ceil(210.0 / MM_PER_INCH * dpi)), "-y", str(first), "-H", str(rows)]
        command = ["-mono", "-r", str(dpi), *where, "-singlefile", str(pdf), str(out.with_suffix(""))]
    else:
        program = shutil.which("gs")
        command = ["-q", "-dNOPAUSE", "-dBATCH", "-sDEVICE=pbmraw", f"-r{dpi}", f"-sOutputFile={out}", str(pdf)]
    if program is None:
        return None
    subprocess.run([program, *command], check=True, capture_output=True)
    Image.MAX_IMAGE_PIXELS = None
    picture: Image.Image = Image.open(out)
    if raster == "ghostscript":
        picture = picture.crop((0, first, picture.width, first + rows))
    return np.asarray(picture.convert("L")) < 128


def edge_errors_dots(dark: NDArray[np.bool_], badge: Badge, dpi: int) -> NDArray[np.float64]:
    """Distance of every painted edge from its place, in dots, for the cells that the strip's middle meets."""
    dot_mm = MM_PER_INCH / dpi
    middle = 297.0 / 2 + STRIP_MM / 2
    steps = np.diff(dark[dark.shape[0] // 2].astype(int))
    errors = []
    for grating in badge.gratings:
        for cell in grating.cells:
            if not cell.rect_mm[1] + 0.5 <= middle <= cell.rect_mm[3] - 0.5:
                continue
            edges = line_edges_mm(grating, cell)
            for sign, places in ((1, edges[:, 0]), (-1, edges[:, 1])):
                seen = (np.flatnonzero(steps == sign) + 1) * dot_mm
                inside = places[(places > cell.rect_mm[0] + 0.6) & (places < cell.rect_mm[2] - 0.6)]
                nearest = seen[np.abs(seen[:, None] - inside[None, :]).argmin(axis=0)]
                errors.append((nearest - inside) / dot_mm)
    return np.concatenate(errors)


def mount_figures(tolerances_mm: tuple[float, ...]) -> list[dict[str, Any]]:
    """Seconds, size and chord error of the lanyard mount's mesh at each tolerance."""
    import trimesh

    from moireid.fabrication.mount import lanyard_mount
    from moireid.fabrication.solids import cad_package, export_stl

    b3d = cad_package("build123d")
    badge = design_badge(Request("Bench"), bytes(8))
    part = lanyard_mount(badge)
    skin = part.shells()[0]
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for tolerance in tolerances_mm:
            file = Path(folder) / "mount.stl"
            clock = time.perf_counter()
            # The kernel keeps the finest mesh that a shape ever had, so each tolerance meshes a fresh one.
            export_stl(lanyard_mount(badge), file, tolerance_mm=tolerance)
            seconds = time.perf_counter() - clock
            mesh = trimesh.load_mesh(file)
            # Facets that look along an axis are flat ones of the design; only bent surfaces have a chord.
            bent = np.sort(np.abs(mesh.face_normals), axis=1)[:, 1] > 0.01
            middles = mesh.triangles_center[bent]
            middles = middles[:: max(1, len(middles) // MOST_POINTS)]
            error = max(float(skin.distance_to(b3d.Vertex(*point))) for point in middles)
            found.append({
                "tolerance_mm": tolerance, "seconds": seconds, "kilobytes": file.stat().st_size / 1e3,
                "triangles": len(mesh.faces), "chord_error_mm": error,
            })  # fmt: skip
    return found
