"""Forty people with odd names, on badges of every template: scripts, 80 letters, emoji, stacked marks, one letter."""

from __future__ import annotations

import csv
import itertools
from dataclasses import replace
from pathlib import Path

import pytest

from kit.set_rows import box_mm
from moireid.artwork.content import Artwork, with_lines
from moireid.artwork.placing import Look, pieces_of
from moireid.artwork.template import TEMPLATES, template_named
from moireid.designer import Order, design_badge
from moireid.designer.formats import FORMATS, turned
from moireid.fabrication.page.lettering import set_name
from moireid.fabrication.page.page_words import set_words

PEOPLE = Path(__file__).parents[2] / "data/people/odd_names.csv"


@pytest.mark.parametrize("orientation", ["landscape", "portrait"])
@pytest.mark.parametrize("template", TEMPLATES)
def test_every_odd_name_is_set_whole_in_letters_that_can_be_read(template: str, orientation: str) -> None:
    """Catches: empty boxes in place of letters; rows over each other or out of their room; words that are lost when
    they are broken; letters that are too small."""
    with PEOPLE.open(encoding="utf-8") as file:
        people = list(csv.DictReader(file))
    assert len(people) == 40
    look = Look(template_named(template), Artwork())
    side = look.template.side(*turned(FORMATS["a6"].size_mm, orientation))
    order = Order("Ada", format="a6", orientation=orientation, head=side.head, foot=side.foot)
    base = design_badge(order, bytes(8))
    shown = 0
    for person in people:
        badge = with_lines(replace(base, name=person["name"]), [person["line1"], person["line2"]])
        for piece in pieces_of(badge, look):
            if piece.kind not in ("words", "id"):
                continue
            rows, (x0, y0, x1, y1) = set_words(piece, badge.id), piece.rect_mm
            boxes = [box_mm(row) for row in rows]
            assert all(glyph.number for row in rows for run in row.line.runs for glyph in run.glyphs), person
            assert all(
                x0 - 1e-6 <= b[0] and b[2] <= x1 + 1e-6 and y0 - 1e-6 <= b[1] <= b[3] <= y1 + 1e-6 for b in boxes
            )
            assert all(above[3] <= below[1] + 1e-6 for above, below in itertools.pairwise(boxes)), person
            if piece.kind == "words":
                assert all(row.points >= piece.least_points - 1e-9 for row in rows)
                wanted = [set_name(words)[0] for words in (piece.name, *piece.lines)]
                said = "".join(row.words for row in rows)
                assert letters("".join(wanted)) == letters(said), person
                shown += bool(set_name(piece.name)[0])
    # Without a font for Chinese, Japanese and Korean, four names have none, and their badges are refused earlier.
    assert shown >= 36


def letters(words: str) -> str:
    """Words without spaces, and without the hyphens that divide them."""
    return words.replace(" ", "").replace("-", "")
