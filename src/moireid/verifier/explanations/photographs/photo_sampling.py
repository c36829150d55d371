"""Where would a forger take photographs of a badge for a film, and what would they show?

Convention: a place is a fringe phase, rad, with whole turns taken out, as a picture shows the same fringes a turn on.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Steps towards the places that are seen most, and by how much a place must move to be worth another.
LLOYD_STEPS, NEAR_RAD = 50, 1e-6


def in_one_turn(phase_rad: Array, stretch: NDArray[np.int64]) -> Array:
    """Phases (T,), each stretch moved by whole turns so that its mean is nearest to that of the longest one.

    Convention: a picture shows the same fringes a whole turn on, so a stretch that was read so shows no other pictures.
    """
    _, own = np.unique(stretch, return_inverse=True)
    frames = np.bincount(own)
    means = np.bincount(own, weights=phase_rad) / frames
    return np.asarray(phase_rad - 2 * np.pi * np.round((means - means[np.argmax(frames)]) / (2 * np.pi))[own])


def evenly(count: int, place_rad: Array) -> Array:
    """So many places, (count,), at even distances over all that are seen."""
    return np.linspace(place_rad.min(), place_rad.max(), count)


def seen_most(count: int, place_rad: Array) -> Array:
    """So many places, (count,), rising, that are nearest to those seen: where a forger would take photographs.

    Source: Lloyd (1982), on a line, from even shares of the frames; stops short of the best where it takes long.
    """
    place = np.sort(place_rad)
    before = np.r_[0.0, np.cumsum(place)]
    nodes = np.quantile(place, (np.arange(count) + 0.5) / count)
    for _ in range(LLOYD_STEPS):
        ends = np.r_[0, np.searchsorted(place, (nodes[1:] + nodes[:-1]) / 2), len(place)]
        frames = np.diff(ends)
        means = np.diff(before[ends]) / np.maximum(frames, 1)
        moved = np.where(frames > 0, means, nodes)
        if np.abs(moved - nodes).max() < NEAR_RAD:
            break
        nodes = moved
    # Two at one place would leave nothing to cross-fade between.
    return np.asarray(nodes + NEAR_RAD * np.arange(count))


def cross_faded(place_rad: Array, nodes: Array) -> tuple[Complex, Complex]:
    """First and third harmonic, each (T,), of 1 at best, of photographs cross-faded for phases (T,).

    Parameters: nodes (N,): phases at which they were taken, rising.
    """
    place = np.interp(place_rad, nodes, np.arange(len(nodes)))
    before = np.minimum(place.astype(int), len(nodes) - 2)
    share = place - before
    first, third = (
        (1 - share) * np.exp(1j * h * nodes[before]) + share * np.exp(1j * h * nodes[before + 1]) for h in (1, 3)
    )
    return first, third
