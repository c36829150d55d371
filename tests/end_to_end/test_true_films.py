"""Forgeries from true films (`benchmarks/true_films`) show what they are to show, on fringes drawn by a formula."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from moireid.designer import Order, design_badge
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Scene

DISTANCE_MM = 1000.0


@pytest.fixture(autouse=True)
def _found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "benchmarks"))


def _badge(number: int):
    return design_badge(Order("Bench", lens="50lpi", axes="xy"), np.random.default_rng(number).bytes(8))


def _places(badge):
    """Places of each pixel on the page, counted from the board's centre, (2, rows, columns), mm."""
    from true_films.clip import board_size, board_to_page

    (step, _, left), (_, _, top), _ = board_to_page(badge)
    columns, rows = board_size(badge)
    x0, y0, x1, y1 = badge.outline_mm
    x, y = np.meshgrid(left + step * np.arange(columns) - (x0 + x1) / 2, top + step * np.arange(rows) - (y0 + y1) / 2)
    return np.stack([x, y])


def _drawn(turns):
    """Fringes of a phase, turns, as a picture of a clip."""
    return np.rint(127.5 + 120 * np.cos(2 * np.pi * turns)).astype(np.uint8)


def _shown(how, badge, view=(0.0, 0.0, DISTANCE_MM)):
    """The picture of the only frame of a film from a view, 0 to 255."""
    u, v, d = view
    motion = motion_named("static", distance_mm=DISTANCE_MM, seed=0)
    film = how.shown(Scene(badge), motion, np.array([[u * d, v * d, -d]]), 30.0)
    return 255 * np.sqrt(film.picture(0))


def _middle(badge, rect, rim_mm=1.0):
    from true_films.replay import box_px

    return box_px(badge, rect, -rim_mm)


def test_a_donors_row_spells_every_cell_of_the_other_badge() -> None:
    """Catches: a map without the shift of a cell's lines or with the wrong sign, the donor's beat kept, and x for y."""
    from true_films.clip import Clip
    from true_films.rebadge import Rebadging
    from true_films.replay import along, beat_per_mm

    victim, donor = _badge(1), _badge(2)
    centre = np.array([sum(victim.outline_mm[0::2]), sum(victim.outline_mm[1::2])]) / 2
    places = _places(victim)

    def turns(cell, axis):
        beat = beat_per_mm(victim.lens, cell.pitch_mm, DISTANCE_MM)
        return places[axis] * beat - (cell.edge_mm - centre[axis]) / cell.pitch_mm

    picture = np.zeros(places.shape[1:], np.uint8)
    for grating in donor.gratings:
        box = _middle(donor, grating.rect_mm, -2)
        row = grating.cells[grating.code.reference_cell]
        picture[box] = _drawn(turns(row, along(grating)))[box]
    made = _shown(Rebadging(donor, Clip(picture[None], np.array([[0.0, 0.0, DISTANCE_MM]]))), victim)
    for grating in victim.gratings:
        for cell in grating.cells:
            box = _middle(victim, cell.rect_mm)
            wanted = _drawn(turns(cell, along(grating)))[box]
            assert np.quantile(np.abs(made[box] - wanted), 0.9) < 12


def test_each_field_is_taken_by_its_own_parallax() -> None:
    """Catches: one picture for both fields, and u for v."""
    from true_films.clip import Clip, board_size
    from true_films.replay import Replay

    badge = _badge(1)
    columns, rows = board_size(badge)
    shades = np.array([40, 120, 200], np.uint8)
    clip = Clip(
        np.broadcast_to(shades[:, None, None], (3, rows, columns)),
        np.array([[-0.1, 0.2, DISTANCE_MM], [0.0, -0.2, DISTANCE_MM], [0.1, 0.0, DISTANCE_MM]]),
    )
    made = _shown(Replay(clip, by_field=True), badge, (0.1, 0.2, DISTANCE_MM))
    assert [float(np.median(made[_middle(badge, one.rect_mm)])) for one in badge.gratings] == pytest.approx([200, 40])
    faded = _shown(Replay(clip, by_field=True, faded=True), badge, (0.025, 0.2, DISTANCE_MM))
    assert np.median(faded[_middle(badge, badge.gratings[0].rect_mm)]) == pytest.approx(140, abs=2)


def test_rows_are_stretched_to_the_fringes_of_another_distance() -> None:
    """Catches: a stretch the wrong way, about the wrong place, or by the same share where rows' beats differ."""
    from true_films.clip import Clip
    from true_films.replay import Replay, along, beat_per_mm

    badge, near_mm = _badge(1), 400.0
    places = _places(badge)

    def drawn(distance_mm):
        picture = np.zeros(places.shape[1:], np.uint8)
        for grating in badge.gratings:
            for cell in grating.cells:
                box = _middle(badge, cell.rect_mm, 0)
                picture[box] = _drawn(places[along(grating)] * beat_per_mm(badge.lens, cell.pitch_mm, distance_mm))[box]
        return picture

    clip = Clip(drawn(DISTANCE_MM)[None], np.array([[0.0, 0.0, DISTANCE_MM]]))
    wanted = drawn(near_mm)
    off = {
        stretched: np.abs(_shown(Replay(clip, stretched=stretched), badge, (0.0, 0.0, near_mm)) - wanted)
        for stretched in (False, True)
    }
    for grating in badge.gratings:
        for cell in grating.cells:
            box = _middle(badge, cell.rect_mm, 1.5)
            assert np.quantile(off[True][box], 0.8) < 15
    assert np.quantile(off[False][_middle(badge, badge.gratings[0].rect_mm)], 0.8) > 25
