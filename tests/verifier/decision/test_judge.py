"""The motion invariant on made-up signals.  Each docstring names the wrong code that the test would catch."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kit.fringe_signals import (
    FRAMES,
    PHASE_SD,
    POSE_SD,
    apart_from,
    clock,
    fringe_signal,
    lasting_noise,
    trajectory,
)
from moireid.lenticule import view_law
from moireid.sheets import PRODUCTS
from moireid.verifier.decision.comparison import compare
from moireid.verifier.decision.judge import Invariant, gain_of, judge
from moireid.verifier.decision.sheet_gain import DESIGNED, SheetGain
from moireid.verifier.explanations.residuals import residual_limit_rad
from moireid.verifier.explanations.strength import one_in
from moireid.verifier.explanations.table import Explanation
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal
from moireid.verifier.fringes.strip_law import air_law
from moireid.verifier.limits import (
    LEAST_BUILT_GAIN,
    LEAST_STRENGTH,
    MAX_LASTING_PX,
    MAX_RIVAL_LOG10,
    MIN_EXCITATION_RAD,
    PROOF_SDS,
)

EXCITATION = 1.2
LAW = EXCITATION * trajectory()
SWEEP = 0.6 * (clock() - clock().mean())
#: A badge that was measured when it was enrolled.
BUILT = SheetGain(built=True, handled=(0.8, 1.3))
#: What the findings of a film that is accepted are about.
ACCEPTED = {"motion", "gain", "residual", "parts", "explanations"}


def levels(outcome: Invariant) -> dict[str, str]:
    return {reason.code: reason.level for reason in outcome.reasons}


def failed(outcome: Invariant) -> list[str]:
    return [code for code, level in levels(outcome).items() if level not in ("pass", "note")]


def named(outcome: Invariant) -> list[str]:
    """Codes of the rivals that the findings name."""
    rivals = {one.name for one in outcome.explanations}
    return [reason.code for reason in outcome.reasons if reason.code in rivals]


def white(law: np.ndarray) -> np.ndarray:
    """White noise of standard deviation 1, whose correlation with the law is 0."""
    noise = np.random.default_rng(6).standard_normal(len(law))
    noise -= noise.mean() + law * (noise @ law) / (law @ law)
    return noise / noise.std()


def true_film(law: np.ndarray = LAW, **how) -> GratingSignal:
    return fringe_signal(law, law + lasting_noise(len(law)), **how)


# Accepted.


@pytest.mark.claim("Signals that obey the law are accepted")
def test_a_true_film_is_accepted():
    """Catches: a test that nothing passes; a sign turned round on the way."""
    outcome = judge([true_film()])
    assert outcome.verdict == "accept" and failed(outcome) == [] and levels(outcome).keys() == ACCEPTED
    assert outcome.gain_ratio == pytest.approx(1.0, abs=0.01) and outcome.correlation > 0.999
    assert outcome.excitation_rad == pytest.approx(EXCITATION) and outcome.score > 3 * MAX_RIVAL_LOG10
    assert outcome.phase_residual_rad == pytest.approx(0.01, rel=0.2)
    assert outcome.law_fits and outcome.explanations[0].name == "law" and outcome.explanations[0].fits


@pytest.mark.parametrize("seed", range(2, 8))
@pytest.mark.parametrize("noise", [0.005, 0.02])
def test_true_films_of_any_hand_are_accepted(seed, noise):
    """Catches: limits that hold on one trajectory alone."""
    law = 0.9 * trajectory(seed)
    outcome = judge([fringe_signal(law, law + lasting_noise(size=noise, seed=seed))])
    assert outcome.verdict == "accept", failed(outcome)


def test_an_offset_or_turns_of_the_phase_change_nothing():
    """Catches: a constant of assembly that enters the verdict."""
    here = true_film()
    there = replace(here, measured_rad=here.measured_rad + 40.0, predicted_rad=here.predicted_rad - 7.0)
    one, two = judge([here]), judge([there])
    for name in ("correlation", "gain_ratio", "phase_residual_rad", "excitation_rad", "score"):
        assert getattr(one, name) == pytest.approx(getattr(two, name), rel=1e-6), name


@pytest.mark.parametrize(("late_s", "verdict"), [(0.03, "accept"), (0.2, "reject"), (-0.2, "reject")])
def test_a_codec_s_lag_is_accepted_and_a_longer_delay_is_not(late_s, verdict):
    """Catches: a true film that is rejected as its codec lags; any delay put down to a codec."""
    outcome = judge([fringe_signal(LAW, EXCITATION * trajectory(late_s=late_s) + lasting_noise())])
    assert outcome.verdict == verdict
    assert named(outcome) == ([] if verdict == "accept" else ["late"])


def test_vague_frames_are_left_out():
    """Catches: frames without a phase that count as zeros."""
    full = true_film()
    sd, measured = full.phase_sd_rad.copy(), full.measured_rad.copy()
    sd[::7], measured[::7] = np.inf, 50.0
    outcome = judge([replace(full, phase_sd_rad=sd, measured_rad=measured)])
    assert outcome.verdict == "accept" and outcome.gain_ratio == pytest.approx(1.0, abs=0.01)


def test_a_vague_second_of_a_true_badge_is_no_spell():
    """Catches: frames whose phase is known to be vague, smeared ones say, that are taken for a lie."""
    law = 0.8 * trajectory(frames=900)
    sd = np.full(900, 0.02)
    sd[300:330] = 0.15
    measured = law + sd * np.random.default_rng(8).standard_normal(900)
    assert judge([fringe_signal(law, measured, phase_sd=sd)]).verdict == "accept"


# Forged over the whole film.

LONG = 900
LONG_LAW = EXCITATION * trajectory(frames=LONG)
LONG_PX = np.column_stack([640 + 180 * trajectory(5, LONG), 360 + 3 * trajectory(6, LONG)])
FORGED = {
    "still": 0 * LONG_LAW,
    "drift": 0.4 * clock(LONG),
    "late": EXCITATION * trajectory(frames=LONG, late_s=0.4),
    "place": (LONG_PX[:, 0] - 640) / 150,
    "another_gain": -LONG_LAW,
    "own_motion": EXCITATION * apart_from(LONG_LAW),
}


@pytest.mark.claim("Fringes that stay, drift, come late, follow the place or wander are rejected")
@pytest.mark.parametrize("name", list(FORGED))
def test_each_forgery_of_a_whole_film_is_rejected_and_named_for_what_it_does(name):
    """Catches: a verdict by correlation alone; |gain|, which accepts reversed fringes; a frozen fringe's noise; a rival
    with a free size or delay named where a simpler one fits as well; a free motion on top of the law, which explains
    everything, named where a rival with one parameter does.
    """
    outcome = judge([fringe_signal(LONG_LAW, FORGED[name] + lasting_noise(LONG), place_px=LONG_PX)])
    assert outcome.verdict == "reject" and levels(outcome)["residual"] == "fail"
    assert outcome.score < -3 * MAX_RIVAL_LOG10 and outcome.calibrated_log10 < -1
    assert not outcome.law_fits and not outcome.explanations[0].fits
    assert named(outcome) == [name]


@pytest.mark.claim("A gain that some build has is inconclusive, never accepted")
@pytest.mark.parametrize("gain", [0.3, 0.5, 1.5, 1.9, 3.0])
def test_a_gain_that_some_build_has_is_a_question_and_no_acceptance(gain):
    """Catches: a correlation of 1 taken for the law; air, a thick sheet or an unusual lens taken for a forgery."""
    film = fringe_signal(LAW, gain * LAW + 0.005 * apart_from(LAW))
    outcome = judge([film])
    assert outcome.verdict == "inconclusive" and outcome.correlation > 0.99 and not outcome.law_fits
    assert failed(outcome) == ["gain"] and outcome.gain_ratio == pytest.approx(gain, abs=1e-6)
    (row,) = [one for one in outcome.explanations if one.name == "another_gain"]
    assert row.parameters["gain"] == pytest.approx(gain, abs=0.02) and row.better_than_law
    known = judge([film], BUILT)
    assert known.verdict == ("reject" if not 0.8 < gain < 1.3 else "inconclusive") and levels(known)["gain"] == "fail"


@pytest.mark.parametrize("gain", [0.4, 2.2])
def test_an_unusual_gain_excuses_no_parts_that_move_apart(gain):
    """Catches: patches that move by themselves, whose mean happens to move too far, put down to the sheet."""
    for parts in ({"rows_rad": 0.9}, {"places_rad": 0.6}):
        outcome = judge([fringe_signal(LAW, gain * LAW + lasting_noise(), **parts)])
        assert outcome.verdict == "reject" and levels(outcome)["gain"] == "undecided"


@pytest.mark.parametrize("gain", [0.1, 0.0, -0.5, -1.0])
def test_fringes_that_stay_or_go_backwards_are_rejected(gain):
    """Catches: room for gains that no build has."""
    outcome = judge([fringe_signal(LAW, gain * LAW + 0.005 * apart_from(LAW))])
    assert outcome.verdict == "reject" and levels(outcome)["gain"] == "fail"


@pytest.mark.parametrize(("gain", "verdict"), [(0.37, "inconclusive"), (0.05, "reject"), (-1.0, "reject")])
def test_a_lens_that_the_film_does_not_show_is_asked_for(gain, verdict):
    """Catches: a true badge before a telephoto lens rejected; a still or reversed badge excused by any lens."""
    film = fringe_signal(LAW, gain * LAW + 0.1 * gain * lasting_noise(), lens_room=(0.2, 2.0))
    outcome = judge([film], BUILT)
    assert outcome.verdict == verdict
    assert ("lens" in levels(outcome)) == (verdict == "inconclusive")
    assert judge([replace(film, lens_room=(1.0, 1.0))], BUILT).verdict == "reject"
    assert judge([replace(true_film(), lens_room=(0.2, 2.0))]).verdict == "accept"
    # Before rays that may be parallel, a badge that tilts the other way looks the same; one that stays still does not.
    parallel = judge([replace(film, parallel=True)], BUILT)
    assert parallel.verdict == ("reject" if gain == 0.05 else "inconclusive")


def test_a_still_print_is_no_thin_sheet_before_the_longest_lens():
    """Catches: a print moved flat, whose fringes follow by what it is rectified by, excused by lens and build at once;
    a true badge, or one of half the gain, before that lens rejected."""
    lens = {"lens_room": (0.1, 2.6), "tangent_sd": 0.13}
    for gain, verdict in ((0.037, "reject"), (0.0, "reject"), (0.1, "inconclusive"), (0.05, "inconclusive")):
        film = fringe_signal(LAW, gain * LAW + 0.2 * lasting_noise(), **lens)
        assert judge([film]).verdict == verdict


@pytest.mark.claim("A true sheet is not rejected from any angle, whether it is glued or only laid on")
@pytest.mark.parametrize(("low_deg", "high_deg", "widest"), [(17, 39, 0.05), (39, 52, 0.1), (53, 62, 0.25)])
def test_a_sheet_that_is_laid_on_follows_the_law_as_one_that_is_glued(low_deg, high_deg, widest):
    """Catches: a true film rejected from aside; an error bar that forgets air or a bent page, or that air makes too
    wide; a still print, or one that runs backwards, excused by it; half the gain accepted as air."""
    bent = np.tanh(trajectory()) * (high_deg - low_deg) / 2 + (high_deg + low_deg) / 2
    tangents = np.tan(np.radians(bent)), np.zeros(FRAMES)
    lens = PRODUCTS["62lpi-27mil"]
    glued, air = view_law(lens, 0.42).phase_rad(*tangents), air_law(lens, 0.42, *tangents)
    bow = (glued - glued.mean()) ** 2 / glued.std()
    for share in (0.0, 0.5, 1.0):
        film = fringe_signal(glued, glued + share * air + lasting_noise(), air_rad=air)
        for sheet in (DESIGNED, BUILT):
            found = judge([film], sheet)
            assert found.verdict != "reject" and levels(found)["residual"] == "pass"
            assert abs(found.gain_ratio - 1) < 3 * found.gain_sd < 3 * widest
        # A bent page looks like a share of air.
        found = judge([fringe_signal(glued, film.measured_rad - 0.02 * bow, air_rad=air)])
        assert abs(found.gain_ratio - 1) < 3 * found.gain_sd
    for gain in (0.5, 0.0, -1.0):
        forged = judge([fringe_signal(glued, gain * glued + lasting_noise(), air_rad=air)], BUILT)
        assert forged.verdict == "reject" or (forged.verdict == "inconclusive" and (gain > 0 or low_deg > 50))
    # Where air could be a half of a gain, none is accepted.
    for gain in (0.5, 0.6, 0.7):
        film = fringe_signal(glued, gain * glued + lasting_noise(), air_rad=air)
        assert judge([film]).verdict != "accept"


@pytest.mark.parametrize("gain", [-1.0, 0.5])
def test_a_page_or_sheet_that_is_off_excuses_what_the_fringes_do(gain):
    """Catches: a page at 97 %, whose fringes run backwards, called a forgery; one that is accepted."""
    film = fringe_signal(LAW, gain * LAW + lasting_noise(), rows_rad=0.9)
    assert judge([film]).verdict == "reject"
    assert judge([film], page_off=True).verdict == "inconclusive"


@pytest.mark.parametrize("size", [0.2, 0.5])
@pytest.mark.parametrize("made", [apart_from, white])
@pytest.mark.parametrize("excitation", [0.5, 1.2, 2.4])
def test_a_wander_on_top_of_the_law_is_not_accepted(size, made, excitation):
    """Catches: a wander that great motion hides from the correlation (0.98 for 0.5 rad on 2.4 rad)."""
    law = excitation * trajectory()
    outcome = judge([fringe_signal(law, law + size * made(law) + lasting_noise())])
    assert outcome.verdict != "accept" and "own_motion" in named(outcome)
    assert levels(outcome)["residual"] != "pass"


def test_what_worse_poses_could_explain_is_inconclusive():
    """Catches: a true film from far away that is rejected, because coded pictures err alike in neighbouring frames;
    clear films that are excused in the same way.
    """
    law = 0.40 * trajectory()
    measured = law + 0.25 * white(law)
    vague = judge([fringe_signal(law, measured, phase_sd=0.07, pose_sd=0.06)])
    assert vague.verdict == "inconclusive" and levels(vague)["residual"] == "undecided"
    clear = judge([fringe_signal(law, measured, phase_sd=0.01, pose_sd=0.02)])
    assert clear.verdict == "reject" and levels(clear)["residual"] == "fail"


# Forged for a while, or in a part of the badge.


@pytest.mark.claim("A lie of a second is found in a film of a minute")
@pytest.mark.parametrize("seconds", [0.5, 1.0, 2.0])
def test_a_short_lie_is_not_averaged_away(seconds):
    """Catches: fringes that stay still for a second of a minute, which a mean over the film thins out to nothing; its
    time counted from the first frame that shows the badge, 10 s into the film."""
    frames, times = 1800, 10.0 + clock(1800)
    law = 0.5 * trajectory(frames=frames)
    noise = lasting_noise(frames, 0.02)
    held = round(30 * seconds)
    travelled = [np.ptp(law[k : k + held]) for k in range(frames - held)]
    start = int(np.argsort(travelled)[4 * len(travelled) // 10])
    lie = law.copy()
    lie[start : start + held] = law[start]
    true, forged = (judge([fringe_signal(law, shown + noise, times_s=times)]) for shown in (law, lie))
    assert true.verdict == "accept"
    assert forged.verdict != "accept" and "spell" in named(forged)
    (row,) = [one for one in forged.explanations if one.name == "spell"]
    assert (
        row.better_than_law
        and row.parameters["start_s"] < times[start + held]
        and row.parameters["end_s"] > times[start]
    )
    text = next(reason.text for reason in forged.reasons if reason.code == "spell")
    assert f"from {row.parameters['start_s']:.1f} to {row.parameters['end_s']:.1f} s" in text


def test_a_film_that_differs_from_the_law_says_by_how_much_and_when_most():
    """Catches: a size in other units than the law's motion; the time of another second, or of another clock."""
    law, other = 1.2 * trajectory(), np.zeros(300)
    other[180:] = np.linspace(0, 1, 120) * 3 * apart_from(law)[180:]
    outcome = judge([fringe_signal(law, law + other + lasting_noise(), times_s=20.0 + clock())])
    assert outcome.verdict == "reject" and named(outcome) == ["own_motion"]
    found = next(one.parameters for one in outcome.explanations if one.name == "own_motion")
    assert found["motion_share"] == pytest.approx(
        outcome.explanations[0].parameters["deviation_rad"] / law.std(), rel=0.01
    )
    assert found["end_s"] - found["start_s"] == pytest.approx(1.0, abs=0.04)
    size = np.convolve(other**2, np.ones(30), "same")
    assert (found["start_s"] + found["end_s"]) / 2 == pytest.approx(20 + int(np.argmax(size)) / 30, abs=0.6)


