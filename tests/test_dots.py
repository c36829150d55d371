"""Lines on a printer's dots: the rule by numbers, and the page as two independent rasters paint it.

Poppler paints every dot that is touched, or greys; Ghostscript paints what is touched, and counts a page from its
lower edge.  Each test names the wrong implementation that it would catch.
"""

from __future__ import annotations

import math
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from kit.programs import needs
from moireid.badge import Badge, Cell, Grating
from moireid.designer import Order, design_badge
from moireid.dots import line_edges_mm, nearest_dot, on_dots, realised
from moireid.errors import DesignError
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.frames import own_frame

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")
LENS_MM = 0.508


def grating_of(pitch: float, edge: float = 0.1, width: float = 100.0, duty: float = 0.5) -> Grating:
    cell = Cell((10.0, 10.0, 10.0 + width, 20.0), pitch, edge, duty)
    return Grating(cell.rect_mm, "x", pitch, "uniform", (cell,))


# The rule.


def test_edges_go_to_the_nearest_border_of_their_own(rng):
    """Catches: edges counted from their neighbours, so that rounding adds up; widths rounded instead of edges."""
    dot = 25.4 / 1200
    edges = line_edges_mm(grating_of(0.52), grating_of(0.52).cells[0])
    assert len(edges) > 185 and np.all(np.abs(nearest_dot(edges, dot) * dot - edges) <= dot / 2 + 1e-12)
    places = rng.uniform(0, 300, 1000)
    assert np.array_equal(nearest_dot(places, dot), np.round(places / dot))


@pytest.mark.parametrize(("pitch", "dpi"), [(0.52, 600), (0.5193, 1200), (25.4 / 1200 * 24.001, 1200), (0.53, 300)])
def test_figures_of_a_cell_are_those_of_its_rounded_lines(pitch, dpi):
    """Catches: a sign of the phase, a pitch error per line instead of per pitch, a beat that ignores the lens."""
    dot, grating = 25.4 / dpi, grating_of(pitch)
    found = realised(grating, grating.cells[0], LENS_MM, dot)
    edges = line_edges_mm(grating, grating.cells[0])
    drawn = np.round(edges / dot) * dot
    slope, middle = np.polyfit(np.arange(len(edges)) - (len(edges) - 1) / 2, drawn.mean(axis=1), 1)
    assert found.pitch_error == pytest.approx(slope / pitch - 1, abs=1e-9)
    assert found.phase_error_rad == pytest.approx(-2 * math.pi * (middle - edges.mean()) / pitch, abs=1e-6)
    assert found.beat_error == pytest.approx((1 / slope - 1 / pitch) / (1 / pitch - 1 / LENS_MM), abs=1e-6)
    assert found.edge_error_mm == pytest.approx(np.abs(drawn - edges).max())
    # Independent errors of half a dot leave so little of the pitch over 100 mm: no drift.
    assert abs(found.pitch_error) < 0.6 * dot / 100


@pytest.mark.parametrize("dpi", [600, 1200, 2400, 4800])
def test_badges_tell_what_dots_make_of_every_cell(dpi):
    """Catches: figures of another resolution; a cell left out."""
    badge = design_badge(Order("Ada", lens="50lpi", printer_dpi=dpi), PAYLOAD)
    report = on_dots(badge)
    assert len(report["cells"]) == sum(len(grating.cells) for grating in badge.gratings)
    assert max(row[3] for row in report["cells"]) <= 0.5 * 25400 / dpi + 0.01
    for g, c, ppm, _, phase, beat in report["cells"][::17]:
        grating = badge.gratings[g]
        found = realised(grating, grating.cells[c], badge.lens.pitch_mm, 25.4 / dpi)
        expected = (1e6 * found.pitch_error, found.phase_error_rad, found.beat_error)
        assert (ppm, phase, beat) == pytest.approx(expected, abs=0.01)
    assert on_dots(design_badge(Order("Ada", lens="50lpi", printer_dpi=dpi, form="vector"), PAYLOAD)) is None


