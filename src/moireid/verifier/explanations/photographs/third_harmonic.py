"""Does the third harmonic turn with the fringes, as on a badge?

On a badge it turns three times while the fringes pass once, so that a fringe keeps its shape.  Photographs that are all
superposed, each as strongly as the fringes' place asks, give a fundamental that is right in any place.  But the third
harmonics of three, taken a third of a turn apart, are alike and stay still; those of five or six, or of blurred ones,
are gone.

A true badge has a little that stays still too: the printer's dots make lines wider here and narrower there, and where
that beats at a third of a fringe it is read as third harmonic.  Dirt and uneven lenses do the same.

Views from aside and a soft picture take from a badge's third harmonic too.  How much is known, from the optics and from
the page's printed edges; where noise hides what is left, a film shows nothing.

Convention: contrasts, as `StripPhase.overtone`; seen from the fringes, what turns with them rests, and what stays still
turns back by three turns in each of theirs.  A view is a fringe phase that differs from others by `REST_RAD`; it counts
once, however long it is seen, so that a badge may rest.
Source: Fourier series; sampling at three places a turn takes the third harmonic for a constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.explanations.photographs.fringe_spacing import in_one_turn
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.limits import LEAST_OVERTONE_CONTRASTS, PHOTOGRAPH_SDS, REST_RAD, WINDOW_FRAMES

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Errors of a harmonic last over some frames, so that so many count as one, at most: what changes more slowly is the
#: sheet's own.  Set by hand.
MOST_LASTING_FRAMES = 4.0
#: Optics that let through less than this let nothing through but rounding errors.
LEAST_EXPECTED = 1e-6
#: The third harmonic of two gratings of half-wide lines, contrasts; lenses that focus have more.
GRATINGS_CONTRASTS = 1 / 9


@dataclass(frozen=True)
class ThirdHarmonic:
    """What of the third harmonic turns with the fringes, how much does not, and their error; contrasts.

    still: what stays still, and what turns as a mirror image does.
    sd: standard deviation of either; let_through: share of it that optics and picture let through, 1 for a sharp film
    from the front.
    """

    size: complex
    still: float
    sd: float
    let_through: float = 1.0

    @property
    def limit(self) -> float:
        """Of the surplus that is surely a badge's."""
        return math.hypot(LEAST_OVERTONE_CONTRASTS, PHOTOGRAPH_SDS * self.sd)

    @property
    def surplus(self) -> float:
        """What turns with the fringes, less what stays still."""
        return abs(self.size) - self.still

    @property
    def visible(self) -> bool:
        """Whether the film would show the edges of a badge's fringes; noise hides a third of them at most, as a forger
        may draw it.
        """
        return GRATINGS_CONTRASTS * self.let_through >= min(self.limit, GRATINGS_CONTRASTS / 3)

    @property
    def from_front(self) -> float | None:
        """The surplus as a sharp film would show it from the front; None where this one shows nothing."""
        return self.surplus / self.let_through if self.visible else None

    @property
    def seen(self) -> bool:
        """Whether the fringes have the sharp edges of a badge."""
        return self.surplus >= self.limit

    @property
    def missed(self) -> bool:
        """Whether they have not, though the film would show them, or more stays still for sure than turns."""
        return not self.seen and (self.visible or self.surplus <= -self.limit)


def third_harmonic_of(signal: GratingSignal) -> ThirdHarmonic | None:
    """What of a grating's third harmonic turns with the fringes; None where none was looked for, or in too few frames.

    Less is expected of lines that are not half as wide as their pitch, of views from the side, and of soft pictures
    (`expected_overtone`).
    """
    used = np.isfinite(signal.phase_sd_rad)
    if signal.beyond is None or used.sum() < WINDOW_FRAMES or not signal.beyond.overtone[used].any():
        return None
    overtone, expected, phase_rad = signal.beyond.overtone[used], signal.beyond.expected[used], signal.phase_rad[used]
    weight = _share_of_view(in_one_turn(phase_rad, signal.stretch[used]))
    root = np.sqrt(weight)[:, None]
    usual = float(np.average(np.abs(expected), weights=weight))
    turning = expected / usual if usual > LEAST_EXPECTED else np.ones(len(phase_rad))
    # Three photographs have three real weights, and so a third harmonic of one fixed direction: half of it mirrors.
    still, mirrored = np.exp(-3j * phase_rad), np.conj(turning) * np.exp(-6j * phase_rad)
    table = root * np.column_stack([turning, still, mirrored])
    seen = root[:, 0] * overtone
    found, *_ = np.linalg.lstsq(table, seen, rcond=None)
    left = seen - table @ found
    noise = float(np.vdot(left, left).real) / max(len(left) - 3, 1) * _lasting_frames(left)
    own, of_still, of_mirrored = noise * np.diag(np.linalg.pinv(table.conj().T @ table)).real
    mirror = math.sqrt(max(abs(complex(found[2])) ** 2 - of_mirrored, 0.0))
    still_size = abs(complex(found[1])) + mirror
    return ThirdHarmonic(complex(found[0]), still_size, math.sqrt(own + of_still), min(usual, 1.0))


def _share_of_view(phase_rad: Array) -> Array:
    """The share of a view that each frame is, (T,): one over the frames that show the same."""
    phase = np.sort(phase_rad)
    alike = np.searchsorted(phase, phase_rad + REST_RAD, "right") - np.searchsorted(phase, phase_rad - REST_RAD, "left")
    return np.asarray(1 / alike)


def _lasting_frames(left: Complex) -> float:
    """How many frames errors last, 1 for independent ones, `MOST_LASTING_FRAMES` at most.

    Source: variance of the mean of a first-order autoregressive series over that of independent errors.
    """
    alike = float(np.vdot(left[1:], left[:-1]).real) / max(float(np.vdot(left, left).real), 1e-30)
    alike = min(max(alike, 0.0), 0.99)
    return min((1 + alike) / (1 - alike), MOST_LASTING_FRAMES)