def test_rows_that_move_apart_fail_alone():
    """Catches: rows that are averaged before they are compared; the mean row's deviation."""
    outcome = judge([replace(true_film(), strip_residual_rad=np.array([0.02, 0.02, 0.9, 0.02]))])
    assert outcome.verdict == "reject" and failed(outcome) == ["parts"]


@pytest.mark.parametrize(("part", "noise"), [("strip", 0.6), ("place", 0.2)])
def test_rows_whose_contrast_trembles_as_much_prove_nothing_and_pass_nothing(part, noise):
    """Catches: a true badge rejected whose sheet lies askew, so that noise is all that is left of its fringes; noise by
    which one is accepted."""
    film = replace(true_film(), **{f"{part}_residual_rad": np.array([0.02, 0.9]), "strip_sd_rad": np.full(2, 0.02)})
    for trembling, verdict in (([0.0, noise], "inconclusive"), ([noise, noise / 6], "reject")):
        assert judge([replace(film, strip_noise_rad=np.array(trembling))]).verdict == verdict


@pytest.mark.claim("Patches within a row that move by themselves are rejected")
def test_places_within_a_row_that_move_apart_fail_alone():
    """Catches: edited patches of a row, which the row's mean hides."""
    outcome = judge([true_film(places_rad=0.3)])
    assert outcome.verdict == "reject" and failed(outcome) == ["parts"]


