"""The cutting plan against a brute-force packing, and against scissors that cut from edge to edge."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest

from moireid.badge import Rect
from moireid.errors import FabricationError
from moireid.fabrication.shopping.cutting import CutSheet, CuttingPlan, LensPiece, StockSheet, plan_cutting, with_spare


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


def fewest_sheets(sizes: list[tuple[int, int]], wide: int, high: int) -> int:
    """The fewest sheets for a few pieces of any sizes, by every choice of pieces for a sheet and every cut.

    A set of pieces fits a sheet if it is one piece that fits, or if a cut parts it into two sets that fit.
    """

    @cache
    def fits(some: tuple[tuple[int, int], ...], width: int, height: int) -> bool:
        if len(some) == 1:
            return some[0][0] <= width and some[0][1] <= height
        for count in range(1, len(some)):
            for chosen in itertools.combinations(range(len(some)), count):
                one = tuple(some[k] for k in chosen)
                rest = tuple(some[k] for k in range(len(some)) if k not in chosen)
                if any(fits(one, cut, height) and fits(rest, width - cut, height) for cut in range(1, width)):
                    return True
                if any(fits(one, width, cut) and fits(rest, width, height - cut) for cut in range(1, height)):
                    return True
        return False

    @cache
    def sheets(some: tuple[tuple[int, int], ...]) -> int:
        if not some:
            return 0
        best = len(some)
        for count in range(1, len(some) + 1):
            for chosen in itertools.combinations(range(1, len(some)), count - 1):
                one = (some[0], *(some[k] for k in chosen))
                if fits(one, wide, high):
                    rest = tuple(some[k] for k in range(1, len(some)) if k not in chosen)
                    best = min(best, 1 + sheets(rest))
        return best

    return sheets(tuple(sizes))


def cut_apart(sheet: StockSheet, how: CutSheet) -> list[Rect]:
    """The parts after all cuts, in their order; each must cross the whole part that it cuts.

    Raises: AssertionError for a cut that ends inside a part, or crosses more than one.
    """
    parts: list[Rect] = [(0.0, 0.0, sheet.across_mm, sheet.along_mm)]
    assert [cut.number for cut in how.cuts] == list(range(1, len(how.cuts) + 1))
    for cut in how.cuts:
        x0, y0, x1, y1 = cut.line
        level, half = math.isclose(y0, y1), sheet.cut_mm / 2
        hit = []
        for part in parts:
            inside = part[1] < y0 < part[3] if level else part[0] < x0 < part[2]
            along = (part[0], part[2], x0, x1) if level else (part[1], part[3], y0, y1)
            overlap = min(along[1], along[3]) - max(along[0], along[2])
            # What a cut takes away is already gone, so a cut may end in the middle of an earlier one.
            if inside and overlap > half + 1e-6:
                assert along[2] <= along[0] + 1e-6 and along[3] >= along[1] - 1e-6, "a cut ends inside a part"
                hit.append(part)
        assert len(hit) == 1, "a cut goes through no part, or through several"
        (part,) = hit
        parts.remove(part)
        if level:
            parts += [(part[0], part[1], part[2], y0 - half), (part[0], y0 + half, part[2], part[3])]
        else:
            parts += [(part[0], part[1], x0 - half, part[3]), (x0 + half, part[1], part[2], part[3])]
    return parts


def check_plan(plan: CuttingPlan) -> None:
    """Every piece comes off the sheet as a part of its own, in its size and not turned; none overlaps another."""
    sizes = {piece.name: (piece.across_mm, piece.along_mm) for piece in plan.wanted}
    made = dict.fromkeys(sizes, 0)
    for how in plan.sheets:
        parts = cut_apart(plan.sheet, how)
        for name, rect in how.pieces:
            made[name] += how.count
            # The lenses run along y in the sheet's frame, and so they do in the piece: across first.
            assert (rect[2] - rect[0], rect[3] - rect[1]) == pytest.approx(sizes[name])
            assert any(rect == pytest.approx(part, abs=1e-6) for part in parts), f"{rect} is not cut free"
            trim = plan.sheet.trim_mm - 1e-6
            assert trim <= rect[0] and rect[2] <= plan.sheet.across_mm - trim
            assert trim <= rect[1] and rect[3] <= plan.sheet.along_mm - trim
        for (_, one), (_, other) in itertools.combinations(how.pieces, 2):
            apart = one[2] <= other[0] + 1e-6 or other[2] <= one[0] + 1e-6
            assert apart or one[3] <= other[1] + 1e-6 or other[3] <= one[1] + 1e-6
    assert made == {piece.name: piece.count for piece in plan.wanted}


@pytest.mark.parametrize("piece", [(3, 2), (2, 3), (5, 4), (7, 7), (11, 3), (20, 1), (4, 9)])
@pytest.mark.parametrize("size", [(20, 30), (23, 31), (30, 20), (11, 29)])
def test_no_cutting_gives_more_pieces_of_one_size(size: tuple[int, int], piece: tuple[int, int]) -> None:
    """Catches: a grid that is off by one; a plan that wastes a row; a piece that is turned to fit more."""
    most = most_by_guillotine(*size, piece)
    scale = 10.0
    sheet = StockSheet(scale * size[0], scale * size[1], trim_mm=0.0)
    if most == 0:
        with pytest.raises(FabricationError, match="does not fit"):
            plan_cutting([LensPiece("piece", scale * piece[0], scale * piece[1], 1)], sheet)
        return
    for count in (1, most, most + 1, 3 * most - 1):
        plan = plan_cutting([LensPiece("piece", scale * piece[0], scale * piece[1], count)], sheet)
        assert plan.sheet_count == -(-count // most)
        assert plan.most_pieces == min(most, count)
        check_plan(plan)


def test_several_sizes_take_no_more_than_a_sheet_above_the_best() -> None:
    """Catches: strips of several sizes that overlap, or are spread over sheets without need."""
    rng = np.random.default_rng(5)
    above = 0
    for _ in range(25):
        wide, high = (int(side) for side in rng.integers(6, 12, 2))
        kinds = [(int(rng.integers(2, wide + 1)), int(rng.integers(2, high + 1))) for _ in range(2)]
        counts = [int(count) for count in rng.integers(1, 4, 2)]
        best = fewest_sheets(
            [kind for kind, count in zip(kinds, counts, strict=True) for _ in range(count)], wide, high
        )
        pieces = [
            LensPiece(f"piece {k}", 10.0 * a, 10.0 * b, n)
            for k, ((a, b), n) in enumerate(zip(kinds, counts, strict=True))
        ]
        plan = plan_cutting(pieces, StockSheet(10.0 * wide, 10.0 * high, trim_mm=0.0))
        check_plan(plan)
        assert best <= plan.sheet_count <= best + 1, (kinds, counts, wide, high)
        above += plan.sheet_count - best
    assert above <= 5


@pytest.mark.parametrize("cut_mm", [0.0, 2.5])
@pytest.mark.parametrize("trim_mm", [0.0, 3.0, 12.0])
def test_cuts_reach_from_edge_to_edge_whatever_they_take_away(cut_mm: float, trim_mm: float) -> None:
    """Catches: a cut that ends inside the sheet; one that runs through a piece; a saw's width that a piece lacks."""
    sheet = StockSheet(305.0, 457.0, trim_mm, cut_mm)
    check_plan(plan_cutting([LensPiece("piece", 85.6, 28.0, 47)], sheet))
    check_plan(plan_cutting([LensPiece("piece A", 85.6, 28.0, 31), LensPiece("piece B", 40.0, 60.5, 9)], sheet))


