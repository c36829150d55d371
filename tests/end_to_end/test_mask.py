"""A badge whose front is a printed line mask on acrylic.  Each test names the wrong implementation it catches."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pypdfium2 as pdfium
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge, explain
from moireid.fabrication.page.pdf import mask_grating, write_badge_pdf
from moireid.simulate.filming import film
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid.verifier import KnownCamera, Question, verify

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")


@pytest.fixture(scope="module")
def masked() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", front="mask", lens_thickness_mm=2.0), PAYLOAD)


def test_the_front_is_a_mask_of_the_sheet_s_pitch_on_acrylic(masked: Badge) -> None:
    """Catches: a mask that is described as a lens; the sheet's thickness in place of the spacer's."""
    lens = masked.lens
    assert (lens.kind, lens.pitch_mm, lens.thickness_mm) == ("mask", 0.508, 2.0)
    assert lens.refractive_index == 1.49 and lens.open_fraction == 0.5 and lens.radius_mm is None
    assert dict(explain(masked))["mask"].endswith("2 mm of acrylic")


def test_the_mask_s_own_page_covers_every_grating(tmp_path: Path) -> None:
    """Catches: no second page; the badge's lines on it; a mask of one axis over the other."""
    both = design_badge(
        Order("Ada", lens="50lpi", front="mask", axes="xy", size_mm=(180.0, 200.0), form="vector"), PAYLOAD
    )
    write_badge_pdf(both, tmp_path / "badge.pdf")
    document = pdfium.PdfDocument(tmp_path / "badge.pdf")
    assert len(document) == 2
    dots = np.asarray(document[1].render(scale=1200 / 72 / 2, grayscale=True).to_pil()) < 128
    per_mm = 600 / 25.4
    for grating in both.gratings:
        own = mask_grating(both.lens, grating)
        x0, y0, x1, y1 = (round(v * per_mm) for v in grating.rect_mm)
        inside = dots[y0:y1, x0:x1].astype(float)
        assert inside.mean() == pytest.approx(0.5, abs=0.03)
        # Lines stand across the axis that the fringes sense, an opening on the middle.
        along = inside.mean(axis=0 if grating.axis == "x" else 1)
        spread = inside.mean(axis=1 if grating.axis == "x" else 0)
        assert along.std() > 0.3 and spread.std() < 0.05
        middle = len(along) // 2
        assert along[middle - 2 : middle + 3].max() < 0.2
        turns = np.fft.rfft(along - along.mean())
        assert np.argmax(np.abs(turns)) / (len(along) / per_mm) == pytest.approx(1 / 0.508, rel=0.01)
        assert own.cells[0].duty == 0.5
    document.close()


@pytest.mark.claim("A line mask is judged and read as a lens sheet is")
@pytest.mark.slow
def test_a_film_of_it_is_accepted_and_read(masked: Badge, tmp_path: Path) -> None:
    """Catches: a verifier that takes every front for a lens; the gap's index left out of the law."""
    build = Build(0.1, math.radians(0.2), 1.002, 0.999)
    scene = Scene(masked, build, Camera(1280, 720, 967.0))
    motion = motion_named("sway", distance_mm=1000.0, seed=5)
    film(scene, motion, tmp_path / "film.mp4", frames=120, fps=30.0, seed=5, crf=26)
    report = verify(tmp_path / "film.mp4", Question(masked, masked.id, camera=KnownCamera(967.0)))
    assert report.verdict == "accept" and report.identity.decoded_id == masked.id
    # Gains of films of other noise scatter by 0.02.
    assert report.invariant.gain_ratio == pytest.approx(1.0, abs=3 * report.invariant.gain_sd)
    assert report.invariant.gain_sd < 0.02
