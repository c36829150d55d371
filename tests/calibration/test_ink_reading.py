"""The growth of printed lines, read from pictures of the strip.  Next to each test: the fault that it catches."""

from __future__ import annotations

import click
import cv2
import numpy as np
import pypdfium2 as pdfium
import pytest

from moireid.badge import Badge
from moireid.calibration.ink_reading import ink_growth
from moireid.cli.printing.print_cmd import print_command
from moireid.designer.chart import design_chart
from moireid.fabrication.page.chart_page import PDF, print_chart
from moireid.ink_strip import ink_patches, strip_rect_mm
from moireid.profiles import PrinterProfile, keep_printer, load_printer_profile, save_profile
from moireid_lab.bench.fabricate.strip_photographs import OddCamera, photographed_strip

#: Cameras and light: as the reader expects; other tone curves; blurred, noisy, unevenly lit; sharpened; small.
CAMERAS = {
    "plain": OddCamera(),
    "steep": OddCamera(coding=1.7),
    "flat": OddCamera(coding=2.7),
    "contrasty": OddCamera(shape=0.5, px_per_mm=3),
    "pale": OddCamera(shape=-0.3),
    "blurred": OddCamera(blur_px=1.8, noise=5),
    "uneven": OddCamera(unevenness=0.5, exposure=0.6),
    "sharpened": OddCamera(px_per_mm=3, coding=1.9, shape=0.3, blur_px=1.2, sharpening=0.4),
    "small": OddCamera(px_per_mm=2.3, coding=1.9),
    "large": OddCamera(px_per_mm=8, coding=2.4),
}


@pytest.fixture(scope="module")
def chart() -> Badge:
    return design_chart()


@pytest.mark.claim("The growth of ink is measured from a photograph")
@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("growth_um", [0.0, 25.0, 60.0])
def test_the_growth_is_read_whatever_the_camera_does_to_greys(chart, camera, growth_um):
    """Catches: the camera's tone curve taken for sRGB (30 um off); light that falls off; neighbours that blur in."""
    found = ink_growth([photographed_strip(chart, growth_um, CAMERAS[camera])], chart)
    assert found.um is not None, found.why
    assert abs(found.um - growth_um) < 2.5 * found.sd_um and abs(found.um - growth_um) < 8


def test_growth_moves_the_three_pitches_as_docs_say(chart):
    """Catches: other ratios of pitches than docs/decisions/printing.md has."""
    pitches = {patch.kind: patch.pitch_mm for patch in ink_patches(chart) if patch.pitch_mm}
    shares = [pitches["coarse"] / pitches[kind] for kind in ("finest", "fine", "coarse")]
    assert shares == pytest.approx([7.5, 3.0, 1.0])


def test_pictures_that_do_not_show_it_say_why(chart):
    """Catches: a growth from a strip under the lens sheet, from paper alone, from overexposed or cut pictures."""

    def why(luma: np.ndarray, page: np.ndarray) -> str:
        found = ink_growth([(luma, page)], chart)
        assert found.um is None
        return found.why

    assert "from nearer" in why(*photographed_strip(chart, 40, OddCamera(px_per_mm=1.5)))
    assert "farther away" in why(*photographed_strip(chart, 40, OddCamera(px_per_mm=12)))
    assert "overexposed" in why(*photographed_strip(chart, 40, OddCamera(exposure=1.4)))
    luma, page = photographed_strip(chart, 40, CAMERAS["plain"])
    assert "does not look as printed" in why(np.full_like(luma, 200), page)
    assert "not wholly within" in why(luma[:, : luma.shape[1] // 2], page)
    # Lenses show either ink or paper of what is under them: stripes as wide as the fringes of each pitch.
    covered = luma.copy()
    covered[:, ::2] = np.where(np.arange(luma.shape[1])[::2] // 9 % 2, 40, 210).astype(np.uint8)
    assert "does not look as printed" in why(cv2.blur(covered, (9, 1)), page)
    assert ink_growth([], chart).um is None


@pytest.mark.parametrize(("dpi", "form"), [(600, "dots"), (1200, "dots"), (600, "vector")])
def test_the_page_holds_the_strip_that_the_reader_expects(tmp_path, dpi, form):
    """Catches: another place, pitch or width on paper than in the reader; edges that dots round away."""
    chart = design_chart(printer_dpi=dpi, form=form)
    print_chart(chart, tmp_path)
    page = pdfium.PdfDocument(tmp_path / PDF)[0]
    scale = 40
    x0, y0, x1, y1 = strip_rect_mm(chart)
    wide, high = chart.page_mm
    crop = tuple(value * 72 / 25.4 for value in (x0, high - y1, wide - x1, y0))
    grey = page.render(scale=scale * 25.4 / 72, crop=crop, grayscale=True).to_numpy()
    grey = grey.reshape(grey.shape[:2]) / 255
    for patch in ink_patches(chart):
        left, top, right, bottom = (round(scale * v) for v in np.subtract(patch.inner_mm, (x0, y0, x0, y0)))
        # The page's edges are drawn a quarter of a dot within the dots that a printer inks.
        drawn = 25.4 / dpi / 2 / patch.pitch_mm if patch.pitch_mm and form == "dots" else 0.0
        inked = 1 - grey[top:bottom, left:right].mean()
        assert inked + drawn == pytest.approx(patch.ink_share(0.0), abs=0.012), patch


def test_a_printer_profile_reads_back_and_serves_the_print_commands(tmp_path):
    """Catches: a profile whose figures the commands ignore, or put before those that are given."""
    path = tmp_path / "mine.json"
    printer = PrinterProfile("mine", 600, 41.5, 4.0, (0.998, 0.999), {"how": "a test"})
    save_profile(printer, path)
    assert load_printer_profile(path) == printer and PrinterProfile("thin", 600, -3.0).drawn_growth_um == 0
    made = ["Ada", "--out", "ada", "--printer", str(path)]
    for given, dpi, scale in (
        (["--printer-dpi", "1200"], 1200, (0.998, 0.999)),
        (["--measured-scale", "1"], 600, (1, 1)),
    ):
        taken = print_command.make_context("print", [*made, *given]).params
        assert (taken["printer_dpi"], taken["ink_growth_um"], taken["measured_scale"]) == (dpi, 41.5, scale)


def test_a_printer_is_kept_once_and_used_by_its_name(tmp_path, monkeypatch, capsys):
    """Catches: a name that is taken for a file; a profile kept elsewhere than it is looked for; one used unsaid."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    keep_printer(PrinterProfile("printer of 600 dpi", 600, 64.0, 4.0, (0.998, 0.999)), "office-laser")
    taken = print_command.make_context("print", ["Ada", "--out", "ada", "--printer", "office-laser"]).params
    assert (taken["printer_dpi"], taken["ink_growth_um"], taken["measured_scale"]) == (600, 64.0, (0.998, 0.999))
    assert "office-laser: lines 64 um narrower, 600 dpi, 1/0.998 wide, 1/0.999 high" in capsys.readouterr().err
    with pytest.raises(click.UsageError, match="did you mean office-laser"):
        print_command.make_context("print", ["Ada", "--out", "ada", "--printer", "ofice-laser"])
