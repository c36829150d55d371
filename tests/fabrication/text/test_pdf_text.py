"""Names in a PDF as text: what another program copies from the page, in the order in which it is read."""

from __future__ import annotations

import re
import subprocess
import unicodedata
from pathlib import Path

import pytest
from reportlab.pdfgen.canvas import Canvas

from kit.programs import needs
from moireid.fabrication.text.fonts import TYPEFACES
from moireid.fabrication.text.pdf_text import draw_line
from moireid.fabrication.text.shaping import shape_line

#: One line each.  A line of two directions that begins from right to left is given by poppler in the direction of the
#: page's other text; it is not here.
NAMES = [
    "Ada Lovelace fi ffi",
    "محمد بن سلمان",
    "شيلا لا",
    "שלום עולם",
    "שָׁלוֹם עוֹלָם",
    "नरेन्द्र क्षत्रिय श्री दिल्ली",
    "অনন্যা বন্দ্যোপাধ্যায়",
    "தமிழ்ச்செல்வன்",
    "สวัสดีครับ",
    "Zoë x̂ ỹ Ǻ",
    "Владимир Ωμέγα Արամ გიორგი አበበ",
]
#: Signs by which poppler marks directions.
MARKS = re.compile("[\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def write(path: Path, names: list[str], typeface: str) -> None:
    canvas = Canvas(str(path), pagesize=(500, 40 * len(names) + 40), invariant=True)
    for number, name in enumerate(names):
        draw_line(canvas, shape_line(name, typeface, bold=True), 20, 30, 40 * len(names) - 40 * number)
    canvas.showPage()
    canvas.save()


@pytest.mark.parametrize("typeface", TYPEFACES)
def test_another_program_copies_the_names(typeface: str, tmp_path: Path) -> None:
    """Catches: a picture in place of text; letters in the order of glyphs; glyphs whose letters are not given; a
    ligature that gives one letter, or both turned round."""
    write(tmp_path / "a.pdf", NAMES, typeface)
    done = subprocess.run(
        [needs("pdftotext"), "-layout", tmp_path / "a.pdf", "-"], capture_output=True, text=True, check=True
    )
    said = [MARKS.sub("", line).strip() for line in done.stdout.splitlines() if line.strip()]
    assert [unicodedata.normalize("NFC", line) for line in said] == [
        unicodedata.normalize("NFC", name) for name in NAMES
    ]
