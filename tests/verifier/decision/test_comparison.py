"""The table of explanations.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from kit.fringe_signals import FRAMES, apart_from, clock, fringe_signal, lasting_noise, trajectory
from moireid.verifier.decision.comparison import GratingComparison, compare, film_table, law_row, merge_chapters
from moireid.verifier.decision.doubts import camera_doubted
from moireid.verifier.decision.figures import Figures
from moireid.verifier.decision.judge import judge
from moireid.verifier.decision.sheet_gain import DESIGNED
from moireid.verifier.explanations.table import Explanation
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import (
    LEAST_STRENGTH,
    MAX_LASTING_PX,
    MAX_MIXED_SHARE,
    MAX_RIVAL_LOG10,
    OWN_MOTION,
    PROOF_SDS,
    USUAL_SDS,
)

LAW = 1.2 * trajectory()
ROWS = ["still", "drift", "late", "place", "another_gain", "own_motion", "spell"]


def true_film(law: np.ndarray = LAW, **how) -> GratingSignal:
    return fringe_signal(law, law + lasting_noise(len(law)), **how)


def row(name: str, odds: float | None = None, share: float | None = None) -> Explanation:
    remains = (odds is not None and odds < -MAX_RIVAL_LOG10) or (share is not None and share > 1 / LEAST_STRENGTH)
    return Explanation(name, odds, {}, share, remains, share)


def grating(*rows: Explanation, information: float = 1.0, residual: float = 0.0) -> GratingComparison:
    figures = replace(Figures(), information=information, gain_ratio=1.0)
    return GratingComparison(figures, True, residual, 1.0, 2.0, rivals=rows)


# One grating.


def test_a_true_film_s_table_holds_each_rival_and_none_remains():
    """Catches: a rival that is left out, or that is compared with the rest of its own kind alone."""
    found = compare(true_film(), DESIGNED)
    assert [one.name for one in found.rivals] == ROWS
    assert found.moved and found.fits and found.possible
    assert not any(one.fits or one.better_than_law for one in found.rivals)
    assert set(found.nuisances_rad or {}) == {"lag", "bend", "zoom", "axis", "axis_turn"}
    assert 0.004 < found.deviation_rad < 0.01


def test_the_limit_of_what_is_possible_grows_with_the_doubt_of_small_markers():
    """Catches: a doubt that widens what is accepted; one that widens nothing."""
    sure, doubtful = (compare(true_film(phase_sd=0.05, doubt=doubt), DESIGNED) for doubt in (1.0, 2.6))
    assert doubtful.limit_rad == sure.limit_rad
    wider = OWN_MOTION.quantile(PROOF_SDS, 1.0) / OWN_MOTION.quantile(USUAL_SDS, 1.0)
    assert sure.possible_rad == pytest.approx(wider * sure.limit_rad)
    assert doubtful.possible_rad > 1.8 * sure.possible_rad


def test_a_film_may_leave_what_lens_and_sheet_err_by_and_no_share_of_its_motion():
    """Catches: errors that last taken for a wander; room that grows with the motion, whatever the film shows."""
    much, more, lens, aside = (
        compare(true_film(times * LAW, **how), DESIGNED).limit_rad
        for times, how in (
            (1, {}),
            (2, {}),
            (1, {"shape_sd_rad": 0.03}),
            (1, {"aside_share": 1.0}),
        )
    )
    assert much == pytest.approx(more)
    assert lens == pytest.approx(math.hypot(much, OWN_MOTION.quantile(USUAL_SDS, 0.03)))
    assert aside == pytest.approx(math.hypot(much, OWN_MOTION.quantile(USUAL_SDS, 0.02 * float(LAW.std()))), rel=0.01)


@pytest.mark.parametrize(
    "sign",
    [{"lasting_px": 1.1 * MAX_LASTING_PX}, {"mixed_share": 1.1 * MAX_MIXED_SHARE}, {"zoom": 1.01}],
    ids=["camera", "mixed", "zoom"],
)
def test_a_doubted_camera_widens_what_is_possible_and_nothing_else(sign):
    """Catches: a doubt that makes a film pass; a sign that is not looked at."""
    assert not camera_doubted(true_film()) and camera_doubted(true_film(**sign))
    sure, doubted = (compare(true_film(), DESIGNED, doubted=doubt) for doubt in (False, True))
    assert doubted.doubted and not sure.doubted
    assert doubted.limit_rad == sure.limit_rad and doubted.possible_rad > 2 * sure.possible_rad


def test_a_lie_of_a_second_is_a_row_with_its_time_and_gain():
    """Catches: a spell without its place; one that counts as odds for the law where none is found."""
    lie = LAW + lasting_noise()
    lie[150:166] += LAW[150] - LAW[150:166]
    (spell,) = [one for one in compare(fringe_signal(LAW, lie), DESIGNED).rivals if one.name == "spell"]
    assert spell.better_than_law and spell.fits and spell.parameters["gain"] == 0.0
    assert spell.parameters["start_s"] < 5.2 < 5.3 < spell.parameters["end_s"] + 0.1


# The score.


def test_the_score_is_the_odds_over_the_mean_of_the_rivals():
    """Catches: the product of all odds; the best rival alone.  Closed form."""
    assert grating(row("still", 3.0), row("drift", 3.0)).score == pytest.approx(3.0)
    two = grating(row("still", 1.0), row("drift", 50.0)).score
    assert two == pytest.approx(1.0 + math.log10(2))
    assert grating(row("still", -400.0), row("drift", 400.0)).score == pytest.approx(-400 + math.log10(2))


@pytest.mark.parametrize("name", ["own_motion", "spell"])
def test_a_rival_that_contains_the_law_lowers_the_score_and_never_raises_it(name):
    """Catches: a film that scores higher because nothing leaves the law for a while."""
    assert grating(row("still", 3.0), row(name, 9.0)).score == pytest.approx(3.0)
    assert grating(row("still", 3.0), row(name, -2.0)).score == pytest.approx(-2.0, abs=0.01)
    assert grating(row("still", 3.0), row(name, -0.9)).score == pytest.approx(3.0)
    assert grating(row(name, -2.0)).score == 0.0


def test_the_score_falls_with_every_departure():
    """Catches: a score that does not rise with genuineness; a departure that it does not see."""
    white = lasting_noise(lasting=0.0, size=1.0)
    departures = [
        [fringe_signal(LAW, gain * LAW + 0.01 * white) for gain in (1.0, 1.1, 1.3, 1.6)],
        [fringe_signal(LAW, gain * LAW + 0.01 * white) for gain in (1.0, 0.9, 0.7, 0.4)],
        [fringe_signal(LAW, LAW + share * apart_from(LAW) + 0.01 * white) for share in (0.0, 0.1, 0.2, 0.5)],
    ]
    for signals in departures:
        scores = [compare(one, DESIGNED, shares=False).score for one in signals]
        assert scores == sorted(scores, reverse=True) and len(set(scores)) == len(scores)
        assert scores[0] > 20


# A film of several gratings.


def test_a_rival_counts_where_it_does_best_and_looks_alike_only_in_every_grating():
    """Catches: odds of the first grating; a drift that one grating excludes kept for the other."""
    steady = grating(row("drift", 0.1, 0.06), row("late", 0.2, 1.0), information=9.0)
    varied = grating(row("drift", 40.0, 0.0), row("late", -5.0, 0.5))
    still = replace(grating(row("drift", -9.0, 1.0)), moved=False)
    drift, late = film_table([steady, varied, still])
    assert (drift.name, drift.log10_odds, drift.share, drift.fits) == ("drift", 0.1, 0.0, False)
    assert (late.name, late.log10_odds, late.share, late.fits) == ("late", -5.0, 0.5, True)
    assert film_table([varied, steady])[0].share == 0.0


def test_a_drift_that_fits_each_chapter_as_well_as_the_law_remains_over_all_of_them():
    """Catches: odds that add up over chapters until they hide a drift of each; one that a chapter excludes kept."""
    drift = replace(row("drift", 0.5, 0.01), as_good=True)
    steady, varied = grating(drift), grating(row("drift", 40.0, 0.0))
    merged = merge_chapters([steady] * 5, steady.figures)
    (over_film,) = film_table([merged, merged])
    assert over_film.log10_odds == 2.5 and over_film.fits
    assert not film_table([merged, varied])[0].fits
    assert not merge_chapters([steady, varied], steady.figures).rivals[0].fits


def test_the_law_s_row_is_of_the_grating_that_holds_most_and_fits_where_all_do():
    """Catches: one grating that speaks for another that leaves the law."""
    good, bad = grating(information=9.0, residual=0.5), grating(residual=1.5)
    assert law_row([bad, good]).parameters["deviation_rad"] == 0.5
    assert law_row([good]).fits and not law_row([good, bad]).fits
    assert law_row([good, replace(bad, moved=False)]).fits
    assert not law_row([replace(good, moved=False)]).fits


# Extremes.


def one_short_stretch() -> GratingSignal:
    return true_film(stretch=np.repeat([0, 1, 2], [150, 3, 147]))


EXTREMES = {
    "60 frames": lambda: true_film(LAW[:60]),
    "a stretch of 3 frames": one_short_stretch,
    "only stretches of 3 frames": lambda: true_film(stretch=np.arange(FRAMES) // 3),
    "no frame readable": lambda: true_film(phase_sd=np.inf),
    "31 frames readable": lambda: true_film(phase_sd=np.where(np.arange(FRAMES) < 31, 0.02, np.inf)),
    "constant law": lambda: fringe_signal(np.zeros(FRAMES), lasting_noise()),
    "constant law and measurement": lambda: fringe_signal(np.ones(FRAMES), np.ones(FRAMES)),
    "each time twice": lambda: true_film(times_s=np.repeat(clock(150), 2)),
    "one time": lambda: true_film(times_s=np.zeros(FRAMES)),
    "times of 1970": lambda: true_film(times_s=1.7e9 + clock()),
    "without error": lambda: fringe_signal(LAW, LAW, phase_sd=1e-4, pose_sd=0.0),
    "of a still picture": lambda: fringe_signal(LAW, np.zeros(FRAMES)),
    "a thousand turns": lambda: fringe_signal(1e4 * LAW, 1e4 * LAW),
    "wild measurement": lambda: fringe_signal(LAW, 1e9 * lasting_noise()),
    "wild error bars": lambda: true_film(phase_sd=np.where(np.arange(FRAMES) % 2, 1e-12, 1e9)),
    "at rest in the picture": lambda: true_film(place_px=np.full((FRAMES, 2), 640.0)),
    "one view": lambda: true_film(covariates=np.full((FRAMES, 2), 0.25)),
}


@pytest.mark.parametrize("name", list(EXTREMES))
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_extreme_signals_give_finite_figures(name, whole):
    """Catches: NaN, a division by 0, an overflow, in any figure of the film."""
    outcome = judge([EXTREMES[name]()], whole=whole)
    json.dumps([outcome.to_json(), *(one.to_json() for one in outcome.explanations)], allow_nan=False)
    figures = [outcome.score, outcome.calibrated_log10, outcome.gain_ratio, outcome.phase_residual_rad]
    figures += [one.log10_odds for one in outcome.explanations] + [one.share for one in outcome.explanations]
    figures += [value for one in outcome.explanations for value in one.parameters.values()]
    assert all(math.isfinite(value) for value in figures if value is not None)
    assert outcome.verdict in ("accept", "reject", "inconclusive")


def an_hour(**how) -> GratingSignal:
    frames = 108_000
    law = 1.2 * trajectory(frames=frames)
    return fringe_signal(law, law + lasting_noise(frames), **how)


def test_an_hour_of_chapters_is_accepted_with_all_their_evidence():
    """Catches: blocks so long that a hand's motion is averaged away in them, and rivals look like what is left."""
    film, minute = an_hour(), 1800
    chapters = [judge([film.part(slice(k, k + minute))]) for k in range(0, 10 * minute, minute)]
    joined = film.part(slice(0, 10 * minute))
    outcome = judge([joined], chapters=[chapter.compared for chapter in chapters])
    assert {chapter.verdict for chapter in chapters} == {"accept"} and outcome.verdict == "accept"
    assert (outcome.score or 0) > max(chapter.score or 0 for chapter in chapters)


