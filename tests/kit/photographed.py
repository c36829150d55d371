"""Signals of a badge and of photographs of it, made without pictures."""

from __future__ import annotations

import math

import numpy as np

from moireid.verifier.decision.photographs import photographs, softest
from moireid.verifier.explanations.photographs.fringe_spacing import cross_faded, spacing_of
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw, GratingSignal
from moireid.verifier.reasons import Reason

FRAMES = 300
TIMES = np.arange(FRAMES) / 30.0
#: A hand's course: 5 rad of fringe phase from end to end.
LAW = 1.9 * np.sin(2 * np.pi * 0.31 * TIMES) + 0.8 * np.sin(2 * np.pi * 0.83 * TIMES + 1.0)
NEAR = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.23 * TIMES + 0.4))
#: The third harmonic of a badge, in contrasts.
TYPICAL = 0.08 * np.exp(0.7j)
#: Change of phase along a strip for which evidence is made, rad.
CHANGE_RAD = 0.004


def depth_of(
    gain: float, *, noise: float = 0.0, seed: int = 0, information: float = 1.0, change_rad: float = CHANGE_RAD
) -> DepthLaw:
    """Evidence of a spacing gain; noise: of a frame's gain, where its information is 1."""
    rng = np.random.default_rng(seed)
    known = information * rng.random(FRAMES)
    score = known * (gain - 1) + noise * np.sqrt(known) * rng.standard_normal(FRAMES)
    return DepthLaw(score, known, known * change_rad**2)


def signal(
    overtone: np.ndarray | None = None,
    *,
    law: np.ndarray = LAW,
    depth: DepthLaw | None = None,
    near: np.ndarray | None = NEAR,
    measured: np.ndarray | None = None,
    expected: np.ndarray | None = None,
) -> GratingSignal:
    """A badge's signal; its place in the picture says nothing."""
    rng = np.random.default_rng(5)
    beyond = BeyondPhase(
        law,
        depth or depth_of(1.0),
        np.full(FRAMES, TYPICAL) if overtone is None else overtone,
        rng.standard_normal((FRAMES, 2)),
        np.ones(FRAMES, complex) if expected is None else expected,
    )
    course = law - law.mean()
    return GratingSignal(
        course + 0.01 * rng.standard_normal(FRAMES) if measured is None else measured,
        course,
        np.full(FRAMES, 0.01),
        0.01,
        np.array([0.005, 0.01]),
        TIMES,
        np.array([0.02, 0.02]),
        covariates=None if near is None else np.column_stack([np.zeros(FRAMES), near]),
        beyond=beyond,
    )


def faded(count: int, law: np.ndarray = LAW) -> np.ndarray:
    """The overtone that so many cross-faded photographs of a badge show, turned to the fundamental."""
    first, third = cross_faded(law, np.linspace(law.min(), law.max(), count))
    return TYPICAL * third * np.exp(-3j * np.angle(first)) / np.abs(first)


def laid_over(count: int, strength: float, law: np.ndarray = LAW) -> np.ndarray:
    """The overtone that so many photographs, evenly over a turn, show where all are laid over each other."""
    taken = 2 * np.pi * np.arange(count) / count
    share = (1 + 2 * strength * np.cos(law[:, None] - taken)) / count
    first, third = (share @ np.exp(1j * h * taken) for h in (1, 3))
    # The measured phase is the law's less its mean (`signal`), and a third harmonic is seen from there.
    return TYPICAL * third * np.exp(-3j * np.angle(first)) / np.abs(first)


def noise_of(size: float, seed: int, lasting: float = 0.0) -> np.ndarray:
    """Complex noise of standard deviation `size` in each part, which correlates by `lasting` from frame to frame."""
    rng = np.random.default_rng(seed)
    drawn = rng.standard_normal((FRAMES, 2)) @ [1, 1j]
    noise = drawn.copy()
    for k in range(1, FRAMES):
        noise[k] = lasting * noise[k - 1] + math.sqrt(1 - lasting**2) * drawn[k]
    return size * noise


def found_in(*signals: GratingSignal) -> dict[str, Reason]:
    return {reason.code: reason for reason in photographs(spacing_of(signals), signals, softest(signals))}
