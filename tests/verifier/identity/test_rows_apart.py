"""Whether the code's rows move with the plain ones.  Next to each test: the wrong implementation it catches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.parts import parts, parts_of
from moireid.verifier.identity.cell_slip import RowMotion, RowsApart, rows_apart

Array = NDArray[np.float64]
TIMES = np.arange(240) / 30
CELLS = 34


def row(rng: np.random.Generator, motion: Array, noise_rad: float) -> RowMotion:
    """Cells that all slip by `motion` (F,), each with noise of its own in every frame."""
    along = motion + rng.normal(0, noise_rad, (CELLS, len(TIMES)))
    return RowMotion(along, np.ones_like(along), np.ones(CELLS), np.ones(CELLS))


def level(apart: RowsApart, excitation_rad: float = 1.5) -> str:
    return parts(parts_of([Figures(excitation_rad=excitation_rad)], apart)).level


def test_noise_is_neither_accepted_nor_rejected(rng: np.random.Generator) -> None:
    """Catches: a true badge with small cells that is rejected as forged; noise that hides a motion and is accepted."""
    found = [rows_apart([row(rng, np.zeros(240), 7.0)], TIMES) for _ in range(100)]
    assert np.median([one.film for one in found]) > 0.25
    levels = [level(one) for one in found]
    assert "fail" not in levels and levels.count("undecided") > 90


@pytest.mark.parametrize("share", [0.4, 1.0, -1.0])
def test_a_row_with_a_motion_of_its_own_is_rejected(share: float, rng: np.random.Generator) -> None:
    """Catches: a still picture of the code between live rows; one at another gain."""
    motion = share * 1.5 * np.sqrt(2) * np.sin(2 * np.pi * TIMES / 4)
    found = rows_apart([row(rng, np.zeros(240), 1.0), row(rng, motion, 3.0)], TIMES)
    assert found.coherent > 0.2 and level(found) == "fail"


def test_a_row_that_is_clearer_than_the_plain_ones_is_counted_in_its_own_contrasts(rng: np.random.Generator) -> None:
    """Catches: a true badge rejected whose plain rows are washed out by a sheet laid askew, and the code's are not."""
    motion = 0.6 * np.sin(2 * np.pi * TIMES / 4)
    cells = row(rng, motion, 0.5)
    assert level(rows_apart([cells], TIMES)) == "fail"
    assert level(rows_apart([cells._replace(moved=10 * cells.moved)], TIMES)) == "undecided"


def test_neighbours_that_move_in_opposite_ways_are_not_accepted(rng: np.random.Generator) -> None:
    """Catches: deviations that cancel in a row's mean."""
    motion = 0.6 * np.sin(2 * np.pi * TIMES / 4)
    cells = row(rng, motion, 0.5)
    opposite = cells._replace(along=cells.along * np.resize([-1.0, 1.0], CELLS)[:, None])
    assert level(rows_apart([opposite], TIMES)) != "pass"
