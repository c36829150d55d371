"""Rivals of the law: what else could move the fringes, over the whole film or for a while.

Over the whole film, each rival is a shape, and draws from its priors:

| name | the fringes | parameters |
|---|---|---|
| `still` | stay still | none |
| `drift` | drift at a constant speed | speed, over the best-fitting one |
| `late` | follow the law late or early | delay |
| `place` | move with the badge's place in the picture | size, over the best-fitting one |
| `another_gain` | move too far, not far enough, or the wrong way | gain |
| `own_motion` | move smoothly by themselves | a random walk, smoothed over 0.5 to 3 s |

How often would a rival look as law-like as this film does (`lookalike_shares`)?  Rivals that know nothing of the law
are forged on the film's own trajectory, with parameters drawn from their priors and with the film's own residual,
resampled in blocks.  The honest explanation is then fitted to each as to the film.  The share of such forgeries whose
gain an honest sheet may have, and whose residual is about as small as the film's, is the rival's share.  A film of much
and varied motion leaves no rival a share; on a single steady sweep a drift keeps one.  `late` and `another_gain`
are the law, changed: their draws that look like the film are, within its error, films of an honest badge (on an even
sweep a delay is another phase constant), so they have no share and count by their fit alone.

Do the fringes leave the law for a while (`worst_spell`)?  In each window of the film they are compared with the law,
and with fringes that meanwhile stay still, go the wrong way, or go half or twice as far.  A window's phase constant is
free, so nothing outside of it counts.

Convention: phases (N, D) in rad with mean 0 in each stretch.  Priors are even over the ranges of `verifier.limits`.
    Shares from 0 to 1.  A window's *slip* is its residual's
    projection on the law's own change there, rad times the root of blocks; on an honest film slips scatter about 0,
    with outliers where a pose is poor.
Source: shares: a parametric bootstrap under each rival; blocks of `RESAMPLED_S`, which hold what is correlated (Kuensch
    1989).  Spells: ratio of Student's t densities with `SPELL_FREEDOM` degrees of freedom, as outliers are common; its
    logarithm is lowered by that of the number of windows that are tried.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier import limits
from moireid.verifier.explanations.honest import HonestModel, PhaseSeries, Room
from moireid.verifier.explanations.residuals import deviation_rad, log10_odds, spread_rad
from moireid.verifier.explanations.strength import LookalikeShare

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rival:
    """One rival; what the fringes do, and what would exclude it, is in `words`.

    variants: columns (N, K) whose best-fitting sum is the rival's phase, each with a parameter or None; none for
    `another_gain`, whose fit is a ratio; None for one that may fit anything (`residuals.own_motion_odds` judges it).
    draws: phases (N, D) with parameters from its priors; None for the law, changed.
    scaled: whether each draw is the same phase, to be multiplied by any ratio of `FORGED_GAINS`.
    """

    name: str
    variants: Callable[[PhaseSeries], list[tuple[float | None, Array]]] | None
    draws: Callable[[PhaseSeries, np.random.Generator, int], Array] | None
    scaled: bool = False


def _stretches(series: PhaseSeries) -> tuple[NDArray[np.int64], Array, Array]:
    """The first block of each stretch, and when each begins and ends, s."""
    begins = np.flatnonzero(np.diff(series.stretch, prepend=-1))
    return begins, series.times_s[begins], series.times_s[np.append(begins[1:], len(series.times_s)) - 1]


def delayed(series: PhaseSeries, delays_s: Array) -> Array:
    """The law so much later, (N, D), with the law's own constant; beyond the ends of a stretch it goes on as it went.

    Parameters: delays_s (D,): negative where it is earlier.
    """
    begins, first, last = _stretches(series)
    # One clock for all stretches, far enough apart that none reaches into the next.
    apart = np.arange(len(begins)) * (float(np.ptp(series.times_s)) + 1.0)
    clock = series.times_s + apart[series.stretch]

    def law_at(times_s: Array, stretch: NDArray[np.int64]) -> Array:
        begin, end, on = (of.reshape(-1, 1)[stretch] for of in (first, last, apart))
        return np.asarray(np.interp(np.clip(times_s, begin, end) + on, clock, series.law_rad))

    each, wanted = np.arange(len(begins)), series.times_s[:, None] - delays_s
    near = np.minimum(np.abs(delays_s), (last - first)[:, None])
    first, last = first[:, None], last[:, None]
    pace = np.maximum(near, 1e-9)
    early = np.where(near > 0, (law_at(first + near, each) - law_at(first, each)) / pace, 0.0)[series.stretch]
    late = np.where(near > 0, (law_at(last, each) - law_at(last - near, each)) / pace, 0.0)[series.stretch]
    before = np.minimum(wanted - first[series.stretch], 0.0)
    after = np.maximum(wanted - last[series.stretch], 0.0)
    return np.asarray(law_at(wanted, series.stretch) + early * before + late * after)


def nearest(series: PhaseSeries, columns: Array, phase_rad: Array) -> Array:
    """The weighted sum of columns (N, K) that is nearest to a phase (N,), by weighted least squares, rad (N,)."""
    if not columns.shape[1]:
        return np.zeros(len(series.times_s))
    root, table = np.sqrt(series.weight), series.centred(columns)
    found = np.linalg.lstsq(root[:, None] * table, root * phase_rad, rcond=1e-9)[0]
    return np.asarray(table @ found)


def _time(series: PhaseSeries) -> Array:
    return np.asarray(series.times_s - series.times_s.mean())[:, None]


def _place(series: PhaseSeries) -> Array:
    return series.place_px if series.place_px is not None else np.zeros((len(series.times_s), 1))


def _nearest_to_law(columns: Callable[[PhaseSeries], Array]) -> Callable[..., Array]:
    """Of a shape the sum that is nearest to the law, as often as asked."""

    def draws(series: PhaseSeries, _: np.random.Generator, count: int) -> Array:
        return np.repeat(nearest(series, columns(series), series.law_rad)[:, None], count, axis=1)

    return draws


def _known_delays(series: PhaseSeries) -> list[tuple[float | None, Array]]:
    delays = [sign * one for one in limits.DELAYS_S for sign in (1, -1)]
    return list(zip(delays, delayed(series, np.array(delays)).T[:, :, None], strict=True))


def _rest(series: PhaseSeries, rng: np.random.Generator, count: int) -> Array:
    return np.zeros((len(series.times_s), count))


def _own_motions(series: PhaseSeries, rng: np.random.Generator, count: int) -> Array:
    """Random walks, each smoothed over a time of its own, as wide as the law."""
    walks = np.cumsum(rng.normal(size=(len(series.times_s), count)), axis=0)
    spans = rng.uniform(*limits.OWN_MOTION_S, count)
    power = np.fft.rfft(walks - np.linspace(walks[0], walks[-1], len(walks)), axis=0)
    hz = np.fft.rfftfreq(len(walks), series.step_s)[:, None]
    smooth = np.fft.irfft(power * np.exp(-0.5 * (2 * np.pi * hz * spans / 4) ** 2), len(walks), axis=0)
    smooth = series.centred(smooth + np.linspace(walks[0], walks[-1], len(walks)))
    size = np.sqrt(np.average(smooth**2, weights=series.weight, axis=0))
    return smooth * series.excitation_rad / np.maximum(size, 1e-12)


RIVALS = (
    Rival("still", lambda series: [(None, np.zeros((len(series.times_s), 0)))], _rest),
    Rival("drift", lambda series: [(None, _time(series))], _nearest_to_law(_time), scaled=True),
    Rival("late", _known_delays, None),
    Rival("place", lambda series: [(None, _place(series))], _nearest_to_law(_place), scaled=True),
    Rival("another_gain", lambda series: [], None),
    Rival("own_motion", None, _own_motions),
)


def rival_odds(
    rival: Rival, series: PhaseSeries, own: float, samples: float, room: Room
) -> tuple[float, dict[str, float]] | None:
    """Decadic logarithm of the odds of the law over the rival's best fit, and that fit's parameters; None for one
    that may fit anything (`residuals.own_motion_odds`).

    Parameters: own: sum of squares that the law leaves; samples: independent samples in that; room: gains of honest
        badges.
    """
    if rival.variants is None:
        return None
    if rival.name == "another_gain":
        fits = [_gain_outside(series, room)]
    else:
        fits = [
            (series.measured_rad - nearest(series, columns, series.measured_rad), _parameters(rival.name, value))
            for value, columns in rival.variants(series)
        ]
    squares = [float(series.weight @ residual**2) for residual, _ in fits]
    residual, parameters = fits[int(np.argmin(squares))]
    left = residual[_known_when(series, parameters.get("late_s", 0.0))]
    parameters["residual_rad"] = math.sqrt(min(squares) / series.weight.sum())
    parameters["deviation_rad"] = deviation_rad(left, series.step_s)
    return log10_odds(own, min(squares), len(series.times_s), samples), parameters


def _known_when(series: PhaseSeries, late_s: float) -> NDArray[np.bool_]:
    """Blocks (N,) for which a stretch shows the law so much earlier; all, where no stretch lasts so long."""
    _, first, last = _stretches(series)
    then = series.times_s - late_s
    known = (first[series.stretch] <= then) & (then <= last[series.stretch])
    return known if known.any() else ~known


def _parameters(name: str, value: float | None) -> dict[str, float]:
    return {} if value is None else {f"{name}_s": value}


def _gain_outside(series: PhaseSeries, room: Room) -> tuple[Array, dict[str, float]]:
    """What the best-fitting gain outside of what honest badges have leaves, (N,), rad, and that gain."""
    power = float(series.weight @ series.law_rad**2)
    gain = float(series.weight @ (series.law_rad * series.measured_rad)) / max(power, 1e-18)
    if room[0] < gain < room[1]:
        gain = min(room, key=lambda end: abs(end - gain))
    return series.measured_rad - gain * series.law_rad, {"gain": gain}


def lookalike_shares(
    model: HonestModel,
    residual_rad: Array,
    room: Room,
    *,
    allowed: float,
    constant_room_rad: float | None = None,
    seed: int = 0,
) -> dict[str, LookalikeShare]:
    """The share of each rival that knows nothing of the law, by its name.

    Parameters: residual_rad (N,): of the film, fitted by `model`; room: gains that may be accepted; allowed: share that
        an acceptance allows, which ends the draws once it is surely above or below; constant_room_rad: how far the
        phase constant may be from that at enrolment, None where none is known.

    Notes
    -----
    Source: importance sampling.  A gain is linear in the phase.  So a scaled forgery's gain is drawn evenly over the
        room, and its ratio follows; the chance of the room is its width over that of all gains of such forgeries, and
        a draw with a ratio outside of `FORGED_GAINS` is no hit.  Other forgeries are as likely with the other sign, so
        that of each pair the one with a positive gain is drawn.  The constant of fringes that know nothing of the law
        is any of a turn, so they meet a known one by chance.
    """
    series, rng = model.series, np.random.default_rng(seed)
    most = limits.ALIKE_RATIO * float(spread_rad(residual_rad[:, None])[0])
    met = 1.0 if constant_room_rad is None else min(1.0, constant_room_rad / np.pi)
    count = min(max(limits.DRAWN_VALUES // len(residual_rad), 20), limits.DRAWS)

    def share_of(rival: Rival) -> LookalikeShare:
        assert rival.draws is not None
        (low, high), chance, gain = limits.FORGED_GAINS, 0.5, 0.0
        if rival.scaled:
            gain = float(model.gain(rival.draws(series, rng, 1))[0])
            chance = (room[1] - room[0]) / max(abs(gain) * (high - low), 1e-12)
        alike = drawn = 0
        share = LookalikeShare.of(alike, drawn, allowed, met * min(chance, 1.0))
        while not drawn or (drawn < limits.MOST_DRAWS and share.at_least <= allowed < share.at_most):
            some = min(count, limits.MOST_DRAWS - drawn)
            phases = series.centred(rival.draws(series, rng, some))
            noise = series.centred(limits.RESAMPLED_SHARE * resampled(residual_rad, series.step_s, rng, some))
            ratio = np.ones(some)
            if rival.scaled and chance < 1:
                ratio = (rng.uniform(*room, some) - model.gain(noise)) / gain
            elif rival.scaled:
                ratio = rng.uniform(low, high, some)
            forged = ratio * phases + noise
            if not rival.scaled:
                forged *= np.sign(model.gain(forged))
            fit = model.fit(forged)
            like = (low <= ratio) & (ratio <= high) & (room[0] <= fit.gain) & (fit.gain <= room[1])
            if like.any():
                like[like] = spread_rad(fit.residual_rad[:, like]) <= most
            alike, drawn = alike + int(like.sum()), drawn + some
            share = LookalikeShare.of(alike, drawn, allowed, met * min(chance, 1.0))
        return share

    return {rival.name: share_of(rival) for rival in RIVALS if rival.draws is not None}


def resampled(residual_rad: Array, step_s: float, rng: np.random.Generator, count: int) -> Array:
    """The residual (N,) in blocks from random places and with random signs, (N, count)."""
    length = len(residual_rad)
    block = min(max(round(limits.RESAMPLED_S / step_s), 3), length)
    pieces = -(-length // block)
    begins = rng.integers(0, length - block + 1, (pieces, 1, count))
    signs = rng.choice((-1.0, 1.0), (pieces, 1, count))
    found = residual_rad[begins + np.arange(block)[:, None]] * signs
    return np.asarray(found.reshape(pieces * block, count)[:length])


#: Time that a window may hold beyond its length, as a share: frames may be missing.
LONGER_SHARE = 0.5


@dataclass(frozen=True)
class Spell:
    """The window most like a forgery: log10 odds of the law over it, its gain, and when it begins and ends, s."""

    log10_odds: float
    gain: float
    start_s: float
    end_s: float


def worst_spell(series: PhaseSeries, residual_rad: Array) -> Spell | None:
    """The spell that is likeliest; None where no window holds enough of the law's motion.

    Parameters: residual_rad (N,): measured phase less the whole film's fit of the law, whose gain is then 1 here.
    """
    found = [spell for length in limits.SPELLS_S if (spell := _worst_of(series, residual_rad, length)) is not None]
    return min(found, key=lambda spell: spell.log10_odds, default=None)


def _worst_of(series: PhaseSeries, residual_rad: Array, length_s: float) -> Spell | None:
    count = round(length_s / series.step_s) + 1
    if count < 4 or 2 * count > len(residual_rad):
        return None
    first, last = np.arange(len(residual_rad) - count + 1), np.arange(count - 1, len(residual_rad))
    whole = series.stretch[first] == series.stretch[last]
    whole &= series.times_s[last] - series.times_s[first] <= (1 + LONGER_SHARE) * length_s
    law, left = series.law_rad, residual_rad
    moved = _windows(law * law, count) - _windows(law, count) ** 2 / count
    along = _windows(law * left, count) - _windows(law, count) * _windows(left, count) / count
    size = np.sqrt(np.maximum(moved, 1e-18))
    slip = along / size
    # A ramp over a range R has a standard deviation of R / sqrt(12).
    tried = whole & (size >= limits.MIN_SPELL_MOTION_RAD * math.sqrt(count / 12))
    if not tried.any():
        return None
    usual = max(1.4826 * float(np.median(np.abs(slip[whole]))), limits.LEAST_SLIP_RAD * math.sqrt(count))
    by_law = np.log1p((slip[tried] / usual) ** 2 / limits.SPELL_FREEDOM)
    windows = max(float(tried.sum()) / count, 1.0)
    worst: Spell | None = None
    for gain, unlikely in limits.SPELL_GAINS.items():
        by_lie = np.log1p(((slip[tried] - (gain - 1) * size[tried]) / usual) ** 2 / limits.SPELL_FREEDOM)
        odds = (limits.SPELL_FREEDOM + 1) / 2 * (by_lie - by_law) / math.log(10) + math.log10(windows) + unlikely
        k = int(np.argmin(odds))
        if worst is None or odds[k] < worst.log10_odds:
            at = np.flatnonzero(tried)[k]
            worst = Spell(float(odds[k]), gain, float(series.times_s[first[at]]), float(series.times_s[last[at]]))
    return worst


def _windows(values: Array, count: int) -> Array:
    """Sums over each window of so many entries."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(sums[count:] - sums[:-count])
