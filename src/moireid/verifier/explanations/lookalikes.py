"""How often would a rival look as law-like as this film does?

Each rival is forged on the film's own trajectory, with parameters from its priors and with the film's own residual,
resampled in blocks.  The honest explanation is then fitted to it as to the film.  The share of such forgeries whose
gain an honest sheet may have, and whose residual is about as small as the film's, is the rival's share.  A film of much
and varied motion leaves no rival a share; on a single steady sweep a drift keeps one.

Convention: shares from 0 to 1.
Source: a parametric bootstrap under each rival; blocks of `RESAMPLED_S`, which hold what is correlated (Kuensch 1989).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.honest import HonestModel, Room
from moireid.verifier.explanations.residuals import spread_rad
from moireid.verifier.explanations.rivals import RIVALS
from moireid.verifier.limits import ALIKE_RATIO, DRAWS, RESAMPLED_S, RESAMPLED_SHARE

Array = NDArray[np.float64]
#: Rivals whose phase constant may be any.
BY_CHANCE = ("still", "drift", "place", "own_motion")


def lookalike_shares(
    model: HonestModel,
    residual_rad: Array,
    room: Room,
    *,
    constant_room_rad: float | None = None,
    draws: int = DRAWS,
    seed: int = 0,
) -> dict[str, float]:
    """The share of each rival, by its name.

    Parameters: residual_rad (N,): of the film, fitted by `model`; room: gains that may be accepted; constant_room_rad:
        how far the phase constant may be from that at enrolment, None where none is known.

    Notes
    -----
    Source: the constant of fringes that drift, follow a place or move by themselves is any of a turn, so of a known one
    they meet so much by chance; that of late fringes follows from the delay.
    """
    series, rng = model.series, np.random.default_rng(seed)
    noise = resampled(residual_rad, series.step_s, rng, draws)
    most = ALIKE_RATIO * float(spread_rad(residual_rad[:, None])[0])

    def share(name: str, phases: Array) -> float:
        fit = model.fit(series.centred(phases + RESAMPLED_SHARE * noise[:, : phases.shape[1]]))
        alike = (room[0] <= fit.gain) & (fit.gain <= room[1])
        if constant_room_rad is not None and name == "late":
            alike &= np.abs(series.weight @ phases) <= constant_room_rad * series.weight.sum()
        if alike.any():
            alike[alike] = spread_rad(fit.residual_rad[:, alike]) <= most
        met = 1.0
        if constant_room_rad is not None and name in BY_CHANCE:
            met = min(1.0, constant_room_rad / np.pi)
        return met * float(alike.mean())

    drawn = {rival.name: rival.draws(series, rng, draws, room) for rival in RIVALS}
    return {name: share(name, phases) if phases.shape[1] else 0.0 for name, phases in drawn.items()}


def resampled(residual_rad: Array, step_s: float, rng: np.random.Generator, count: int) -> Array:
    """The residual (N,) in blocks from random places and with random signs, (N, count)."""
    length = len(residual_rad)
    block = min(max(round(RESAMPLED_S / step_s), 3), length)
    pieces = -(-length // block)
    begins = rng.integers(0, length - block + 1, (pieces, 1, count))
    signs = rng.choice((-1.0, 1.0), (pieces, 1, count))
    found = residual_rad[begins + np.arange(block)[:, None]] * signs
    return np.asarray(found.reshape(pieces * block, count)[:length])
