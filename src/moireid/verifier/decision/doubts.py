"""What may make the film of a true badge look forged, weighed before gain, law and parts are tested.

A doubt widens what a true badge's film may show; it lets nothing pass, as forgers can make it, too.

| doubt | what it widens |
|---|---|
| the camera was zoomed, reframed or stabilised, or frames were mixed | gains and residuals |
| markers so small that errors of poses may be all the motion | any gain, residual and part |
| a hand, a caption or glare covers rows | any residual; the code's rows may move apart |
| the page or the sheet is off its size | any gain, residual and part |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from moireid.verifier import limits
from moireid.verifier.decision.comparison import GratingComparison, enough_motion_rad
from moireid.verifier.fringes.grating_signal import GratingSignal
from moireid.verifier.reasons import Reason


def camera_doubted(signal: GratingSignal) -> bool:
    """Whether the film's own picture shows that it was zoomed, reframed, stabilised or mixed within."""
    return bool(
        signal.lasting_px > limits.MAX_LASTING_PX or signal.mixed_share > limits.MAX_MIXED_SHARE or signal.zoom > 1
    )


@dataclass(frozen=True)
class Doubts:
    """The findings about a film's camera, or small markers; and whether rows are covered."""

    camera: Reason | None = None
    small: Reason | None = None
    covered: bool = False


def doubts_of(moving: Sequence[tuple[GratingSignal, GratingComparison]]) -> Doubts:
    """The doubts about a film.  Parameters: moving: gratings that moved enough."""
    signals = [signal for signal, _ in moving]
    camera = _camera(signals) if any(one.doubted for _, one in moving) else None
    covered = any(signal.covered_share >= limits.MIN_ROWS_COVERED for signal in signals)
    small = None if camera is not None else _small(moving)
    return Doubts(camera, small, covered)


def _small(moving: Sequence[tuple[GratingSignal, GratingComparison]]) -> Reason | None:
    """The finding that markers are so small that the motion might not be enough."""
    # Errors of poses lower a gain by their power over that of the motion; they take none away.
    room = limits.GAIN_TOLERANCE_SHARE + (limits.SMALL_MARKER_DOUBT_RATIO / limits.MIN_EXCITATION_TO_ERROR_RATIO) ** 2
    if any(abs(one.figures.gain_ratio - 1) > room for _, one in moving):
        return None
    for signal, one in moving:
        needed = limits.SMALL_MARKER_DOUBT_RATIO * enough_motion_rad(one.figures.expected_error_rad)
        if signal.doubt > 1 and one.figures.excitation_rad < needed:
            text = (
                "The badge is so small in the picture that how it turned is uncertain, and the fringes prove nothing "
                "against it. Film from nearer, or move more."
            )
            return Reason("small", "undecided", one.figures.excitation_rad, needed, "rad", text)
    return None


def _camera(signals: Sequence[GratingSignal]) -> Reason:
    mixed, lasting = max(s.mixed_share for s in signals), max(s.lasting_px for s in signals)
    if mixed > limits.MAX_MIXED_SHARE:
        text = (
            "The fringes fade where they move, as in frames that are mixed with their neighbours by noise reduction or "
            "a changed frame rate. Film again with such functions off, or from nearer."
        )
        return Reason("mixed_frames", "undecided", mixed, limits.MAX_MIXED_SHARE, "share", text)
    text = (
        "No single camera explains how the badge appears in the picture, so it may have been zoomed, reframed or "
        "stabilised. Give the film as the camera took it, or film again with such functions off."
    )
    return Reason("camera", "undecided", lasting, limits.MAX_LASTING_PX, "px", text)
