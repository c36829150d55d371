"""Rivals of the law over a whole film: what else could move the fringes, each as a shape and as draws from its priors.

| name | the fringes | parameters |
|---|---|---|
| `still` | stay where they are, as in print | none |
| `drift` | go at a constant speed | speed, over the best-fitting one |
| `late` | follow the law late or early | delay |
| `place` | move with the badge's place in the picture | size, over the best-fitting one |
| `another_gain` | move too far, not far enough, or the wrong way | gain |
| `own_motion` | move smoothly by themselves | a random walk, smoothed over 0.5 to 3 s |

Convention: phases (N, D) in rad with mean 0 in each stretch.  Priors are even over the ranges of `verifier.limits`;
a gain that an honest sheet may have is no rival.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.honest import Room
from moireid.verifier.explanations.residuals import log10_odds
from moireid.verifier.explanations.series import PhaseSeries
from moireid.verifier.limits import DELAYS_S, FORGED_GAINS, LATE_RANGE_S, OWN_MOTION_S

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rival:
    """One rival: its name, what the fringes do, and the motion that would exclude it.

    variants: columns (N, K) whose best-fitting sum is the rival's phase, each with a parameter or None; None for a
    rival that contains the law.
    draws: phases (N, D) with parameters from its priors.
    """

    name: str
    words: str
    remedy: str
    variants: Callable[[PhaseSeries], list[tuple[float | None, Array]]] | None
    draws: Callable[[PhaseSeries, np.random.Generator, int, Room], Array]


def even(count: int, low: float, high: float) -> Array:
    """So many values (count,), evenly over a range."""
    return np.asarray(low + (high - low) * (np.arange(count) + 0.5) / count)


def delayed(series: PhaseSeries, delay_s: float) -> Array:
    """The law so much later, (N,), with the law's own constant; beyond the ends of a stretch it goes on as it went."""
    begins = np.flatnonzero(np.diff(series.stretch, prepend=-1))
    first = series.times_s[begins]
    last = series.times_s[np.append(begins[1:], len(series.times_s)) - 1]
    # One clock for all stretches, far enough apart that none reaches into the next.
    apart = np.arange(len(begins)) * (float(np.ptp(series.times_s)) + 1.0)
    clock = series.times_s + apart[series.stretch]

    def law_at(times_s: Array, stretch: NDArray[np.int64]) -> Array:
        within = np.clip(times_s, first[stretch], last[stretch])
        return np.asarray(np.interp(within + apart[stretch], clock, series.law_rad))

    each, wanted = np.arange(len(begins)), series.times_s - delay_s
    near = np.minimum(abs(delay_s), last - first)
    pace = np.maximum(near, 1e-9)
    early = np.where(near > 0, (law_at(first + near, each) - law_at(first, each)) / pace, 0.0)[series.stretch]
    late = np.where(near > 0, (law_at(last, each) - law_at(last - near, each)) / pace, 0.0)[series.stretch]
    before = np.minimum(wanted - first[series.stretch], 0.0)
    after = np.maximum(wanted - last[series.stretch], 0.0)
    return np.asarray(law_at(wanted, series.stretch) + early * before + late * after)


def _fitted(series: PhaseSeries, columns: Array) -> Array:
    """The sum of columns (N, K) that is nearest to the law, (N,)."""
    root = np.sqrt(series.weight)
    table = series.centred(columns)
    found = np.linalg.lstsq(root[:, None] * table, root * series.law_rad, rcond=1e-9)[0]
    return np.asarray(table @ found)


def _time(series: PhaseSeries) -> Array:
    return np.asarray(series.times_s - series.times_s.mean())[:, None]


def _place(series: PhaseSeries) -> Array:
    return series.place_px if series.place_px is not None else np.zeros((len(series.times_s), 1))


def _scaled(columns: Callable[[PhaseSeries], Array]) -> Callable[..., Array]:
    """Draws of a shape times any ratio to the best-fitting one."""

    def draws(series: PhaseSeries, rng: np.random.Generator, count: int, room: Room) -> Array:
        return np.outer(_fitted(series, columns(series)), even(count, *FORGED_GAINS))

    return draws


