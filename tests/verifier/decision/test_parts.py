"""Whether the parts of the badge move as one.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import pytest

from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.parts import Part, parts, parts_of
from moireid.verifier.identity.cell_slip import TOGETHER, RowsApart
from moireid.verifier.limits import PARTS, PROOF_SDS, USUAL_SDS

FILM = Figures(excitation_rad=0.8, strip_wander_rad=0.01, place_wander_rad=0.02)


def apart(figures: Figures, name: str, size: float) -> Figures:
    """Figures of a film whose strips, or places, move apart, which noise does not explain."""
    return replace(figures, **{f"{name}_wander_rad": size, f"{name}_beyond_rad": size})


def test_the_limits_are_rates_of_false_alarm():
    """Catches: limits of one figure for four; one side counted as two."""
    one, proof = (4 * (1 - NormalDist().cdf(sds)) for sds in (USUAL_SDS, PROOF_SDS))
    assert one == pytest.approx(1e-3, rel=0.01) and proof == pytest.approx(1e-5, rel=0.05)


def test_all_parts_are_compared():
    """Catches: a deviation that is measured and never compared."""
    found = parts_of([FILM], TOGETHER)
    assert [one.name for one in found] == list(PARTS) and parts(found).level == "pass"


@pytest.mark.parametrize(("name", "size"), [("strip", 0.03), ("place", 0.045)])
@pytest.mark.parametrize(("times", "level"), [(1.0, "pass"), (2.2, "undecided"), (10.0, "fail")])
def test_one_part_that_moves_apart_decides(name, size, times, level):
    """Catches: a mean over parts; a part that is not proven that rejects."""
    assert parts(parts_of([FILM, apart(FILM, name, times * size)], TOGETHER)).level == level


@pytest.mark.parametrize("name", ["strip", "place"])
def test_pale_fringes_make_rows_vague_and_not_forged(name):
    """Catches: noise of pale fringes taken for rows that move apart; an error bar that excuses any error."""
    pale = apart(replace(FILM, strip_sd_rad=0.15), name, 0.15)
    assert parts(parts_of([pale], TOGETHER)).level == "pass"
    coded = replace(FILM, rounding_rad=0.2)
    assert parts(parts_of([apart(coded, name, 0.12)], TOGETHER)).level == "pass"
    # Nearly half of the motion, which noise must not buy.
    for noisy in (pale, coded):
        assert parts(parts_of([apart(noisy, name, 0.3)], TOGETHER)).level == "undecided"
    assert parts(parts_of([apart(pale, name, 0.8)], TOGETHER)).level == "fail"


def test_the_code_proves_by_what_halves_of_a_row_share_alone():
    """Catches: noise of small cells that rejects; a hand over the code taken for a forgery."""
    noisy, moved = RowsApart(0.5, 0.8, 0.0), RowsApart(0.5, 0.8, 0.5)
    assert parts(parts_of([FILM], noisy)).level == "undecided"
    assert parts(parts_of([FILM], moved)).level == "fail"
    assert parts(parts_of([FILM], moved, covered=True)).level == "undecided"


def test_where_a_film_proves_nothing_no_part_does():
    """Catches: a tiny badge, or one of another size, rejected."""
    torn = [Part("rows", 9.0, 0.1, 9.0, 0.2)]
    assert parts(torn).level == "fail" and parts(torn, prove=False).level == "undecided"