# Too little to judge.


@pytest.mark.parametrize("gain", [1.0, 0.5, -1.0])
def test_too_little_motion_is_inconclusive_whatever_the_fringes_do(gain):
    """Catches: a rejection, or an acceptance, of a film that shows nothing."""
    law = 0.6 * MIN_EXCITATION_RAD * trajectory()
    outcome = judge([fringe_signal(law, gain * law)])
    assert outcome.verdict == "inconclusive" and levels(outcome) == {"motion": "undecided"}
    assert outcome.gain_ratio == pytest.approx(gain) and outcome.explanations == ()


def test_motion_must_also_exceed_its_own_error():
    """Catches: a fixed threshold, which a shaky pose passes by its shaking alone."""
    law = 0.5 * trajectory()
    sure, vague = (judge([fringe_signal(law, law, pose_sd=sd)]) for sd in (0.05, 0.2))
    assert sure.verdict == "accept" and vague.verdict == "inconclusive"


def test_nothing_that_can_be_read_is_inconclusive():
    """Catches: a genuine verdict, or a division by zero, where every frame's phase is vague."""
    for blind in (fringe_signal(LAW, LAW, phase_sd=np.inf), fringe_signal(LAW[:20], LAW[:20])):
        outcome = judge([blind])
        assert outcome.verdict == "inconclusive" and levels(outcome) == {"fringes": "undecided"}
        assert outcome.correlation is None and outcome.to_json()["gain_ratio"] is None
        assert outcome.score is None and not outcome.law_fits and gain_of([blind]) is None


