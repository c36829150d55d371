"""The moving preview: all fringes move, and nothing else does.  Each test says what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.fabrication.page.preview import ABOVE_MM, LONGER_PX, PX_PER_MM, ROOM_MM, draw_worn


@pytest.mark.parametrize("axes", ["x", "xy", "hex"])
def test_all_fields_move_and_nothing_else(axes: str) -> None:
    """Catches: turned fields of which only an upright rectangle moves; words or markers that tremble."""
    badge = design_badge(Order("Ada Lovelace", lens="50lpi", axes=axes), bytes(8))
    frames = [np.asarray(frame.convert("L"), float) for frame in draw_worn(badge, frames=8)]
    moves = np.ptp(frames, axis=0)
    scale, inside = _scale(badge), np.zeros(moves.shape, bool)
    rows, columns = np.indices(moves.shape)
    x0, y0, _, _ = badge.outline_mm
    page = np.stack([(columns + 0.5) / scale - ROOM_MM + x0, (rows + 0.5) / scale - ABOVE_MM + y0], axis=-1)
    for grating in badge.gratings:
        here = within(badge, grating, page, -1.0)
        inside |= within(badge, grating, page, 1.0)
        # A quarter of each field's own pixels, upper half and lower half alike.
        for half in (here & (rows < np.median(rows[here])), here & (rows >= np.median(rows[here]))):
            assert (moves[half] > 60).mean() > 0.25
    assert (moves[~inside] > 25).mean() < 1e-4


def _scale(badge: Badge) -> float:
    x0, y0, x1, y1 = badge.outline_mm
    return min(PX_PER_MM, LONGER_PX / max(x1 - x0, y1 - y0))


def within(badge, grating, page, spare_mm):
    """Pixels in a grating that is so much larger."""
    first, second = np.moveaxis(badge.frame_of(grating).places(page), -1, 0)
    own = badge.frame_of(grating).places(badge.corners_of(grating))
    low, high = own.min(axis=0) - spare_mm, own.max(axis=0) + spare_mm
    return (first > low[0]) & (first < high[0]) & (second > low[1]) & (second < high[1])
