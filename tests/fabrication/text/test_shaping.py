"""Words as glyphs: joined, stacked, in the order in which they are seen, and the same in a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from moireid.fabrication.text import fonts
from moireid.fabrication.text.raster import line_mask
from moireid.fabrication.text.shaping import ShapedLine, clusters, shape_line

#: Names that the shipped fonts have, by script.
SHIPPED = {
    "Latin": "Łukasz O’Brien Nguyễn",
    "Greek": "Αλέξανδρος",
    "Cyrillic": "Владимир Ёжиков",
    "Arabic": "محمد بن سلمان",
    "Hebrew": "שָׁלוֹם",
    "Devanagari": "नरेन्द्र क्षत्रिय",
    "Bengali": "অনন্যা",
    "Tamil": "தமிழ்",
    "Thai": "สวัสดี",
    "Armenian": "Արամ",
    "Georgian": "გიორგი",
    "Ethiopic": "አበበ",
}


@pytest.fixture
def only_shipped(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that has no fonts of its own."""
    monkeypatch.setattr(fonts, "system_fonts", lambda bold: ())
    monkeypatch.setattr(fonts, "_found", {})
    shape_line.cache_clear()


@pytest.mark.parametrize("bold", [False, True])
@pytest.mark.parametrize("typeface", fonts.TYPEFACES)
@pytest.mark.parametrize("script", SHIPPED)
def test_each_typeface_has_every_shipped_script(script: str, typeface: str, bold: bool, only_shipped: None) -> None:
    """Catches: a script whose font was not shipped in one weight; empty boxes in place of letters."""
    line = shape_line(SHIPPED[script], typeface, bold=bold)
    assert line.width_em > 1 and all(glyph.number for run in line.runs for glyph in run.glyphs)
    assert sorted("".join(g.letters for run in line.runs for g in run.glyphs)) == sorted(SHIPPED[script])


def test_arabic_is_joined_and_runs_from_right_to_left() -> None:
    """Catches: letters that are not joined (one by itself reaches lower), or set from left to right."""
    joined, apart = (shape_line(words, bold=True) for words in ("محمد", "\u200c".join("محمد")))
    assert joined.ink_em[1] > -0.1 > apart.ink_em[1]
    (run,) = joined.runs
    assert [glyph.letters for glyph in run.glyphs] == list("دمحم") and run.backwards
    x = [glyph.x_em for glyph in run.glyphs]
    assert x == sorted(x)


def test_devanagari_is_stacked_and_reordered() -> None:
    """Catches: a conjunct that stays two letters; the sign of i behind its letter."""
    (run,) = shape_line("क्षि").runs
    assert run.glyphs[0].letters == "क्षि" and len(run.glyphs) == 2


def test_a_line_of_two_directions_keeps_its_parts_apart() -> None:
    """Catches: Latin letters turned round in a Hebrew line; a bracket that opens to the wrong side."""
    said = "".join(g.letters for run in shape_line("Ada שלום (12)").runs for g in run.glyphs)
    assert said == "Ada (12) םולש"


def test_marks_stay_with_their_letter() -> None:
    """Catches: a mark that gets another font, or a row of its own."""
    assert clusters("x̂Ǻ👩\u200d💻") == ["x̂", "Ǻ", "👩\u200d💻"]
    line = shape_line("A\u0323\u0301")
    assert line.ink_em[0] > 0.8 and line.ink_em[1] < -0.1 and len(line.runs) == 1


def ink(line: ShapedLine, size: float, place: tuple[float, float]) -> np.ndarray:
    """The line's letters in a picture of 400 x 120 px."""
    picture = np.zeros((120, 400))
    found = line_mask(line, size, *place)
    assert found is not None
    mask, (left, top) = found
    picture[top : top + mask.height, left : left + mask.width] = np.asarray(mask)
    return picture


def test_a_picture_shows_letters_at_their_place_and_size() -> None:
    """Catches: a picture upside down, of another size, or with letters above or below their baseline."""
    wide = ink(shape_line("HL"), 80.0, (20.0, 90.0))
    rows, columns = np.flatnonzero(wide.max(axis=1) > 128), np.flatnonzero(wide.max(axis=0) > 128)
    # Capitals of Noto Sans are 0.714 em high.
    assert rows[-1] + 1 == pytest.approx(90, abs=1) and rows[0] == pytest.approx(90 - 0.714 * 80, abs=1)
    assert columns[0] == pytest.approx(20 + 0.098 * 80, abs=1.5)
    # L is heavy below, at the left.
    last = wide[:, columns[-1] - 5 : columns[-1]]
    assert last[83:89].mean() > 200 and last[40:60].mean() < 20
    assert line_mask(shape_line(" "), 80.0, 0.0, 0.0) is None


def test_a_broken_font_of_the_machine_is_passed_over(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Catches: a file that is no font, which ends every print; folders that are never looked into."""
    (tmp_path / "deep").mkdir()
    (tmp_path / "Aaa-Sans-Bold.ttf").write_bytes(b"no font")
    own = fonts.own_font("NotoSansThai", bold=True)
    (tmp_path / "deep/Machine-Sans-Bold.ttf").write_bytes(own.read_bytes())
    monkeypatch.setattr(fonts, "FONT_FOLDERS", (str(tmp_path), str(tmp_path / "absent")))
    monkeypatch.setattr(fonts, "shipped_fonts", lambda typeface, bold: ())
    monkeypatch.setattr(fonts, "_found", {})
    fonts.system_fonts.cache_clear()
    try:
        assert fonts.find_font(frozenset({ord("ส")}), "sans", True) == tmp_path / "deep/Machine-Sans-Bold.ttf"
        assert fonts.find_font(frozenset({0xE0F00}), "sans", True) is None
    finally:
        fonts.system_fonts.cache_clear()