def test_a_badge_that_moves_unseen_is_reported_as_a_gap():
    """Catches: motion in a call that loses pictures, called hardly any; motion between two stretches that counts."""
    nothing = np.zeros(FRAMES)
    depth = DepthLaw(nothing, nothing, nothing)
    resting = fringe_signal(0.05 * trajectory(), 0.05 * trajectory())
    for leap, codes in ((3.0, {"motion_gaps", "motion"}), (0.1, {"motion"})):
        path = np.where(np.arange(FRAMES) < FRAMES / 2, 0.0, leap)
        leaping = replace(
            resting, beyond=BeyondPhase(path, depth, 0j * nothing, np.zeros((FRAMES, 2)), 1 + 0j * nothing)
        )
        outcome = judge([leaping])
        assert outcome.verdict == "inconclusive" and set(failed(outcome)) == codes


# A rival that would look alike.


@pytest.mark.claim("One steady sweep is inconclusive, and the rivals that remain are named")
def test_a_true_badge_on_one_sweep_is_inconclusive_with_the_rivals_that_remain():
    """Catches: a share that is counted and not acted upon; one without what to do about it."""
    outcome = judge([true_film(SWEEP)])
    assert outcome.verdict == "inconclusive" and failed(outcome) == ["drift"]
    assert outcome.law_fits
    (drift,) = (reason for reason in outcome.reasons if reason.code == "drift")
    assert drift.measured == pytest.approx(0.06) and drift.limit == 1 / LEAST_STRENGTH and drift.unit == "share"
    assert outcome.strength == one_in(drift.measured) < LEAST_STRENGTH
    assert f"1 in {outcome.strength} " in drift.text and "to and fro" in drift.text


