"""Rows of words as they are set."""

from __future__ import annotations

from moireid.fabrication.page.page_words import CAPITAL_SHARE, MM_PER_POINT, SetWords


def box_mm(row: SetWords) -> tuple[float, float, float, float]:
    """The rectangle of a row on the page: from its capitals' height, or higher ink, to its lowest ink."""
    size, (top, low) = row.points * MM_PER_POINT, row.line.ink_em
    right = row.x_mm + row.line.width_em * size
    return row.x_mm, row.baseline_mm - max(CAPITAL_SHARE, top) * size, right, row.baseline_mm - low * size
