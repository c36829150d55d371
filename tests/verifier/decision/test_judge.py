"""The motion test on made-up signals: each of its parts must fail alone.  Beside each test: what it would catch."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from moireid.verifier.camera.fit import CameraFit
from moireid.verifier.decision.figures import figures_of, pearson, window_correlation_mean
from moireid.verifier.decision.judge import Invariant, judge_invariant
from moireid.verifier.fringes.beyond_phase import BeyondPhase
from moireid.verifier.fringes.depth_law import DepthLaw
from moireid.verifier.fringes.signals import GratingSignal, Measurement
from moireid.verifier.limits import GAIN_TOLERANCE_SHARE, MAX_CERTAINTY_LOG10, MIN_CORRELATION, MIN_EXCITATION_RAD

FRAMES = 180
PHASE_SD, POSE_SD = 0.02, 0.01


def course(seed: int = 1, frames: int = FRAMES) -> np.ndarray:
    """A hand's course: smooth, mean 0, standard deviation 1."""
    t = np.arange(frames) / 30.0
    rng = np.random.default_rng(seed)
    wave = sum(
        np.sin(2 * np.pi * f * t + p) for f, p in zip(rng.uniform(0.2, 1.1, 4), rng.uniform(0, 6, 4), strict=True)
    )
    return (wave - wave.mean()) / wave.std()


def unlike(predicted: np.ndarray, seed: int = 9) -> np.ndarray:
    """Another course of standard deviation 1 that correlates with the first by nothing at all."""
    other = course(seed, len(predicted))
    other = other - predicted * (other @ predicted) / (predicted @ predicted)
    other -= other.mean()
    return other / other.std()


def jitter(predicted: np.ndarray) -> np.ndarray:
    """White noise of standard deviation 1 that correlates with the course by nothing at all."""
    noise = np.random.default_rng(6).standard_normal(len(predicted))
    noise -= noise.mean() + predicted * (noise @ predicted) / (predicted @ predicted)
    return noise / noise.std()


def signal(
    predicted: np.ndarray, measured: np.ndarray, *, phase_sd=PHASE_SD, pose_sd=POSE_SD, wander=0.01, places=0.02
) -> GratingSignal:
    sd = np.full(len(predicted), phase_sd) if np.isscalar(phase_sd) else phase_sd
    return GratingSignal(
        measured - measured.mean(),
        predicted - predicted.mean(),
        sd,
        pose_sd,
        np.array([0.5 * wander, wander]),
        np.arange(len(predicted)) / 30.0,
        np.array([places, places]),
    )


def judged(*signals: GratingSignal, tangent_sd: float = 0.0) -> Invariant:
    count = len(signals[0].measured_rad)
    camera = CameraFit(np.zeros((count, 3)), np.zeros(count), 1450.0, 0.0, False, 0.01, (0.0, 0.0), (0.0, 0.0))
    known = tuple(replace(signal, tangent_sd=tangent_sd) for signal in signals)
    return judge_invariant(Measurement(camera, np.zeros((count, 3)), np.arange(count) / 30.0, (), (), known))


def levels(outcome: Invariant) -> dict[str, str]:
    return {reason.code: reason.level for reason in outcome.reasons}


def failed(outcome: Invariant) -> list[str]:
    return [code for code, level in levels(outcome).items() if level != "pass"]


def genuine(excitation: float = 1.2, noise: float = 0.02) -> GratingSignal:
    predicted = excitation * course()
    return signal(predicted, predicted + noise * np.random.default_rng(4).standard_normal(FRAMES))


# One thing broken at a time.


def test_a_genuine_signal_is_accepted():
    """Catches: a test that nothing passes; a sign turned round on the way."""
    outcome = judged(genuine())
    assert outcome.verdict == "accept" and failed(outcome) == []
    told = {"motion", "correlation", "gain", "residual", "agreement", "likelihood", "steady", "views"}
    assert levels(outcome).keys() == told
    assert outcome.gain_ratio == pytest.approx(1.0, abs=0.01) and outcome.correlation > 0.999
    assert outcome.excitation_rad == pytest.approx(1.2) and outcome.score > 1.5
    assert outcome.phase_residual_rad == pytest.approx(0.02, rel=0.2)