@pytest.mark.parametrize(("turned", "verdict"), [(0.0, "inconclusive"), (0.7, "accept")])
def test_a_badge_that_only_shifts_is_inconclusive_with_the_advice_to_turn(turned, verdict):
    """Catches: fringes made from the badge's place alone, accepted; a badge that turns too left inconclusive."""
    law = LAW + turned * trajectory(5)
    outcome = judge([true_film(law, place_px=np.column_stack([640 + 180 * LAW, 360 + 0 * LAW]))])
    assert outcome.verdict == verdict and failed(outcome) == (["place"] if turned == 0 else [])
    assert turned or "turn the badge as well" in next(r.text for r in outcome.reasons if r.code == "place")


# Gain.


@pytest.mark.claim("A gain counts by its error bar: rejected beyond it, inconclusive within")
def test_a_gain_that_is_off_fails_beyond_its_error_and_is_undecided_within():
    """Catches: a bar that is not used; one that widens what passes, by which a vague film lets half the gain in."""
    off = fringe_signal(LAW, 1.4 * LAW)
    assert judge([off], BUILT).verdict == "reject"
    vague = judge([replace(off, tangent_sd=0.06)], BUILT)
    assert vague.verdict == "inconclusive" and levels(vague)["gain"] == "undecided"
    assert judge([fringe_signal(LAW, 0.5 * LAW, tangent_sd=0.1)], BUILT).verdict == "reject"
    assert judge([true_film(tangent_sd=0.1)]).verdict == "accept"


