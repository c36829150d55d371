"""What excuses a failure: a hand, a caption, a camera that changes within the film, mixed frames, a tiny badge.

Any of these makes poses or phases wrong in a true film.  Where the picture shows one of them, what it can cause does
not fail: the film is open, with the cause named.  Nothing here lets a film pass, as forgers can do all of it too.
A correction by what these tell would: who fades the fringes as mixed frames do could then have a delay or a wrong gain
taken away, as the forger also chooses how the page moves in the picture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from moireid.verifier.fringes.signals import GratingSignal
from moireid.verifier.limits import (
    GAIN_TOLERANCE_SHARE,
    MAX_LASTING_PX,
    MAX_MIXED_SHARE,
    MIN_CORRELATION,
    MIN_EXCITATION_TO_ERROR_RATIO,
    MOST_ZOOM,
    SMALL_MARKER_DOUBT_RATIO,
    SUSPECT_PX,
)
from moireid.verifier.motion.sheet_gain import SheetGain
from moireid.verifier.reasons import Reason

#: What fails where poses or phases are wrong.  Strips share them, so they still must agree.
POSED = {"correlation", "gain", "likelihood", "residual"}
#: Derived: the doubted errors' power over that of the least motion.
SMALL_GAIN_ROOM = (SMALL_MARKER_DOUBT_RATIO / MIN_EXCITATION_TO_ERROR_RATIO) ** 2


def without_hand_s_blame(reasons: list[Reason]) -> list[Reason]:
    """Findings without a failure that whatever covers the badge may have caused: such a film is open, not rejected.

    A hand or a caption disturbs poses and phases; it turns no fringes round, and halves no gain.
    """
    if all(reason.code != "covered" for reason in reasons):
        return reasons
    return _open(reasons, {"agreement", "likelihood", "residual"})


def without_camera_s_blame(reasons: list[Reason], signals: Sequence[GratingSignal], sheet: SheetGain) -> list[Reason]:
    """Findings without a failure that a zoom, a moving crop, a stabiliser or mixed frames may have caused.

    Mixed frames move the page's edges too, from which a zoom is then read where there is none; such a film is open.
    """
    codes = {reason.code: reason for reason in reasons}
    mixed, lasting_px = max(s.mixed_share for s in signals), max(s.lasting_px for s in signals)
    failed = {code for code in POSED if code in codes and codes[code].level == "fail"}
    # Where these leave a film open by themselves, the cause is named too; a hand or a caption is named already.
    opened = any(codes[code].level == "undecided" for code in POSED | {"motion"} if code in codes)
    troubled = bool(failed) or (opened and "covered" not in codes)
    if mixed > MAX_MIXED_SHARE and (troubled or max(s.zoom for s in signals) > 1):
        return [*_open(reasons, POSED), _mixed(mixed)]
    if lasting_px > MAX_LASTING_PX and troubled:
        why = "No single camera explains how the badge lies in the picture"
    elif failed and _looks_zoomed(codes, sheet):
        why = "The fringes' spacing does not follow the distance"
    elif lasting_px > SUSPECT_PX and failed and failed <= {"likelihood", "residual"} and codes["gain"].level != "pass":
        why = "The camera's focal length is doubtful, as the badge does not lie quite where one camera puts it"
    elif failed and max(s.doubt for s in signals) > 1 and (tiny := _too_small(codes, sheet)) is not None:
        return [*_open(reasons, POSED), tiny]
    else:
        return reasons
    return [*_open(reasons, POSED), _changed(why, lasting_px)]


def _open(reasons: Sequence[Reason], codes: set[str]) -> list[Reason]:
    """The findings, those of `codes` undecided where they failed."""
    return [
        replace(reason, level="undecided") if reason.level == "fail" and reason.code in codes else reason
        for reason in reasons
    ]


def _looks_zoomed(codes: Mapping[str, Reason], sheet: SheetGain) -> bool:
    """Whether fringes tell of another distance than the page's size, and move as far as after a zoom.

    A zoom about the picture's middle hardly shows in the poses where the badge is seen from the front.  One by up to
    two scales the motion by as much, which leaves a correlation of 0.95 (Cauchy and Schwarz); what else a film may
    lose is another 0.95.
    """
    spacing, gain, correlation = codes.get("spacing"), codes["gain"].measured, codes["correlation"].measured
    if spacing is None or spacing.level != "undecided":
        return False
    if not (isinstance(gain, float) and isinstance(correlation, float)) or correlation < MIN_CORRELATION**2:
        return False
    return 1 / MOST_ZOOM < gain / sheet.expected < MOST_ZOOM


def _too_small(codes: Mapping[str, Reason], sheet: SheetGain) -> Reason | None:
    """The finding that markers are small, where the motion would not be enough if poses erred as much as they may.

    Source: errors of the prediction lower the gain by their power over that of the motion (errors in variables), by
        `SMALL_GAIN_ROOM` at most where the motion is enough by what is told; one farther off has another cause.
    """
    motion, gain = codes["motion"], codes["gain"].measured
    if not (isinstance(motion.measured, float) and isinstance(motion.limit, float) and isinstance(gain, float)):
        return None
    if abs(gain / sheet.expected - 1) > GAIN_TOLERANCE_SHARE + SMALL_GAIN_ROOM:
        return None
    needed = SMALL_MARKER_DOUBT_RATIO * motion.limit
    text = (
        "The badge is so small in the picture that how it turned is uncertain, and the fringes prove nothing against "
        "it. Film from nearer, or move more."
    )
    return Reason("small", "undecided", motion.measured, needed, "rad", text) if motion.measured < needed else None


def _mixed(share: float) -> Reason:
    text = (
        "The fringes fade where they move, as in frames that are mixed with their neighbours by noise reduction or a "
        "changed frame rate, and then cannot be measured well. Film again with such functions off, or from nearer."
    )
    return Reason("mixed_frames", "undecided", share, MAX_MIXED_SHARE, "share", text)


def _changed(why: str, lasting_px: float) -> Reason:
    text = (
        f"{why}, so the picture may have been zoomed, reframed or stabilised. Give the film as the camera took it, or "
        "film again with such functions off."
    )
    return Reason("camera", "undecided", lasting_px, MAX_LASTING_PX, "px", text)