def _delays(series: PhaseSeries, rng: np.random.Generator, count: int, room: Room) -> Array:
    late = even((count + 1) // 2, *LATE_RANGE_S)
    return np.column_stack([delayed(series, delay) for delay in (*late, *-late)])


def _gains(series: PhaseSeries, rng: np.random.Generator, count: int, room: Room) -> Array:
    gains = even(count, *FORGED_GAINS)
    return np.outer(series.law_rad, gains[(gains < room[0]) | (gains > room[1])])


def _rest(series: PhaseSeries, rng: np.random.Generator, count: int, room: Room) -> Array:
    return np.zeros((len(series.times_s), count))


def _own_motions(series: PhaseSeries, rng: np.random.Generator, count: int, room: Room) -> Array:
    """Random walks, each smoothed over a time of its own, as wide as the law."""
    walks = np.cumsum(rng.normal(size=(len(series.times_s), count)), axis=0)
    spans = rng.uniform(*OWN_MOTION_S, count)
    power = np.fft.rfft(walks - np.linspace(walks[0], walks[-1], len(walks)), axis=0)
    hz = np.fft.rfftfreq(len(walks), series.step_s)[:, None]
    smooth = np.fft.irfft(power * np.exp(-0.5 * (2 * np.pi * hz * spans / 4) ** 2), len(walks), axis=0)
    smooth = series.centred(smooth + np.linspace(walks[0], walks[-1], len(walks)))
    size = np.sqrt(np.average(smooth**2, weights=series.weight, axis=0))
    return smooth * series.excitation_rad / np.maximum(size, 1e-12)


RIVALS = (
    Rival(
        "still", "stay where they are, as in print", "move the badge or the camera sideways",
        lambda series: [(None, np.zeros((len(series.times_s), 0)))], _rest,
    ),
    Rival(
        "drift", "go at a constant speed", "move to and fro instead of steadily one way",
        lambda series: [(None, _time(series))], _scaled(_time),
    ),
    Rival(
        "late", "follow the motion late or early", "change speed and direction more often",
        lambda series: [(way * s, delayed(series, way * s)[:, None]) for s in DELAYS_S for way in (1, -1)], _delays,
    ),
    Rival(
        "place", "move with the badge's place in the picture", "turn the badge as well, or walk around it",
        lambda series: [(None, _place(series))], _scaled(_place),
    ),
    Rival(
        "another_gain", "move too far, not far enough, or the wrong way", "film with more motion, or from nearer",
        lambda series: [], _gains,
    ),
    Rival(
        "own_motion", "move smoothly by themselves", "film for longer, with more motion", None, _own_motions,
    ),
)  # fmt: skip


def rival_odds(
    rival: Rival, series: PhaseSeries, own: float, samples: float, room: Room
) -> tuple[float, dict[str, float]] | None:
    """Decadic logarithm of the odds of the law over the rival's best fit, and that fit's parameters; None for a rival
    that contains the law, whose share alone counts.

    Parameters: own: sum of squares that the law leaves; samples: independent samples in that; room: gains of honest
        badges.
    """
    if rival.variants is None:
        return None
    if rival.name == "another_gain":
        fits = [_gain_outside(series, room)]
    else:
        fits = [(_left(series, columns), _parameters(rival.name, value)) for value, columns in rival.variants(series)]
    left, parameters = min(fits, key=lambda fit: fit[0])
    residual = float(np.sqrt(left / series.weight.sum()))
    return log10_odds(own, left, len(series.times_s), samples), parameters | {"residual_rad": residual}


def _parameters(name: str, value: float | None) -> dict[str, float]:
    return {} if value is None else {f"{name}_s": value}


def _left(series: PhaseSeries, columns: Array) -> float:
    """Weighted sum of squares that the best-fitting sum of columns leaves of the measured phase, rad^2."""
    root = np.sqrt(series.weight)
    left = root * series.measured_rad
    if columns.shape[1]:
        table = root[:, None] * series.centred(columns)
        left = left - table @ np.linalg.lstsq(table, left, rcond=1e-9)[0]
    return float(left @ left)


def _gain_outside(series: PhaseSeries, room: Room) -> tuple[float, dict[str, float]]:
    """The best-fitting gain outside of what honest badges have."""
    power = float(series.weight @ series.law_rad**2)
    gain = float(series.weight @ (series.law_rad * series.measured_rad)) / max(power, 1e-18)
    if room[0] < gain < room[1]:
        gain = min(room, key=lambda end: abs(end - gain))
    left = series.measured_rad - gain * series.law_rad
    return float(series.weight @ left**2), {"gain": gain}