@pytest.mark.parametrize(("gain", "tangent_sd"), [(0.7, 0.2), (0.5, 1.0), (1.5, 0.15)])
def test_a_gain_within_its_error_bars_rejects_no_film(gain, tangent_sd):
    """Catches: a true film whose focal length is uncertain, rejected for what its vague gain leaves of the phase."""
    outcome = judge([fringe_signal(LAW, gain * LAW + lasting_noise(), tangent_sd=tangent_sd)])
    assert levels(outcome)["gain"] == "undecided"
    assert outcome.verdict == "inconclusive"


def test_no_grating_hides_another_s_gain():
    """Catches: a mean of gains, in which 1.25 and 0.75 are a true one."""
    outcome = judge([fringe_signal(LAW, gain * LAW) for gain in (1.25, 0.75)])
    assert levels(outcome)["gain"] == "undecided" and outcome.verdict == "inconclusive"


# Several gratings.


def test_gratings_are_weighed_by_their_information():
    """Catches: a plain mean; the best grating alone; weights of 1/sd; a grating that hardly moved and counts."""
    weaker = 0.7 * trajectory(5)
    good = fringe_signal(LAW, LAW + 0.05 * apart_from(LAW), phase_sd=0.03)
    poor = fringe_signal(weaker, 0.9 * weaker + 0.2 * apart_from(weaker), phase_sd=0.06)
    alone, both = [judge([one]) for one in (good, poor)], judge([good, poor])
    weight = np.array([1.2**2 / (0.03**2 + POSE_SD**2), 0.7**2 / (0.06**2 + POSE_SD**2)])
    for name in ("correlation", "gain_ratio", "phase_residual_rad", "window_correlation_mean", "excitation_rad"):
        wanted = np.average([getattr(one, name) for one in alone], weights=weight)
        assert getattr(both, name) == pytest.approx(wanted, abs=1e-9), name
    assert len(both.gratings) == 2 and both.gratings[1]["gain_ratio"] == pytest.approx(0.9, abs=1e-5)
    assert both.score == pytest.approx(min(one.score for one in alone))
    assert gain_of([good, poor]) == pytest.approx((both.gain_ratio, both.gain_sd))


def test_one_forged_grating_rejects_the_film():
    """Catches: a true grating that outweighs a forged one."""
    forged = fringe_signal(0.6 * trajectory(5), lasting_noise(), phase_sd=0.1)
    for signals in ([true_film(), forged], [forged, true_film()]):
        outcome = judge(signals)
        assert outcome.verdict == "reject" and not outcome.law_fits


def test_the_worst_row_of_any_grating_counts():
    """Catches: the first grating's rows alone; a mean by information, which a faint edited patch would slip past."""
    steady, torn = true_film(), replace(true_film(), strip_residual_rad=np.array([0.9]))
    assert failed(judge([steady, torn])) == failed(judge([torn, steady])) == ["parts"]


