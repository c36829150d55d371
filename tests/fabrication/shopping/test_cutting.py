"""The cutting plan against every guillotine cutting, by brute force."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from moireid.errors import FabricationError
from moireid.fabrication.shopping.cutting import TRIM_MM, CuttingPlan, Pieces, plan_cutting


def most_by_guillotine(wide: int, high: int, piece: tuple[int, int]) -> int:
    """The most pieces that any guillotine cutting of a sheet gives, found by trying every cut at whole millimetres."""

    @cache
    def most(width: int, height: int) -> int:
        if width < piece[0] or height < piece[1]:
            return 0
        best = 1
        for cut in range(1, width // 2 + 1):
            best = max(best, most(cut, height) + most(width - cut, height))
        for cut in range(1, height // 2 + 1):
            best = max(best, most(width, cut) + most(width, height - cut))
        return best

    return most(wide, high)


def check_plan(plan: CuttingPlan) -> None:
    """Every piece is cut, in its size and not turned, and each strip and each sheet has room for what is on it."""
    wide, high = (side - 2 * TRIM_MM + 1e-6 for side in plan.sheet_mm)
    made = dict.fromkeys(((piece.across_mm, piece.along_mm) for piece in plan.pieces), 0)
    for strips, count in plan.sheets:
        assert sum(strip.along_mm for strip in strips) <= high
        for strip in strips:
            assert strip.count * strip.across_mm <= wide
            made[strip.across_mm, strip.along_mm] += strip.count * count
    assert made == {(piece.across_mm, piece.along_mm): piece.count for piece in plan.pieces}


@pytest.mark.parametrize("piece", [(3, 2), (2, 3), (5, 4), (7, 7), (11, 3), (20, 1), (4, 9)])
@pytest.mark.parametrize("size", [(20, 30), (23, 31), (30, 20), (11, 29)])
def test_no_cutting_gives_more_pieces_of_one_size(size: tuple[int, int], piece: tuple[int, int]) -> None:
    """Catches: a grid that is off by one; a plan that wastes a row; a piece that is turned to fit more."""
    most = most_by_guillotine(*size, piece)
    sheet_mm = (10.0 * size[0] + 2 * TRIM_MM, 10.0 * size[1] + 2 * TRIM_MM)
    if most == 0:
        with pytest.raises(FabricationError, match="does not fit"):
            plan_cutting([Pieces(10.0 * piece[0], 10.0 * piece[1], 1)], sheet_mm)
        return
    for count in (1, most, most + 1, 3 * most - 1):
        plan = plan_cutting([Pieces(10.0 * piece[0], 10.0 * piece[1], count)], sheet_mm)
        assert plan.sheet_count == -(-count // most)
        check_plan(plan)


def test_several_sizes_share_sheets_and_are_all_cut() -> None:
    """Catches: strips of several sizes that overlap, or are spread over sheets without need."""
    rng = np.random.default_rng(5)
    for _ in range(25):
        wide, high = (10.0 * rng.integers(6, 12, 2)).tolist()
        sizes = {(10.0 * rng.integers(2, wide / 10 + 1), 10.0 * rng.integers(2, high / 10 + 1)) for _ in range(2)}
        pieces = [Pieces(*size, int(rng.integers(1, 9))) for size in sizes]
        plan = plan_cutting(pieces, (wide + 2 * TRIM_MM, high + 2 * TRIM_MM))
        check_plan(plan)
        alone = [plan_cutting([piece], plan.sheet_mm).sheet_count for piece in pieces]
        area = sum(piece.across_mm * piece.along_mm * piece.count for piece in pieces)
        assert area / (wide * high) <= plan.sheet_count <= sum(alone)
    both = plan_cutting([Pieces(73, 89, 4), Pieces(89, 73, 2)], (210.0, 297.0))
    assert both.sheet_count == 1