@pytest.mark.parametrize("gain", [0.5, 1.5, -1.0, 0.0])
def test_gain_fails_alone(gain):
    """Catches: a verdict by correlation alone; |gain|, which accepts reversed fringes; a frozen fringe's noise."""
    predicted = 1.2 * course()
    leak = 0.2 * predicted if gain == 0.0 else gain * predicted
    outcome = judged(signal(predicted, leak + 0.005 * unlike(predicted)))
    assert outcome.verdict == "reject" and failed(outcome) == ["gain", "likelihood"]
    assert outcome.gratings[0]["suspected"] == "gain"
    assert outcome.gain_ratio == pytest.approx(gain or 0.2, abs=1e-6)
    assert outcome.correlation > MIN_CORRELATION


def test_correlation_fails_alone():
    """Catches: a residual that is taken for enough.  Vague phases explain a wander that vague motion does not."""
    predicted = 0.40 * course()
    outcome = judged(signal(predicted, predicted + 0.27 * jitter(predicted), phase_sd=0.07, pose_sd=0.06))
    assert outcome.verdict == "reject" and failed(outcome) == ["correlation", "likelihood"]
    assert outcome.correlation == pytest.approx(0.40 / math.hypot(0.40, 0.27), abs=1e-6)


def test_what_worse_poses_than_told_could_explain_is_left_open():
    """Catches: a true film from far away that is rejected, because coded pictures err alike in neighbouring frames;
    clear films that are excused in the same way.
    """
    predicted = 0.40 * course()
    vague = judged(signal(predicted, predicted + 0.18 * jitter(predicted), phase_sd=0.07, pose_sd=0.06))
    assert vague.verdict == "inconclusive" and levels(vague)["correlation"] == "undecided"
    clear = judged(signal(predicted, predicted + 0.18 * jitter(predicted), phase_sd=0.01, pose_sd=0.02))
    assert clear.verdict == "reject" and levels(clear)["correlation"] == "fail"