def test_a_grating_that_should_rest_must_rest():
    """Catches: fringes across the motion that are not looked at: they wandered by a whole radian and the film was
    accepted, as a grating that hardly moves has next to no information.
    """
    resting = 0.12 * trajectory(5)
    usual = fringe_signal(resting, resting + 0.02 * apart_from(resting))
    assert judge([true_film(), usual]).verdict == "accept"
    for measured in (*(resting + size * apart_from(resting) for size in (0.3, 1.0)), -resting):
        forged = fringe_signal(resting, measured)
        here, there = judge([true_film(), forged]), judge([forged, true_film()])
        assert here.verdict == there.verdict == "reject"
        assert failed(here) == failed(there) == ["residual"]
    assert judge([true_film(), fringe_signal(2 * resting, 0 * resting)]).verdict == "reject"


# What is reported.


def test_reasons_carry_figure_limit_and_unit():
    """Catches: a limit that is not the one applied; a text without its figure."""
    reasons = {reason.code: reason for reason in judge([fringe_signal(LAW, -0.5 * LAW)]).reasons}
    gain, motion, residual = reasons["gain"], reasons["motion"], reasons["residual"]
    assert gain.measured == pytest.approx(-0.5) and gain.limit == pytest.approx(LEAST_BUILT_GAIN)
    assert gain.unit == "ratio" and "-0.500" in gain.text and "gives no less than 0.2" in gain.text
    assert motion.limit == pytest.approx(MIN_EXCITATION_RAD) and motion.unit == "rad"
    error = math.hypot(PHASE_SD, POSE_SD)
    assert residual.limit == pytest.approx(residual_limit_rad(error, PROOF_SDS)) and residual.unit == "rad"
    assert residual.measured == pytest.approx((0.5 + LEAST_BUILT_GAIN) * EXCITATION, rel=0.2)
    other = reasons["another_gain"]
    assert other.measured < -3 * MAX_RIVAL_LOG10 and other.limit == -MAX_RIVAL_LOG10 and other.unit == "log10"


# What an honest film's camera, mixed frames, a small badge or a hand may do.


@pytest.mark.parametrize(("gain", "verdict"), [(1.0, "inconclusive"), (-1.0, "reject")])
def test_what_covers_a_badge_excuses_a_residual_and_no_gain(gain, verdict):
    """Catches: a hand before a true badge called a forgery; reversed fringes excused by a caption."""
    forged = fringe_signal(LAW, gain * LAW + lasting_noise(FRAMES, 0.2, lasting=0.9))
    assert judge([forged]).verdict == "reject"
    outcome = judge([replace(forged, covered_share=0.2)])
    assert outcome.verdict == verdict and levels(outcome)["residual"] == "undecided"


@pytest.mark.parametrize(
    ("sign", "code"),
    [({"lasting_px": 0.06}, "camera"), ({"mixed_share": 0.2}, "mixed_frames")],
    ids=["camera", "mixed"],
)
@pytest.mark.parametrize("gain", [0.6, 1.7])
def test_a_camera_or_an_editor_excuses_poses_and_no_row(gain, sign, code):
    """Catches: a reframed film, or one with noise reduction, called a forgery; rows that move by themselves excused by
    it; a good film that is inconclusive for it; a sign that makes a film pass.
    """
    wrong = fringe_signal(LAW, gain * LAW + 0.2 * white(LAW))
    less = {name: value / 3 for name, value in sign.items()}
    assert judge([wrong], BUILT).verdict == judge([replace(wrong, **less)], BUILT).verdict == "reject"
    outcome = judge([replace(wrong, **sign)], BUILT)
    assert outcome.verdict == "inconclusive" and levels(outcome)[code] == "undecided"
    assert judge([replace(wrong, **sign, strip_residual_rad=np.array([0.1, 0.5]))], BUILT).verdict == "reject"
    assert judge([replace(true_film(), **sign)]).verdict == "accept"


@pytest.mark.claim("No doubt of the camera excuses a still or a reversed badge")
@pytest.mark.parametrize("sign", [{"lasting_px": 1.1 * MAX_LASTING_PX}, {"lasting_px": 9.0}, {"mixed_share": 0.2}])
@pytest.mark.parametrize("gain", [0.0, -1.0])
def test_no_doubt_of_the_camera_excuses_a_still_or_a_reversed_badge(gain, sign):
    """Catches: a photograph that is reframed, as a forger can, left inconclusive."""
    outcome = judge([fringe_signal(LAW, gain * LAW + lasting_noise(), **sign)])
    assert outcome.verdict == "reject" and levels(outcome)["gain"] == "fail"


