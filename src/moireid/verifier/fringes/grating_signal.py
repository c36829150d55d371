"""The signal of one grating: its fringe phase as measured and as predicted, and what else a film shows of it.

A film of several chapters has one signal for each; `joined` puts them together.

Convention: phases in rad, positive where the fringe is ahead; one entry per frame, (T,), where nothing else is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Fields of a signal, and of what it shows beyond the phase, that chapters join in time as they are.
IN_TIME = ("measured_rad", "predicted_rad", "air_rad", "phase_rad", "phase_sd_rad", "times_s")
BEYOND_IN_TIME = ("law_rad", "overtone", "place_px", "expected")
#: Fields of a signal of which the whole has the greatest, and the mean, of its chapters'.
GREATEST = ("tangent_sd", "shape_sd_rad", "focal_at_limit", "parallel", "lasting_px", "doubt", "zoom", "mixed_share")
MEAN = ("rounding_rad", "stray_share", "covered_share", "held_share", "aside_share")
#: Figures of each strip of which the whole has the greatest.
WORST = ("strip_residual_rad", "place_residual_rad", "strip_noise_rad")


class DepthLaw(NamedTuple):
    """Evidence of one strip or grating on the spacing of the fringes against the camera's distance, frame by frame.

    Sums over frames, strips and gratings are evidence too.  score (T,) and information (T,): the gain less 1 is the sum
    of scores over the sum of information; power (T,): information times the square of the predicted change along the
    strip, rad^2.
    """

    score: Array
    information: Array
    power: Array

    def under(self, gain: float) -> DepthLaw:
        """The same where that many times the change of spacing is predicted.

        Source: what is left of the picture is regressed on the pattern, which grows as the prediction does.
        """
        score = gain * (self.score - (gain - 1) * self.information)
        return DepthLaw(score, gain**2 * self.information, gain**4 * self.power)


@dataclass(frozen=True)
class BeyondPhase:
    """law_rad (T,): predicted phase, with one constant for the whole film; depth: the spacing against distance;
    overtone (T,), complex: the third harmonic, as `StripPhase.overtone`; place_px (T, 2): of the badge's middle in the
    picture; expected (T,), complex: as `beyond_phase.expected_overtone`.
    """

    law_rad: Array
    depth: DepthLaw
    overtone: NDArray[np.complex128]
    place_px: Array
    expected: NDArray[np.complex128]

    def part(self, frames: NDArray[np.int64] | slice) -> BeyondPhase:
        """The same in some frames."""
        cut: dict[str, Any] = {name: getattr(self, name)[frames] for name in BEYOND_IN_TIME}
        return replace(self, depth=DepthLaw(*(series[frames] for series in self.depth)), **cut)

    def under(self, gain: float) -> BeyondPhase:
        """The same for a sheet that moves fringes that many times as far; as `GratingSignal.under`."""
        return replace(self, law_rad=gain * self.law_rad, depth=self.depth.under(gain))


@dataclass(frozen=True)
class GratingSignal:
    """One grating over the frames used, all (T,) but where said.

    times_s: of the frames; stretch: the number of each frame's stretch (`camera.stretches`), rising, all 0 if none is
    given; measured_rad: fringe phase, unwrapped, and predicted_rad: from the optics, both with mean 0 in each stretch;
    phase_sd_rad: error bar of the measured phase, infinite in unreadable frames; pose_sd_rad: error of the prediction
    from the smoothed pose; strip_residual_rad (S,): deviation of each strip from the common signal, root mean square;
    place_residual_rad (S,): deviation of places along each strip from it (`strip_shape`); strip_noise_rad (S,):
    deviation of each strip's contrast from the common one, over its median, empty if none is given; tangent_sd: error
    of the spread of the parallax along the grating's axis from focal length and distortion, as a share; shape_sd_rad:
    what else these move the predicted phase by, which lasts all film long; covariates (T, 2): the camera's parallax
    along the lines, and one over its distance, 1/mm, if known; strip_sd_rad (S,): error bar of each strip's phase,
    median over its frames; rounding_rad: phase error of a place from rounding to whole counts, median over its strips;
    covered_share: share of strips and frames that something covers; held_share: share of frames in which something
    covers a marker or a part of the frame; stray_share: share of frames whose markers do not lie as on a flat page, so
    that their poses are left out; focal_at_limit, parallel, lasting_px, zoom: as in `CameraFit`; doubt: by how much
    small markers may err more than the error bars say, 1 for others; mixed_share: as in `mixed_frames`; beyond: what
    the film shows apart from the phase, None if it is not known; phase_rad: the measured phase with one phase constant
    for all stretches, as `measured_rad` if none is given; lens_room: as in `CameraFit`; air_rad: what is added to
    predicted_rad if the sheet is not glued but laid on (`strip_law.air_law`), 0 if none is given; aside_share: share of
    frames that show it from beyond `lenticule.critical_tangent`.
    """

    measured_rad: Array
    predicted_rad: Array
    phase_sd_rad: Array
    pose_sd_rad: float
    strip_residual_rad: Array
    times_s: Array
    place_residual_rad: Array = field(default_factory=lambda: np.zeros(0))
    strip_noise_rad: Array = field(default_factory=lambda: np.zeros(0))
    tangent_sd: float = 0.0
    shape_sd_rad: float = 0.0
    covariates: Array | None = None
    strip_sd_rad: Array = field(default_factory=lambda: np.zeros(0))
    rounding_rad: float = 0.0
    covered_share: float = 0.0
    held_share: float = 0.0
    aside_share: float = 0.0
    stray_share: float = 0.0
    focal_at_limit: bool = False
    parallel: bool = False
    lasting_px: float = 0.0
    doubt: float = 1.0
    zoom: float = 1.0
    mixed_share: float = 0.0
    beyond: BeyondPhase | None = None
    phase_rad: Array = field(default_factory=lambda: np.zeros(0))
    lens_room: tuple[float, float] = (1.0, 1.0)
    air_rad: Array = field(default_factory=lambda: np.zeros(0))
    stretch: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def __post_init__(self) -> None:
        """One stretch, where none are given."""
        if not len(self.phase_rad):
            object.__setattr__(self, "phase_rad", self.measured_rad)
        if not len(self.stretch):
            object.__setattr__(self, "stretch", np.zeros(len(self.times_s), np.int64))
        if not len(self.air_rad):
            object.__setattr__(self, "air_rad", np.zeros(len(self.times_s)))

    def under(self, gain: float) -> GratingSignal:
        """The signal for a sheet that moves fringes `gain` times as far as this prediction.

        Source: the law is proportional to the sheet's effective gap, its bend with the angle aside.
        """
        if gain == 1:
            return self
        return replace(
            self,
            predicted_rad=gain * self.predicted_rad,
            air_rad=gain * self.air_rad,
            pose_sd_rad=gain * self.pose_sd_rad,
            shape_sd_rad=gain * self.shape_sd_rad,
            beyond=None if self.beyond is None else self.beyond.under(gain),
        )

    def part(self, frames: NDArray[np.int64] | slice) -> GratingSignal:
        """The signal in some frames."""
        beyond = None if self.beyond is None else self.beyond.part(frames)
        places = None if self.covariates is None else self.covariates[frames]
        cut: dict[str, Any] = {name: getattr(self, name)[frames] for name in (*IN_TIME, "stretch")}
        return replace(self, covariates=places, beyond=beyond, **cut)


def joined(signals: Sequence[GratingSignal]) -> GratingSignal:
    """The signals of one grating from several chapters, joined in time.

    Notes
    -----
    Convention: no stretch continues from one chapter to the next, and the camera's places are counted from each
    chapter's mean.  Errors and shares are those of the worst chapter, or means over chapters, as `GREATEST` and `MEAN`
    name them.
    """

    def each(name: str) -> list[Any]:
        return [getattr(signal, name) for signal in signals]

    numbers, places = each("stretch"), [place for place in each("covariates") if place is not None]
    begins = np.cumsum([0, *(own[-1] - own[0] + 1 for own in numbers[:-1])])
    merged: dict[str, Any] = {name: np.concatenate(each(name)) for name in IN_TIME}
    merged |= {name: max(each(name)) for name in GREATEST}
    merged |= {name: float(np.mean(each(name))) for name in MEAN}
    return GratingSignal(
        **merged,
        stretch=np.concatenate([own - own[0] + begin for own, begin in zip(numbers, begins, strict=True)]),
        pose_sd_rad=float(np.sqrt(np.mean([sd**2 for sd in each("pose_sd_rad")]))),
        **{name: np.max(each(name), axis=0) for name in WORST},
        strip_sd_rad=np.mean(each("strip_sd_rad"), axis=0),
        covariates=np.concatenate([p - p.mean(axis=0) for p in places]) if len(places) == len(signals) else None,
        beyond=joined_beyond(each("beyond")),
        lens_room=(min(low for low, _ in each("lens_room")), max(high for _, high in each("lens_room"))),
    )


def joined_beyond(parts: Sequence[BeyondPhase | None]) -> BeyondPhase | None:
    """What several chapters show beyond the phase, one after another; None unless all are known."""
    known = [part for part in parts if part is not None]
    if len(known) < len(parts):
        return None
    merged: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in known]) for name in BEYOND_IN_TIME}
    return replace(
        known[0], depth=DepthLaw(*map(np.concatenate, zip(*(one.depth for one in known), strict=True))), **merged
    )