@pytest.mark.parametrize("seconds", [0.7, 1.0])
def test_a_short_lie_is_not_averaged_away(seconds):
    """Catches: fringes that stand still for a second of a minute, which a mean over the film thins out to nothing."""
    frames = 1800
    predicted = 0.35 * course(frames=frames)
    noise = 0.02 * np.random.default_rng(4).standard_normal(frames)
    held = int(30 * seconds)
    travelled = [np.ptp(predicted[k : k + held]) for k in range(frames - held)]
    # A quiet second, but no still one: fringes that stand still while the badge does so too are no lie.
    start = int(np.argsort(travelled)[3 * len(travelled) // 10])
    lie = predicted.copy()
    lie[start : start + held] = predicted[start]
    true, forged = judged(signal(predicted, predicted + noise)), judged(signal(predicted, lie + noise))
    assert true.verdict == "accept"
    assert forged.verdict == "reject" and forged.gratings[0]["suspected"] == "spell" and forged.score < -4
    # The figures of the whole film show nothing: many genuine films have the same.
    assert failed(forged) == ["likelihood"]
    assert forged.phase_residual_rad < 0.05 and forged.correlation > 0.985


def test_a_vague_spell_of_a_true_badge_is_no_lie():
    """Catches: frames whose phase is known to be vague, smeared ones say, that are taken for a lie."""
    predicted = 0.8 * course(frames=900)
    sd = np.full(900, 0.02)
    sd[300:330] = 0.15
    measured = predicted + sd * np.random.default_rng(8).standard_normal(900)
    assert judged(signal(predicted, measured, phase_sd=sd)).verdict == "accept"
    sure = judged(signal(predicted, measured, phase_sd=0.02))
    assert sure.verdict == "reject" and sure.gratings[0]["suspected"] == "spell"


def test_residual_fails_alone():
    """Catches: a wander of 0.5 rad that great motion hides from the correlation (0.977 here)."""
    predicted = 2.4 * course()
    outcome = judged(signal(predicted, predicted + 0.5 * jitter(predicted)))
    assert outcome.verdict == "reject" and failed(outcome) == ["residual", "likelihood"]
    assert outcome.gratings[0]["suspected"] == "jitter"
    assert outcome.phase_residual_rad == pytest.approx(0.5, abs=1e-6)


def test_agreement_fails_alone():
    """Catches: strips that are averaged before anyone looks whether they agree; the mean strip's wander."""
    outcome = judged(replace(genuine(), strip_residual_rad=np.array([0.02, 0.02, 0.9, 0.02])))
    assert outcome.verdict == "reject" and failed(outcome) == ["agreement", "likelihood"]
    assert outcome.gratings[0]["suspected"] == "strips"


@pytest.mark.parametrize("measured_gain", [1.0, 0.5, -1.0])
def test_too_little_motion_is_left_open_whatever_the_fringes_do(measured_gain):
    """Catches: a rejection, or an acceptance, of a film that shows nothing."""
    predicted = 0.6 * MIN_EXCITATION_RAD * course()
    outcome = judged(signal(predicted, measured_gain * predicted))
    assert outcome.verdict == "inconclusive" and levels(outcome) == {"motion": "undecided"}
    assert outcome.gain_ratio == pytest.approx(measured_gain)


def test_motion_must_also_stand_above_its_own_error():
    """Catches: a fixed threshold, which a shaky pose passes by its shaking alone."""
    predicted = 0.5 * course()
    sure = judged(signal(predicted, predicted, pose_sd=0.05))
    vague = judged(signal(predicted, predicted, pose_sd=0.2))
    assert sure.verdict == "accept" and vague.verdict == "inconclusive"


@pytest.mark.parametrize("shaking", [0.0, 1e-3])
def test_nothing_that_moves_is_inconclusive(shaking):
    """Catches: 0/0 in correlation or gain."""
    still = shaking * course()
    outcome = judged(signal(still, 0.01 * unlike(course())))
    assert outcome.verdict == "inconclusive" and "pass" not in levels(outcome).values()
    json.dumps(outcome.to_json(), allow_nan=False)


def test_nothing_that_can_be_read_is_inconclusive():
    """Catches: a genuine verdict, or a division by zero, where every frame's phase is vague."""
    predicted = course()
    for blind in (
        signal(predicted, predicted, phase_sd=np.full(FRAMES, np.inf)),
        signal(predicted[:20], predicted[:20]),
    ):
        outcome = judged(blind)
        assert outcome.verdict == "inconclusive" and levels(outcome) == {"fringes": "undecided"}
        assert outcome.correlation is None and outcome.to_json()["gain_ratio"] is None


# The figures.


def test_the_window_mean_is_the_plain_mean_over_thirty_frames():
    """Catches: a stride, a median, a signed mean, a missing last window.  Against a loop with numpy's own."""
    predicted = course()
    measured = predicted + 0.6 * unlike(predicted) - 0.01 * np.arange(FRAMES)
    loop = [abs(np.corrcoef(measured[k : k + 30], predicted[k : k + 30])[0, 1]) for k in range(FRAMES - 30 + 1)]
    assert len(loop) == 151 and min(loop) < 0.5
    assert window_correlation_mean(measured, predicted) == pytest.approx(np.mean(loop), abs=1e-9)
    assert judged(signal(predicted, measured)).window_correlation_mean == pytest.approx(np.mean(loop), abs=1e-9)


def test_pearson_is_numpy_s_and_zero_where_nothing_moves():
    """Catches: series that are not centred; NaN for a constant."""
    a, b = course(2) + 7.0, unlike(course(2)) + 0.4 * course(2) - 3.0
    assert pearson(a, b) == pytest.approx(np.corrcoef(a, b)[0, 1])
    assert pearson(a, -b) == -pearson(a, b) and pearson(a, np.full(FRAMES, 3.0)) == 0.0


def test_the_gain_is_regressed_on_the_predicted_phase():
    """Catches: regression the wrong way round, which reads 1 / gain and grows with the noise."""
    predicted = course()
    outcome = judged(signal(predicted, 0.9 * predicted + 0.3 * unlike(predicted)))
    assert outcome.gain_ratio == pytest.approx(0.9, abs=1e-9)


def test_an_offset_or_turns_of_the_phase_change_nothing():
    """Catches: a constant of assembly that enters the verdict."""
    here = genuine()
    there = replace(here, measured_rad=here.measured_rad + 40.0, predicted_rad=here.predicted_rad - 7.0)
    one, two = judged(here), judged(there)
    for name in (
        "correlation",
        "gain_ratio",
        "phase_residual_rad",
        "excitation_rad",
        "score",
        "window_correlation_mean",
    ):
        assert getattr(one, name) == pytest.approx(getattr(two, name), abs=1e-9), name


def test_the_score_falls_with_every_departure():
    """Catches: a score that does not rise with genuineness; a departure that it does not see."""
    predicted = 1.2 * course()
    true = genuine()
    departures = [
        [signal(predicted, gain * predicted) for gain in (1.0, 1.1, 1.3, 1.6)],
        [signal(predicted, gain * predicted) for gain in (1.0, 0.9, 0.7, 0.4)],
        [signal(predicted, predicted + share * 1.2 * unlike(predicted)) for share in (0.0, 0.1, 0.2, 0.5)],
        [signal(predicted, predicted + size * jitter(predicted)) for size in (0.02, 0.15, 0.3, 0.6)],
        [replace(true, strip_residual_rad=np.array([size])) for size in (0.01, 0.05, 0.1, 0.3)],
        [replace(true, place_residual_rad=np.array([size])) for size in (0.02, 0.1, 0.2, 0.4)],
    ]
    for signals in departures:
        scores = [judged(one).score for one in signals]
        told = [score for score in scores if score > -MAX_CERTAINTY_LOG10]
        assert scores == sorted(scores, reverse=True) and len(set(told)) == len(told) >= len(scores) - 2
        assert scores[0] > 1.5 and scores[-1] < -2.0


def test_the_gain_s_error_bar_grows_with_residuals_that_last():
    """Catches: residuals taken as independent: a slow error informs less than white noise of its size."""
    predicted = course()
    white = 0.1 * np.random.default_rng(3).standard_normal(FRAMES)
    slow = 0.1 * unlike(predicted)
    quick, lasting = (judged(signal(predicted, predicted + r)).gain_sd for r in (white, slow))
    assert quick == pytest.approx(0.1 / math.sqrt(FRAMES), rel=0.35)
    assert lasting > 4 * quick


def test_a_gain_that_is_off_fails_beyond_its_error_and_is_open_within():
    """Catches: a bar that is not used; one that widens what passes, by which a vague film lets half the gain in."""
    predicted = 1.2 * course()
    off = signal(predicted, (1 + 1.5 * GAIN_TOLERANCE_SHARE) * predicted)
    assert judged(off).verdict == "reject" and failed(judged(off)) == ["gain", "likelihood"]
    vague = judged(off, tangent_sd=0.06)
    assert vague.verdict == "inconclusive" and levels(vague)["gain"] == "undecided"
    half = signal(predicted, 0.5 * predicted)
    assert judged(half, tangent_sd=0.1).verdict == "reject"
    assert judged(half, tangent_sd=1.0).verdict == "inconclusive"
    assert judged(genuine(), tangent_sd=0.1).verdict == "accept"


def test_a_gain_too_vague_to_exclude_a_half_is_open_wherever_it_lies():
    """Catches: a gain that passes by luck.  Fringes at half the gain, filmed from 1.2 m by a wide lens that moves
    straight, whose focal length the film does not tell: they read 1.09 +- 0.22, and were accepted.
    """
    lucky = judged(genuine(), tangent_sd=0.22)
    assert lucky.verdict == "inconclusive" and failed(lucky) == ["gain"]
    assert levels(lucky)["gain"] == "undecided"


def test_vague_frames_are_left_out():
    """Catches: frames without a phase that count as zeros."""
    full = genuine()
    sd, measured = full.phase_sd_rad.copy(), full.measured_rad.copy()
    sd[::7], measured[::7] = np.inf, 50.0
    outcome = judged(replace(full, phase_sd_rad=sd, measured_rad=measured))
    assert outcome.verdict == "accept" and outcome.gain_ratio == pytest.approx(1.0, abs=0.01)


def test_a_badge_that_moves_where_nobody_sees_it_is_said_to_leap():
    """Catches: who moved a badge in a call that loses pictures, told that it hardly moved; motion between two stretches
    that counts as seen.
    """
    resting = signal(0.05 * course(), 0.05 * course())
    nothing = np.zeros(FRAMES)
    depth = DepthLaw(nothing, nothing, nothing)
    for leap, told in ((3.0, {"leaps", "motion"}), (0.1, {"motion"})):
        way = np.where(np.arange(FRAMES) < FRAMES / 2, 0.0, leap)
        leaping = replace(resting, beyond=BeyondPhase(way, depth, nothing.astype(complex), np.zeros((FRAMES, 2))))
        found = judged(leaping)
        assert found.verdict == "inconclusive"
        assert {code for code, level in levels(found).items() if level == "undecided"} == told


# Several gratings.


def test_gratings_are_weighed_by_their_information():
    """Catches: a plain mean; the best grating alone; weights of 1/sd; a grating that hardly moved and says as much."""
    strong, weak = 1.2 * course(), 0.7 * course(5)
    good = signal(strong, strong + 0.05 * unlike(strong), phase_sd=0.03)
    poor = signal(weak, 0.9 * weak + 0.2 * unlike(weak), phase_sd=0.06)
    alone = [judged(one) for one in (good, poor)]
    both = judged(good, poor)
    weight = np.array([1.2**2 / (0.03**2 + POSE_SD**2), 0.7**2 / (0.06**2 + POSE_SD**2)])
    for name in ("correlation", "gain_ratio", "phase_residual_rad", "window_correlation_mean", "excitation_rad"):
        wanted = np.average([getattr(one, name) for one in alone], weights=weight)
        assert getattr(both, name) == pytest.approx(wanted, abs=1e-9), name
    assert len(both.gratings) == 2
    assert both.gratings[1]["gain_ratio"] == pytest.approx(0.9, abs=1e-5)


def test_the_worst_strip_of_any_grating_counts():
    """Catches: the first grating's strips alone; a mean by information, which a faint edited patch would slip past."""
    steady, torn = genuine(), replace(genuine(), strip_residual_rad=np.array([0.9]))
    assert failed(judged(steady, torn)) == ["agreement", "likelihood"]
    assert failed(judged(torn, steady)) == ["agreement", "likelihood"]


def test_a_grating_that_should_rest_must_rest():
    """Catches: fringes across the motion that nobody looks at: they wandered by a whole radian and the film was
    accepted, as a grating that hardly moves has next to no information.
    """
    resting = 0.12 * course(5)
    assert judged(genuine(), signal(resting, resting + 0.02 * unlike(resting))).verdict == "accept"
    forged = [resting + size * unlike(resting) for size in (0.3, 1.0)] + [-resting]
    for measured in forged:
        here, there = judged(genuine(), signal(resting, measured)), judged(signal(resting, measured), genuine())
        assert here.verdict == there.verdict == "reject"
        assert failed(here) == failed(there) == ["residual"]
    assert judged(genuine(), signal(2 * resting, 0 * resting)).verdict == "reject"


def test_a_blind_grating_does_not_spoil_a_good_one():
    """Catches: zeros of an unread grating that enter the mean."""
    blind = signal(course(), course(), phase_sd=np.full(FRAMES, np.inf), wander=0.0)
    assert judged(genuine(), blind).verdict == "accept"
    assert judged(blind, genuine()).gain_ratio == pytest.approx(1.0, abs=0.01)


# What it says.


def test_reasons_carry_figure_limit_and_unit():
    """Catches: a limit that is not the one applied; a text without its figure."""
    predicted = 1.2 * course()
    reasons = {reason.code: reason for reason in judged(signal(predicted, 0.5 * predicted)).reasons}
    gain = reasons["gain"]
    assert (
        gain.measured == pytest.approx(0.5)
        and gain.limit == pytest.approx(GAIN_TOLERANCE_SHARE)
        and gain.unit == "ratio"
    )
    assert "0.500" in gain.text
    assert reasons["motion"].limit == pytest.approx(MIN_EXCITATION_RAD) and reasons["motion"].unit == "rad"
    assert reasons["correlation"].limit == MIN_CORRELATION
    known = math.sqrt(0.05**2 + (0.03 * 1.2) ** 2 + (3 * math.hypot(PHASE_SD, POSE_SD)) ** 2)
    assert reasons["residual"].limit == pytest.approx(known, rel=1e-6)


def placed(predicted: np.ndarray, measured: np.ndarray) -> tuple[GratingSignal, np.ndarray]:
    """A signal whose camera also moves along the other axis and in distance, and that motion, standard deviation 1."""
    aside = unlike(predicted, 21)
    near = (1.0 + 0.03 * unlike(predicted, 22)) / 1000.0
    made = signal(predicted, measured, phase_sd=0.01, pose_sd=0.01)
    return replace(made, covariates=np.column_stack([0.1 * aside, near])), aside


def test_what_goes_with_the_camera_s_place_is_no_wander():
    """Catches: a bent sheet or light from one side rejected as a forgery; and a wander of that size let through."""
    predicted = 0.8 * course()
    signal_, aside = placed(predicted, predicted)
    bent = judged(replace(signal_, measured_rad=predicted + 0.05 * aside))
    assert bent.verdict == "accept" and bent.phase_residual_rad == pytest.approx(0.05, rel=0.02)
    wander = judged(replace(signal_, measured_rad=predicted + 0.11 * jitter(predicted)))
    assert failed(wander) == ["residual", "likelihood"] and wander.verdict == "reject"


def test_little_of_the_motion_may_go_with_the_camera_s_place():
    """Catches: fringes that follow another axis excused as a bent sheet."""
    predicted = 0.8 * course()
    signal_, aside = placed(predicted, predicted)
    assert levels(judged(replace(signal_, measured_rad=predicted + 0.25 * aside)))["residual"] == "fail"


def test_places_that_hardly_move_explain_nothing():
    """Catches: columns of rounding errors blown up until they explain any wander; NaN from a camera at rest."""
    predicted = 0.8 * course()
    signal_, _ = placed(predicted, predicted + 0.11 * jitter(predicted))
    still = replace(signal_, covariates=np.full((len(predicted), 2), 0.25))
    assert judged(still).verdict == "reject"
    assert judged(replace(still, measured_rad=predicted)).verdict == "accept"


def test_json_is_strict_and_complete():
    """Catches: NaN or numpy figures in the JSON; a key of the contract that is missing."""
    document = json.loads(json.dumps(judged(genuine()).to_json(), allow_nan=False))
    assert document.keys() >= {
        "verdict",
        "correlation",
        "window_correlation_mean",
        "gain_ratio",
        "phase_residual_rad",
        "excitation_rad",
        "score",
        "gratings",
    }
    assert all(isinstance(value, float) for key, value in document.items() if key not in ("verdict", "gratings"))


def test_places_within_any_strip_count_but_not_within_one_that_is_covered():
    """Catches: a median, by which one forged row of three went unseen; a hand before a row of a true badge rejected."""
    true = genuine()
    apart, clear = np.array([0.02, 0.3, 0.02]), np.array([0.02, 0.02, 0.02])
    torn = replace(true, place_residual_rad=apart, strip_sd_rad=clear)
    assert judged(torn).verdict == "reject" and judged(torn).gratings[0]["suspected"] == "places"
    covered = replace(torn, strip_sd_rad=np.array([0.02, 0.2, 0.02]))
    assert judged(covered).verdict == "accept"


def test_no_grating_hides_another_s_gain():
    """Catches: a mean of gains, in which 1.25 and 0.75 are a true one."""
    predicted = 1.2 * course()
    wide, narrow = (signal(predicted, gain * predicted) for gain in (1.25, 0.75))
    assert levels(judged(wide, narrow))["gain"] == "fail"


def late(lag_s: float, excitation: float = 1.2) -> GratingSignal:
    """Fringes that are shown late, with the noise of a true film."""
    fine = excitation * course(frames=10 * FRAMES)
    times = np.arange(FRAMES) / 30.0
    # The course of ten times as many frames, run through ten times as slowly.
    clock = np.arange(10 * FRAMES) / 30.0
    predicted, shown = np.interp(times + 2.0, clock, fine), np.interp(times + 2.0 - lag_s, clock, fine)
    return signal(predicted, shown + 0.02 * np.random.default_rng(4).standard_normal(FRAMES))


def test_a_codec_that_shows_fringes_a_frame_late_is_no_forger_and_a_longer_delay_is():
    """Catches: a true film that is rejected as its codec lags; any delay put down to a codec; fringes ahead of the
    badge, which no codec makes, put down to one; an error bar that does not know of the lag.
    """
    ontime, lagging, ahead, delayed = (figures_of(late(lag)) for lag in (0.0, 0.030, -0.030, 0.2))
    assert lagging.wandering_rad == pytest.approx(ontime.wandering_rad, rel=0.15)
    assert lagging.phase_residual_rad > 2 * lagging.wandering_rad
    assert ahead.wandering_rad == pytest.approx(ahead.phase_residual_rad, rel=0.2)
    assert ontime.expected_error_rad < 1.1 * math.hypot(PHASE_SD, POSE_SD) < 0.9 * lagging.expected_error_rad
    assert judged(late(0.030)).verdict == "accept" and judged(late(0.2)).verdict == "reject"
    assert delayed.score < -3 < 0.8 < lagging.score


@pytest.mark.parametrize("what", ["covered_share", "held_share"])
@pytest.mark.parametrize(("gain", "verdict"), [(1.0, "inconclusive"), (0.5, "reject")])
def test_what_covers_a_badge_excuses_a_residual_and_no_gain(gain, verdict, what):
    """Catches: a hand before a true badge called a forgery; half a gain excused by a caption."""
    predicted = course(1)
    measured = gain * predicted + 0.2 * jitter(predicted)
    assert judged(signal(predicted, measured)).verdict == "reject"
    covered = replace(signal(predicted, measured), **{what: 0.2})
    assert judged(covered).verdict == verdict and levels(judged(covered))["covered"] == "note"


@pytest.mark.parametrize(
    ("sign", "code"),
    [({"lasting_px": 0.06}, "camera"), ({"mixed_share": 0.2}, "mixed_frames")],
    ids=["camera", "mixed"],
)
@pytest.mark.parametrize("gain", [0.6, 1.7, 0.0])
def test_a_camera_or_an_editor_excuses_poses_and_no_strip(gain, sign, code):
    """Catches: a reframed film, or one with noise reduction, called a forgery; rows that move by themselves excused by
    it; a good film that is left open for it; a sign that makes a film pass.
    """
    predicted = 1.2 * course()
    wrong = signal(predicted, gain * predicted + 0.2 * jitter(predicted))
    assert judged(wrong).verdict == "reject"
    assert judged(replace(wrong, **{name: value / 3 for name, value in sign.items()})).verdict == "reject"
    outcome = judged(replace(wrong, **sign))
    assert outcome.verdict == "inconclusive" and levels(outcome)[code] == "undecided"
    assert judged(replace(wrong, **sign, strip_residual_rad=np.array([0.1, 0.5]))).verdict == "reject"
    assert judged(replace(genuine(), **sign)).verdict == "accept"


def test_a_film_that_hardly_moves_is_told_that_its_picture_does():
    """Catches: advice to move more, where a window that follows the badge has taken the motion away."""
    outcome = judged(replace(genuine(0.1), lasting_px=0.06))
    assert outcome.verdict == "inconclusive"
    assert [code for code, level in levels(outcome).items() if level == "undecided"] == ["motion", "camera"]


def test_a_zoom_that_mixed_frames_may_have_feigned_leaves_a_film_open():
    """Catches: an error bar that rests on a zoom which is none."""
    assert judged(replace(genuine(), zoom=1.4)).verdict == "accept"
    assert judged(replace(genuine(), zoom=1.4, mixed_share=0.2)).verdict == "inconclusive"


def test_a_doubtful_focal_length_excuses_a_residual_where_the_gain_is_open():
    """Catches: a short look at a badge in a crop, whose focal length is wrong, called a forgery."""
    predicted = 1.2 * course()
    vague = signal(predicted, 0.84 * predicted + 0.1 * jitter(predicted))
    assert levels(judged(vague, tangent_sd=0.1))["gain"] == "undecided"
    assert judged(vague, tangent_sd=0.1).verdict == "reject"
    assert judged(replace(vague, lasting_px=0.02), tangent_sd=0.1).verdict == "inconclusive"
    sure = signal(predicted, predicted + 0.1 * jitter(predicted))
    assert judged(replace(sure, lasting_px=0.02)).verdict == "reject"


@pytest.mark.parametrize(("name", "share"), [("covered_share", 0.6), ("stray_share", 0.2)])
def test_too_many_parts_or_frames_left_out_leave_a_film_open(name, share):
    """Catches: a lie in frames that nobody looks at, or under a cover, and the rest accepted."""
    assert judged(replace(genuine(), **{name: share})).verdict == "inconclusive"
    assert judged(replace(genuine(), **{name: 0.04})).verdict == "accept"


def test_a_focal_length_that_no_search_found_leaves_a_film_open():
    """Catches: a stretched picture, in which half a gain looks whole, accepted at the border of the search."""
    outcome = judged(replace(genuine(), focal_at_limit=True))
    assert outcome.verdict == "inconclusive"
    assert [reason.code for reason in outcome.reasons if reason.level == "undecided"] == ["focal"]
