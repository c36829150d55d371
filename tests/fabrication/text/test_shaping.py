"""Words as glyphs: joined, stacked, in the order in which they are seen, and the same in a picture."""

from __future__ import annotations

from pathlib import Path

import pytest

from moireid.fabrication.text import fonts
from moireid.fabrication.text.shaping import shape_line

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