@pytest.mark.parametrize(("excitation", "doubt", "verdict"), [(0.4, 2.6, "inconclusive"), (0.4, 1.0, "reject")])
def test_a_tiny_badge_is_not_rejected_after_little_motion(excitation, doubt, verdict):
    """Catches: a true film of a small badge called forged; an excuse for large markers."""
    law = excitation * trajectory()
    film = fringe_signal(law, law + 0.4 * apart_from(law), phase_sd=0.07, pose_sd=0.06, doubt=doubt)
    outcome = judge([film])
    assert outcome.verdict == verdict and ("small" in levels(outcome)) == (doubt > 1)


@pytest.mark.parametrize(("name", "share"), [("covered_share", 0.6), ("stray_share", 0.2)])
def test_too_many_parts_or_frames_left_out_make_a_film_inconclusive(name, share):
    """Catches: a lie in frames that are not looked at, or under a cover, and the rest accepted."""
    outcome = judge([replace(true_film(), **{name: share})])
    code = {"covered_share": "covered", "stray_share": "pose_outliers"}[name]
    assert outcome.verdict == "inconclusive" and failed(outcome) == [code]
    few = judge([replace(true_film(), **{name: 0.04})])
    assert few.verdict == "accept" and levels(few)[code] == "note"


def test_a_focal_length_that_no_search_found_makes_a_film_inconclusive():
    """Catches: a stretched picture, in which half a gain looks whole, accepted at the border of the search."""
    outcome = judge([replace(true_film(), focal_at_limit=True)])
    assert outcome.verdict == "inconclusive" and failed(outcome) == ["focal"]


# What goes with the camera's place.


def viewed(measured: np.ndarray) -> tuple[GratingSignal, np.ndarray]:
    """A film whose camera also moves along the other axis and in distance, and that motion, standard deviation 1."""
    aside = apart_from(LAW, 21)
    near = (1.0 + 0.03 * apart_from(LAW, 22)) / 1000.0
    views = np.column_stack([0.1 * aside, near])
    return fringe_signal(LAW, measured, phase_sd=0.01, pose_sd=0.01, covariates=views), aside


def test_what_goes_with_the_camera_s_place_is_no_wander():
    """Catches: a bent sheet or light from one side rejected as a forgery; and a wander of that size let through."""
    film, aside = viewed(LAW)
    bent = judge([replace(film, measured_rad=LAW + 0.03 * aside)])
    assert bent.verdict == "accept" and bent.phase_residual_rad == pytest.approx(0.03, rel=0.02)
    law_row = bent.explanations[0].parameters
    assert abs(law_row["across_rad"]) == pytest.approx(0.03, rel=0.1) and law_row["deviation_rad"] < 0.01
    wander = judge([replace(film, measured_rad=LAW + lasting_noise(FRAMES, 0.15, lasting=0.9))])
    assert wander.verdict == "reject" and named(wander) == ["own_motion"]


def test_little_of_the_motion_may_go_with_the_camera_s_place():
    """Catches: fringes that follow another axis excused as a bent sheet."""
    film, aside = viewed(LAW)
    outcome = judge([replace(film, measured_rad=LAW + 0.25 * aside)])
    assert levels(outcome)["residual"] == "fail" and outcome.verdict == "reject"


def test_one_odd_chapter_hides_no_rival_of_the_whole_film():
    """Catches: a rival that each chapter favours a little, unnamed because one chapter's gain is unusual."""
    rival = Explanation("late", -0.5, {"late_s": 0.2}, 0.0, fits=False)
    own = [replace(compare(true_film(), DESIGNED, shares=False), rivals=(rival,))] * 30
    outcome = judge([true_film()], chapters=[[one] for one in (*own, replace(own[0], usual=False))])
    assert levels(outcome)["gain"] == "pass" and levels(outcome)["late"] == "undecided"
    assert outcome.verdict == "inconclusive"


@pytest.mark.parametrize("what", ["covered_share", "held_share"])
def test_what_covers_a_badge_is_noted(what):
    """Catches: a hand that is not reported."""
    assert levels(judge([replace(true_film(), **{what: 0.2})]))["covered"] == "note"