@pytest.mark.parametrize(("dpi", "most"), [(300, 0.0065), (600, 0.0022)])
def test_lines_that_cross_the_dots_at_an_angle_are_off_by_little(dpi, most):
    """Catches: another figure than docs/decisions/optics.md has for turned fields."""
    badge, dot, off = design_badge(Order("Ada", axes="hex"), bytes(range(8))), 25.4 / dpi, []
    for grating in badge.gratings[1:]:
        frame, reach = own_frame(grating.axis, badge.page_mm), dot / 2 * (0.5 + math.sqrt(0.75))
        for cell in grating.cells[::2]:
            corners = frame.corners_mm(cell.rect_mm)
            ends = zip(corners.min(axis=0) // dot, corners.max(axis=0) // dot, strict=True)
            sides = [(np.arange(low, high + 1) + 0.5) * dot for low, high in ends]
            across, along = np.moveaxis(frame.places(np.stack(np.meshgrid(*sides), -1)), -1, 0)
            x0, y0, x1, y1 = cell.rect_mm
            whole = x0 + int((x1 - x0) / cell.pitch_mm) * cell.pitch_mm
            place = across[(across > x0) & (across < whole) & (along > y0) & (along < y1)] - cell.edge_mm
            inked = (place + reach) % cell.pitch_mm < cell.duty * cell.pitch_mm + 2 * reach
            off.append(np.angle((inked * np.exp(1j * np.pi * (cell.duty - 2 * place / cell.pitch_mm))).sum()))
    assert max(np.abs(off)) == pytest.approx(most, abs=0.0006)


def test_dots_too_coarse_for_the_code_are_refused_with_what_would_do():
    """Catches: a badge that no print of it can spell."""
    for dpi, words in ((150, "dots wide"), (293, "off its place")):
        with pytest.raises(DesignError, match=words) as refused:
            design_badge(Order("Ada", lens="50lpi", printer_dpi=dpi), PAYLOAD)
        assert f"{refused.value.details['least_dpi']} dpi or more" in str(refused.value)
        design_badge(Order("Ada", lens="50lpi", printer_dpi=refused.value.details["least_dpi"]), PAYLOAD)


# The page.


def painted(pdf: Path, raster: str, dpi: int) -> np.ndarray:
    """Page 1 as dots, True where dark."""
    out = pdf.with_suffix(f".{raster}")
    if raster == "ghostscript":
        picture = out.with_suffix(".pbm")
        options = ["-q", "-dNOPAUSE", "-dBATCH", "-sDEVICE=pbmraw", f"-r{dpi}", f"-sOutputFile={picture}"]
        subprocess.run([needs("gs"), *options, pdf], check=True)
    else:
        kind, ending = ("-mono", "pbm") if raster == "poppler" else ("-gray", "pgm")
        subprocess.run([needs("pdftoppm"), kind, "-r", str(dpi), "-singlefile", pdf, out], check=True)
        picture = Path(f"{out}.{ending}")
    with pytest.MonkeyPatch.context() as here:
        here.setattr(Image, "MAX_IMAGE_PIXELS", None)
        return np.asarray(Image.open(picture).convert("L")) < 128


def edge_errors(dark: np.ndarray, badge: Badge, dpi: int) -> tuple[np.ndarray, list[float]]:
    """Distance of every painted edge from its place, dots; share by which the pitch of each uniform row is off."""
    dot, errors, pitches = 25.4 / dpi, [], []
    for grating in badge.gratings:
        k = 0 if grating.axis == "x" else 1
        for cell in grating.cells:
            middle = int((cell.rect_mm[1 - k] + cell.rect_mm[3 - k]) / 2 / dot)
            steps = np.diff((dark[middle] if k == 0 else dark[:, middle]).astype(int))
            low, high = cell.rect_mm[k], cell.rect_mm[k + 2]
            for sign, begin in ((1, cell.edge_mm), (-1, cell.edge_mm + cell.duty * cell.pitch_mm)):
                seen = (np.flatnonzero(steps == sign) + 1) * dot
                seen = seen[(seen > low + 0.6) & (seen < high - 0.6)]
                count = np.round((seen - begin) / cell.pitch_mm)
                assert len(seen) >= (high - low - 1.2) / cell.pitch_mm - 1.01
                errors.append((seen - begin - count * cell.pitch_mm) / dot)
                if high - low > 80:
                    pitches.append(float(np.polyfit(count, seen, 1)[0] / cell.pitch_mm - 1))
    return np.concatenate(errors), pitches


@pytest.mark.claim("Every edge is painted within half a dot of its place")
@pytest.mark.slow
@pytest.mark.parametrize("raster", ["poppler", "poppler-grey", "ghostscript"])
def test_every_edge_is_painted_within_half_a_dot_of_its_place(raster, tmp_path):
    """Catches: lines a dot too wide under a raster that paints what it touches; a page counted from the wrong edge;
    rounding that adds up.
    """
    for dpi, axes, size in ((600, "x", (146.0, 160.0)), (600, "xy", (180.0, 200.0)), (1200, "x", (146.0, 160.0))):
        badge = design_badge(
            Order("Ada", lens="50lpi", printer_dpi=dpi, axes=axes, size_mm=size, pattern="cells"), PAYLOAD
        )
        write_badge_pdf(badge, tmp_path / "badge.pdf")
        errors, pitches = edge_errors(painted(tmp_path / "badge.pdf", raster, dpi), badge, dpi)
        assert np.abs(errors).max() <= 0.5 + 1e-3, (dpi, axes)
        # What independent errors of half a dot allow over 80 mm.
        assert max(map(abs, pitches), default=0.0) < {600: 60e-6, 1200: 30e-6}[dpi]


def test_a_measured_scale_is_made_up_for_on_both_axes(tmp_path):
    """Catches: the scale applied the wrong way round, x and y exchanged, a middle that moves, drift under scale."""
    badge = design_badge(Order("Ada", lens="50lpi", pattern="cells"), PAYLOAD)
    write_badge_pdf(badge, tmp_path / "badge.pdf", measured_scale=(0.9973, 1.004))
    dark = painted(tmp_path / "badge.pdf", "poppler", 1200)
    dot = 25.4 / 1200
    width, height = badge.page_mm

    def printed(x: float, y: float) -> tuple[float, float]:
        """Coordinates for a printer with scales 0.9973 and 1.004, so that a place is printed correctly."""
        return width / 2 + (x - width / 2) / 0.9973, height / 2 + (y - height / 2) / 1.004

    half = badge.markers.size_mm / 2
    for x, y in badge.markers.centers_mm:
        (x0, y0), (x1, y1) = printed(x - half, y - half), printed(x + half, y + half)
        row, column = dark[int((y0 + 1) / dot)], dark[:, int((x0 + 1) / dot)]
        assert not row[int((x0 - 0.05) / dot)] and row[int((x0 + 0.05) / dot)]
        assert row[int((x1 - 0.05) / dot)] and not row[int((x1 + 0.05) / dot)]
        assert not column[int((y0 - 0.05) / dot)] and column[int((y0 + 0.05) / dot)]
        assert column[int((y1 - 0.05) / dot)] and not column[int((y1 + 0.05) / dot)]
    scaled = replace(
        badge,
        gratings=tuple(
            replace(
                g,
                cells=tuple(
                    replace(
                        c,
                        rect_mm=(*printed(*c.rect_mm[:2]), *printed(*c.rect_mm[2:])),
                        pitch_mm=c.pitch_mm / 0.9973,
                        edge_mm=printed(c.edge_mm, 0.0)[0],
                    )
                    for c in g.cells
                ),
            )
            for g in badge.gratings
        ),
    )
    errors, pitches = edge_errors(dark, scaled, 1200)
    assert np.abs(errors).max() <= 0.5 + 1e-3 and max(map(abs, pitches)) < 30e-6