# Several chapters.


def test_a_spell_of_one_chapter_is_a_spell_of_the_film():
    """Catches: a lie of a second averaged away by the minutes around it; tries that are not counted."""
    parts = [grating(row("spell", 5.0)), grating(row("spell", -6.0)), *[grating(row("still", 9.0))] * 8]
    spell = next(one for one in merge_chapters(parts, parts[0].figures).rivals if one.name == "spell")
    assert spell.log10_odds == pytest.approx(-6.0 + 1.0) and spell.fits


@pytest.mark.parametrize("law", [trajectory(frames=900), 0.4 * trajectory(3, 900), 1.2 * trajectory(4, 900)])
def test_a_longer_signal_is_not_worse_than_its_parts(law):
    """Catches: shares or limits that grow with the length of a film."""
    film = fringe_signal(law, law + lasting_noise(900, 0.02))
    parts = [compare(film.part(slice(300 * k, 300 * k + 300)), DESIGNED) for k in range(3)]
    whole = compare(film, DESIGNED)
    assert whole.fits and whole.score > max(part.score for part in parts)
    for index, one in enumerate(whole.rivals):
        shares = [part.rivals[index].share for part in parts]
        assert one.share is None or one.share <= max(share or 0.0 for share in shares) + 0.005
    assert judge([film]).verdict == "accept"
