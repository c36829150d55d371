"""How far the code's cells move, and how well that is known.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.identity.cell_slip import CellMotion, RowMotion, cell_motion_of

ROWS, CELLS = 8, 15
NONE = np.zeros((0, 0))


def motion_of(ratio: np.ndarray, expected: np.ndarray | None = None) -> CellMotion:
    """That of cells (rows, cells) that move by so much of the law."""
    expected = np.ones(ratio.shape) if expected is None else expected
    found = cell_motion_of([RowMotion(NONE, NONE, own * part, own) for part, own in zip(ratio, expected, strict=True)])
    assert found is not None
    return found


@pytest.mark.parametrize(("of_cells", "of_rows"), [(0.1, 0.0), (0.02, 0.05)])
def test_the_error_bar_is_the_scatter_of_what_it_is_of(rng, of_cells, of_rows):
    """Catches: an error bar of independent cells where rows differ as a whole; one of rows alone, of which there are
    few; a factor left out.  The deviation over the error bar has a spread of 1, or less where both kinds count.
    """
    draws = []
    for _ in range(300):
        ratio = 0.98 + rng.normal(0, of_cells, (ROWS, CELLS)) + rng.normal(0, of_rows, (ROWS, 1))
        found = motion_of(ratio)
        draws.append((found.typical - 0.98, found.sd))
    apart, sd = np.array(draws).T
    assert apart.std() / np.sqrt(np.mean(sd**2)) == pytest.approx(0.9, abs=0.2)


def test_a_hand_over_a_third_of_the_cells_changes_the_typical_one_little(rng):
    """Catches: covered cells, which stay still, held against a wearer."""
    ratio = 0.99 + rng.normal(0, 0.02, (ROWS, CELLS))
    ratio[:, :5] = 0.0
    found = motion_of(ratio)
    assert found.whole == pytest.approx(0.66, abs=0.01) and found.typical == pytest.approx(0.98, abs=0.02)


def test_cells_of_which_little_is_expected_count_little():
    """Catches: noise over no expected change counted as a cell's motion."""
    ratio, expected = np.ones((ROWS, CELLS)), np.ones((ROWS, CELLS))
    ratio[:, ::2], expected[:, ::2] = 9.0, 1e-3
    assert motion_of(ratio, expected).typical == pytest.approx(1.0, abs=0.01)


def test_where_the_rows_hardly_move_nothing_is_found():
    """Catches: a ratio of nothing to nothing."""
    assert cell_motion_of([RowMotion(NONE, NONE, np.full(1, 1e-6), np.full(1, 1e-6))]) is None
    assert cell_motion_of([]) is None
