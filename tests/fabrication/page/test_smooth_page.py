"""Curved lines on the printer's dots.  Each test names what it would catch."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from kit.payloads import payload_for_name
from kit.programs import needs
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.fabrication.page.pdf import write_badge_pdf
from moireid.smooth_lines import LineField

DPI = 1200
DOT_MM = 25.4 / DPI


def raster(badge: Badge, folder: Path) -> np.ndarray:
    """The page in dots, True where there is ink; by a raster that paints every dot that is touched."""
    pdf, picture = folder / "badge.pdf", folder / "badge.pbm"
    write_badge_pdf(badge, pdf)
    options = ["-q", "-dNOPAUSE", "-dBATCH", "-sDEVICE=pbmraw", f"-r{DPI}", f"-sOutputFile={picture}"]
    subprocess.run([needs("gs"), *options, str(pdf)], check=True)
    with pytest.MonkeyPatch.context() as here:
        here.setattr(Image, "MAX_IMAGE_PIXELS", None)
        return np.asarray(Image.open(picture).convert("L")) < 128


@pytest.mark.slow
@pytest.mark.parametrize("form", ["dots", "vector"])
def test_each_edge_is_within_half_a_dot_of_its_place(form, tmp_path):
    """Catches: stairs that are a row late; edges of a row's top instead of its middle; a form that is left straight."""
    badge = design_badge(Order("Ada", lens="50lpi", pattern="silk", form=form), payload_for_name("Ada"))
    ink, field = raster(badge, tmp_path), LineField(badge.gratings[0])
    worst, counted = [], 0
    for row in range(round((field.begin + 9) / DOT_MM), round((field.begin + 40) / DOT_MM), 97):
        line = ink[row, round(field.low / DOT_MM) + 20 : round(field.high / DOT_MM) - 20]
        borders = np.flatnonzero(np.diff(line.astype(int))) + 1 + round(field.low / DOT_MM) + 20
        wanted = np.sort(field.edges_mm([(row + 0.5) * DOT_MM]).ravel()) / DOT_MM
        worst.append(np.abs(borders[:, None] - wanted[None]).min(axis=1).max())
        counted += len(borders)
    assert counted > 500 * len(worst) and max(worst) < (0.55 if form == "dots" else 1.25)
