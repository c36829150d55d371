"""The link budget: closed forms, and the films that it was measured on.  Each test names the fault that it catches."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.designer import Order, design_badge
from moireid.designer.reach import CALL, CHAT, PHONE, Read, Receiver, found_share, read_of
from moireid.idcodes.spacing import decode_phases, word_places
from moireid.idcodes.words import WordCode

WORD = WordCode(8, 26)
BOARD = Read(8.89, 26.0, WORD)
#: Of two to five films of eight seconds each: receiver, distance, m, files read, films, median phase error, rad.
FILMS = [
    (PHONE, 1.0, 2, 2, 0.008),
    (PHONE, 3.0, 2, 2, 0.044),
    (PHONE, 3.5, 2, 2, 0.074),
    (PHONE, 4.0, 2, 2, 0.105),
    (CALL, 1.5, 2, 2, 0.0115),
    (CALL, 2.4, 3, 3, 0.057),
    (CHAT, 1.0, 2, 2, 0.018),
    (CHAT, 1.5, 2, 2, 0.053),
]


@pytest.mark.parametrize(("receiver", "metres", "read", "films", "error_rad"), FILMS)
def test_the_budget_says_what_films_showed(receiver: Receiver, metres: float, read: int, films: int, error_rad: float):
    """Catches: a power, a pixel figure or a focal length of another receiver."""
    link = BOARD.at(metres, receiver)
    assert link.phase_error_rad == pytest.approx(error_rad, rel=0.55)
    assert link.decode_probability > 0.95 or read < films


def test_the_share_falls_with_distance_and_rises_with_parity_and_cells():
    """Catches: a chance that ignores the word, the cells or the markers."""
    shares = [BOARD.at(metres).decode_probability for metres in np.linspace(0.3, 8, 60)]
    assert np.all(np.diff(shares) <= 1e-12)
    big = 1000.0
    small = Read(2.4, big, WORD).at(2.0).decode_probability
    assert 0.05 < small < 0.95
    assert Read(2.4, big, WordCode(8, 17)).at(2.0).decode_probability < small
    assert Read(2.6, big, WORD).at(2.0).decode_probability > small
    assert Read(20.0, 11.0, WORD).at(2.0).decode_probability == pytest.approx(found_share(7.975), rel=1e-3)


@pytest.mark.parametrize(("error_rad", "least", "most"), [(0.36, 0.9, 1.0), (0.54, 0.0, 0.15)])
def test_words_are_read_as_the_budget_counts(error_rad: float, least: float, most: float):
    """Catches: a decoder that has become better or worse than the budget's figure of 0.45 rad for half of the words."""
    rng, read = np.random.default_rng(5), 0
    for _ in range(30):
        payload = rng.bytes(8)
        phases = 2 * np.pi * np.array(word_places(WORD, payload)) / 4 + rng.normal(0, error_rad, 104)
        read += decode_phases(WORD, phases, np.full(104, error_rad)) == payload
    assert least <= read / 30 <= most


def test_what_is_read_of_a_badge_is_its_smallest_cell():
    """Catches: the first cell's width alone."""
    badge = design_badge(Order("A", lens="50lpi", axes="xy"), bytes(8))
    read = read_of(badge)
    assert read is not None
    sides = [
        c.rect_mm[k + 2] - c.rect_mm[k]
        for g in badge.gratings
        for c, role in zip(g.cells, g.code.roles, strict=True)  # type: ignore[union-attr]
        if role == "phase"
        for k in (0, 1)
    ]
    assert read.cell_mm == min(sides)
    assert read.word.payload_bytes == 8
