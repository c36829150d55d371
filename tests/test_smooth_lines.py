"""Lines that bend from cell to cell.  Each test names what it would catch."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.frames import own_rect
from moireid.idcodes.families import spells_its_id
from moireid.layers import is_smooth
from moireid.smooth_lines import LineField, rims_mm, rows_of, smoothest

PAYLOAD = payload_for_name("Ada Lovelace")


def silk(axes: str = "x", **wish: object) -> Badge:
    return design_badge(Order("Ada Lovelace", lens="50lpi", axes=axes, pattern="silk", **wish), PAYLOAD)


@pytest.fixture(scope="module")
def badge() -> Badge:
    return silk()


@pytest.mark.parametrize("axes", ["x", "xy", "hex"])
def test_lines_are_the_cells_own_in_their_middles(axes):
    """Catches: cells in the wrong row or column, also along a turned axis; a weight that leaves some of neighbours."""
    for grating in silk(axes).gratings:
        field = LineField(grating)
        for cell in grating.cells:
            low, top, high, bottom = own_rect(grating.axis, cell.rect_mm)
            middle = (low + high) / 2, (top + bottom) / 2
            assert field.numbers(*middle) == pytest.approx((middle[0] - cell.edge_mm) / cell.pitch_mm, abs=1e-9)


def test_no_line_ends_or_jumps(badge):
    """Catches: a step at a border; lines that turn back; edges that were not counted on by whole pitches."""
    field = LineField(badge.gratings[0])
    along, across = np.linspace(field.low, field.high, 1500), np.linspace(field.begin, field.end, 1200)
    numbers = field.numbers(along, across[:, None])
    step = along[1] - along[0]
    assert np.diff(numbers, axis=1).min() > 0.7 * step / 0.52 and np.diff(numbers, axis=1).max() < 1.3 * step / 0.52
    # A jump of one quarter within a tenth of a millimetre would be a border.
    assert np.abs(np.diff(numbers, axis=0)).max() < 0.06


def test_edges_are_counted_on_so_that_neighbours_are_near(badge):
    """Catches: whole turns that add up along a row; a payload that is not spelt any more; an order that changes."""
    grating = badge.gratings[0]
    assert spells_its_id(badge) and smoothest(grating) == grating.cells
    apart = [(b.edge_mm - a.edge_mm) / b.pitch_mm for row in rows_of(grating) for a, b in itertools.pairwise(row)]
    assert max(map(abs, apart)) < 1.01 and np.mean(np.abs(apart)) < 0.4
    cell = grating.cells[5]
    moved = replace(cell, edge_mm=cell.edge_mm + 3 * cell.pitch_mm)
    again = smoothest(replace(grating, cells=(*grating.cells[:5], moved, *grating.cells[6:])))
    assert again[5].edge_mm == pytest.approx(cell.edge_mm)


def test_crossings_and_tables_agree_with_the_numbers(badge):
    """Catches: an inverse on too coarse places; a table that is half a step off; lines wider than their duty."""
    field = LineField(badge.gratings[0])
    across = np.array([field.begin + 4.0, field.begin + 13.37, field.end - 0.1])
    edges = field.edges_mm(across)
    inner = (edges[..., 0] > field.low) & (edges[..., 1] < field.high)
    begins = field.numbers(edges[..., 0], across[:, None])[inner]
    assert begins == pytest.approx(np.round(begins), abs=2e-3)
    ends = field.numbers(edges[..., 1], across[:, None])[inner]
    assert ends - begins == pytest.approx(field.duty, abs=3e-3)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(field.low, field.high, 999), rng.uniform(field.begin, field.end, 999)
    assert field.sampled(x, y) == pytest.approx(field.numbers(x, y), abs=3e-3)
    over = np.array([field.high - 0.2, field.high + 0.3])
    assert np.diff(field.sampled(over, np.full(2, field.begin + 4.0))) == pytest.approx(0.5 / 0.517, rel=0.05)


def test_within_their_rims_lines_are_a_cell_s_own(badge):
    """Catches: rims too narrow, within which neighbours bend what is read; rims that leave nothing to read."""
    grating, field = badge.gratings[0], LineField(badge.gratings[0])
    for cell, (along, across) in zip(grating.cells, rims_mm(grating), strict=True):
        low, top, high, bottom = own_rect(grating.axis, cell.rect_mm)
        assert along < 0.3 * (high - low) and across < 0.3 * (bottom - top)
        x, y = np.linspace(low + along, high - along, 9), np.linspace(top + across, bottom - across, 9)[:, None]
        off = field.numbers(x, y) - (x - cell.edge_mm) / cell.pitch_mm
        assert np.abs(off).max() < 0.12 and np.abs(off).mean() < 0.03


@pytest.mark.parametrize(
    ("wish", "bytes_", "bends"),
    [
        *(({}, 8, True), ({}, 16, True), ({"front": "mask"}, 8, False), ({"axes": "xy"}, 8, True)),
        *(({"axes": "hex"}, 8, False), ({}, 3, False)),
    ],
)
def test_new_badges_are_silk_where_lines_may_bend(wish, bytes_, bends):
    """Catches: a default that refuses turned fields or the pitch code; hard cells where none are asked for."""
    badge = design_badge(Order("Ada", lens="50lpi", range_m=(0.8, 2.0), **wish), PAYLOAD[:1] * bytes_)
    assert [is_smooth(grating) for grating in badge.gratings] == [bends] * len(badge.gratings)
