"""Pages at the edge of what can be asked: right, or refused with what would work, which then does work.

The whole table, up to 4800 dpi, is in `moireid bench fabricate`; here are the rows that are quick.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from moireid.designer import Order
from moireid.errors import DesignError, SpecError
from moireid_lab.bench.fabricate.page_extremes import PageCase, cases, extreme_row, follow, settle

RASTERS = tuple(name for name, tool in (("poppler", "pdftoppm"), ("ghostscript", "gs")) if shutil.which(tool))
BY_NAME = {case.name: case for case in cases()}
#: Case, outcome, and what each refusal on the way must say.
ROWS = [
    ("150 dpi", "refused", ["print at 300 dpi or more"]),
    ("300 dpi", "right", []),
    ("badge of 30 x 30 mm", "refused", ["at least 60x66", "within 0.09-1.70 m"]),
    ("badge of 30 x 150 mm", "refused", ["within 0.21-0.85 m"]),
    ("sheet of 0.2 mm, 50 LPI", "refused", ["0.26 or more"]),
    ("sheet of 0.2 mm, 180 LPI, 600 dpi", "refused", ["choose a range within", "print at 1200 dpi or more"]),
    ("lens pitch 11.999 dots of 600 dpi", "right", []),
    ("printed pitch 12.001 dots of 600 dpi", "right", []),
    ("printed pitch 12.999 dots of 600 dpi", "right", []),
    ("printed pitch 13.001 dots of 600 dpi", "right", []),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "outcome", "words"), ROWS, ids=[row[0] for row in ROWS])
def test_a_page_is_right_or_advice_leads_to_one_that_is(name: str, outcome: str, words: list[str]) -> None:
    """Catches: advice that is refused in its turn; edges that drift where a pitch is all but a whole number of dots;
    cells that cannot be distinguished on coarse dots."""
    row = extreme_row(BY_NAME[name], RASTERS[:1])
    assert row["outcome"] == outcome, row
    assert len(row["said"]) == len(words)
    assert all(word in said for word, said in zip(words, row["said"], strict=True))


@pytest.mark.parametrize(
    "name", ["badge of 300 x 300 mm", "badge of 200 x 280 mm on letter", "sheet of 6 mm, 50 LPI", "4800 dpi"]
)
def test_wishes_that_are_slow_to_paint_are_granted_too(name: str, tmp_path: Path) -> None:
    """Catches: a size that does not fit the paper that it was advised for."""
    _, badge, said = settle(BY_NAME[name], tmp_path)
    assert badge is not None and len(said) == (1 if "badge of" in name else 0)
    x0, y0, x1, y1 = badge.outline_mm
    assert min(x0, y0) >= 12 - 1e-6 and x1 <= badge.page_mm[0] - 12 + 1e-6 and y1 <= badge.page_mm[1] - 12 + 1e-6


def test_advice_that_is_none_ends_in_no_page(tmp_path: Path) -> None:
    """Catches: a table that calls a refusal without advice right; a loop that follows nothing for ever."""
    case = PageCase("unknown paper", Order("Extreme", lens="50lpi", range_m=(0.8, 2.5), paper="a9"))
    assert follow(case, SpecError("no")) == case
    assert settle(case, tmp_path)[1] is None
    assert extreme_row(case)["outcome"] == "wrong"
    wished = follow(case, DesignError("no", near_m=0.5, far_m=1.0))
    assert wished.request.range_m == (0.8, 1.0)


@pytest.mark.parametrize("dpi", [600, 1200])
def test_pitches_meant_to_be_near_whole_dots_are(dpi: int, tmp_path: Path) -> None:
    """Catches: a case whose name says what its badge is not."""
    named = [case for case in cases() if "printed pitch" in case.name and f"of {dpi} dpi" in case.name]
    assert len(named) == 4
    for case in named:
        _, badge, said = settle(case, tmp_path)
        assert badge is not None and not said
        dots = badge.gratings[0].pitch_mm * dpi / 25.4
        assert abs(dots - round(dots)) == pytest.approx(1e-3, abs=1e-6)
