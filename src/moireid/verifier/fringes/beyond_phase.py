"""What a film shows of a grating beside its phase: evidence that photographs laid over a film do not give.

Convention: one entry per frame, (T,), over the frames of the signal to which it belongs (`signals.GratingSignal`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from moireid.badge import Cell, Lens
from moireid.verifier.fringes.depth_law import DepthLaw
from moireid.verifier.fringes.strip_phase import StripPhase

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BeyondPhase:
    """law_rad (T,): predicted phase, with one constant for the whole film; depth: the spacing against distance;
    overtone (T,), complex: the third harmonic, as `StripPhase.overtone`; place_px (T, 2): of the badge's middle in the
    picture; third_share: as of that name.
    """

    law_rad: Array
    depth: DepthLaw
    overtone: NDArray[np.complex128]
    place_px: Array
    third_share: float = 1.0

    def part(self, frames: NDArray[np.int64] | slice) -> BeyondPhase:
        """The same in some frames."""
        return replace(
            self,
            law_rad=self.law_rad[frames],
            depth=self.depth.part(frames),
            overtone=self.overtone[frames],
            place_px=self.place_px[frames],
        )

    def under(self, gain: float) -> BeyondPhase:
        """The same for a sheet that moves fringes that many times as far; as `GratingSignal.under`."""
        return replace(self, law_rad=gain * self.law_rad, depth=self.depth.under(gain))


def joined_in_time(parts: Sequence[BeyondPhase | None]) -> BeyondPhase | None:
    """Those of several chapters, one after another; None unless all are known."""
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    depths = [part.depth for part in known]
    return BeyondPhase(
        np.concatenate([part.law_rad for part in known]),
        DepthLaw(
            np.concatenate([depth.score for depth in depths]),
            np.concatenate([depth.information for depth in depths]),
            np.concatenate([depth.power for depth in depths]),
        ),
        np.concatenate([part.overtone for part in known]),
        np.concatenate([part.place_px for part in known]),
        known[0].third_share,
    )


def third_share(lens: Lens, cells: Sequence[Cell]) -> float:
    """The third harmonic of a grating's lines over their first, against that of lines as wide as the gaps.

    Source: Fourier coefficients of a rectangle of width d, sin(3 pi d) / (3 sin(pi d)), each a third where d is a half;
        a mask's openings add a like factor.
    """
    widths = [float(np.mean([cell.duty for cell in cells]))]
    if lens.open_fraction is not None:
        widths.append(lens.open_fraction)
    return float(np.prod([abs(np.sin(3 * np.pi * width) / np.sin(np.pi * width)) for width in widths]))


def mean_overtone(strips: Sequence[StripPhase]) -> NDArray[np.complex128]:
    """Of several strips, (T,), each weighted by how little it trembles from frame to frame."""
    trembling = np.array([np.median(np.abs(np.diff(strip.overtone))) for strip in strips])
    weight = np.where(trembling > 0, 1.0 / np.maximum(trembling, 1e-9) ** 2, 0.0)
    if not weight.sum() > 0:
        return np.zeros(len(strips[0].overtone), complex)
    seen = np.nan_to_num(np.array([strip.overtone for strip in strips]))
    return np.asarray(weight @ seen / weight.sum())