def test_a_piece_is_never_turned_even_where_it_would_fit() -> None:
    """Catches: lenses that would run across the badge, where its fringes show no motion; advice that does not help."""
    piece, sheet = LensPiece("piece", 210.0, 89.0, 3), StockSheet(200.0, 300.0)
    with pytest.raises(FabricationError, match="--sheet-size 300x200"):
        plan_cutting([piece], sheet)
    assert plan_cutting([piece], sheet.turned).sheet_count == 2
    with pytest.raises(FabricationError, match="give a larger sheet"):
        plan_cutting([piece], StockSheet(100.0, 100.0))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: StockSheet(5.0, 297.0), "is not sold"),
        (lambda: StockSheet(math.nan, 297.0), "is not sold"),
        (lambda: StockSheet(210.0, 297.0, trim_mm=-1.0), "trim"),
        (lambda: StockSheet(210.0, 297.0, cut_mm=math.inf), "cut width"),
        (lambda: plan_cutting([], StockSheet(210.0, 297.0)), "no piece"),
        (lambda: plan_cutting([LensPiece("piece", 10, 10, 200_000)], StockSheet(210.0, 297.0)), "too many"),
    ],
)
def test_impossible_sheets_are_refused(make, words: str) -> None:
    """Catches: a sheet without size, cuts of negative width, and plans that would take hours, taken in silence."""
    with pytest.raises(FabricationError, match=words):
        make()


def test_the_spare_share_is_rounded_up_and_exact() -> None:
    """Catches: a spare that is lost in rounding, or one too many because a share in decimals is a little more."""
    assert [with_spare(count, 0.05) for count in (1, 20, 21, 40, 100)] == [2, 21, 23, 42, 105]
    assert with_spare(7, 0.0) == 7 and with_spare(100, 0.07) == 107
