"""What gain a badge's sheet has: as designed, as measured at enrolment, or still to be measured.

Gain is a property of the built badge: sheets of one pitch are sold in several thicknesses, and air between sheet and
page lets fringes move farther still.  So a badge that was never measured may have any gain that a sheet as sold can
give it; such a film is inconclusive, since the gain alone cannot distinguish a thin sheet from a forgery.

Convention: `expected` is over the design; signals are judged under it (`GratingSignal.under`), so that 1 is what is
expected, and all other gains here are shares of it.
Source: `moireid.sheets.possible_gains`; limits by `verifier.limits`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from moireid.asbuilt import AsBuilt
from moireid.badge import Badge
from moireid.sheets import possible_gains
from moireid.verifier import limits
from moireid.verifier.reasons import Level, Reason


@dataclass(frozen=True)
class SheetGain:
    """The gain that a badge's sheet is expected to have.

    expected: over the design; sd: its standard deviation as a share; room: what may be accepted at most, least and
    greatest; handled: gains that assembly and a shop's sheet can give, or None; measured:
    whether the film is to measure the gain, and any within the room will do; built: whether `expected` was measured.
    """

    expected: float = 1.0
    sd: float = 0.0
    room: tuple[float, float] = (1 - limits.GAIN_TOLERANCE_SHARE, 1 + limits.GAIN_TOLERANCE_SHARE)
    handled: tuple[float, float] | None = None
    measured: bool = False
    built: bool = False

    @property
    def reach(self) -> tuple[float, float]:
        """Least and greatest gain of a build of usual parts, error bars aside."""
        low, high = self.handled or self.room
        return min(low, self.room[0]), max(high, self.room[1])

    def possible(self, lens_room: tuple[float, float]) -> tuple[float, float]:
        """Least and greatest gain that a film can show of some build of this badge, by some camera, error bars aside.

        Parameters
        ----------
        lens_room : (float, float)
            As `CameraFit.lens_room`.

        Notes
        -----
        Convention: beyond it a film is rejected; within it, but for the room, it is inconclusive.
        Source: build and lens have nothing to do with each other, so both are hardly extreme at once: the logarithms of
            their extremes add in squares.  With a product instead, a print that stays
            still (a gain of 0.04) could be a thin sheet before the longest lens.
        """
        low, high = self.reach if self.built else (limits.LEAST_BUILT_GAIN, math.inf)
        least = math.hypot(math.log(low), math.log(lens_room[0]))
        return math.exp(-least), math.exp(math.hypot(math.log(high), math.log(lens_room[1])))

    def room_for(self, gain_sd: float) -> tuple[float, float]:
        """Least and greatest gain that a film with that error bar may be accepted with."""
        if not self.built:
            return self.room
        half = max(limits.BUILT_GAIN_ROOM_SHARE, limits.BUILT_GAIN_SDS * math.hypot(gain_sd, self.sd))
        return max(1 - half, self.room[0]), min(1 + half, self.room[1])

    def span(self, half: float) -> str:
        """The room, widened to that half width, in words; over the design."""
        middle = (self.room[0] + self.room[1]) / 2
        if self.measured:
            return f"{self.expected * (middle - half):.2g} to {self.expected * (middle + half):.2g}"
        return f"{self.expected * middle:.3g} ± {self.expected * half:.2g}"

    def cause(self, gain: float) -> str:
        """What ordinary thing gives such a gain, and what to do; a sentence's end."""
        if self.built:
            sheet = "has come off the page" if gain > 1 else "lies nearer to the page"
            return (
                f"; when the badge was enrolled it was {self.expected:.3f}. A sheet that {sheet} does that, and so "
                "does another sheet. Press it flat and film again, or enroll the badge again with a new film of it."
            )
        sheet = "A thicker sheet, or air under it," if gain > 1 else "A thinner sheet"
        if self.measured:
            low, high = self.room
            room = f"a badge can be enrolled with {low:g} to {high:g}"
            return (
                f"; {room}. {sheet} does that. Press the sheet flat, use the one that the design names, and film again."
            )
        return f". {sheet} does that. Enroll this badge with a film of it."


#: Of a board of which nothing is known but its design.
DESIGNED = SheetGain()


def designed(badge: Badge) -> SheetGain:
    """Of a badge that was never measured."""
    return replace(DESIGNED, handled=_handled(badge))


def as_built(badge: Badge, built: AsBuilt) -> SheetGain:
    """Of a badge that was measured when it was enrolled."""
    gain = built.gain_ratio
    low, high = _handled(badge)
    return SheetGain(gain, built.gain_sd / gain, handled=(low / gain, high / gain), built=True)


def to_measure() -> SheetGain:
    """Of a badge that is being enrolled."""
    return replace(DESIGNED, room=limits.ENROLLED_GAINS, measured=True)


def _handled(badge: Badge) -> tuple[float, float]:
    """What shops and assembly can do to a badge, as far as it can be enrolled."""
    low, high = possible_gains(badge.lens, badge.gratings[0].pitch_mm)
    return max(low, limits.ENROLLED_GAINS[0]), min(high, limits.ENROLLED_GAINS[1])


def gain_reason(
    gain: float,
    gain_sd: float,
    sheet: SheetGain,
    possible: tuple[float, float],
    air_sd: float = 0.0,
    *,
    either_way: bool = False,
) -> Reason:
    """Pass within the room; fail by three error bars beyond what is possible at all; else inconclusive.

    The finding's limit is half the width of the room; of a failure, the gain that is the last possible one.

    Parameters: gain, gain_sd: over what is expected; possible: as `SheetGain.possible`, or wider where there is doubt;
        air_sd: the part of gain_sd that is owed to air, whose share a forger may choose; either_way: whether the film
        does not show in which direction the fringes should move (`CameraFit.parallel`), so that backwards is no proof.
    """
    sd = math.hypot(gain_sd, gain * sheet.sd)
    low, high = sheet.room_for(gain_sd)
    least, most = possible
    seen = abs(gain) if either_way else gain
    beyond = limits.GAIN_REJECTED_SDS * sd
    shown, limit = sheet.expected * gain, (high - low) / 2
    words = f"The fringes move {shown:.3f} ± {sheet.expected * gain_sd:.3f} times as far as they should by design"
    # With so wide an error bar even a wrong gain could be estimated as right, so the estimate does not count.
    vague = sd >= limits.MAX_GAIN_SD_SHARE * abs(gain) or limits.AIR_SDS * air_sd > limits.GAIN_TOLERANCE_SHARE
    level: Level = "undecided"
    if low <= gain <= high and not vague:
        level, text = "pass", f"{words}; a real badge gives {sheet.span(limit)}."
    elif not least - beyond <= seen <= most + beyond:
        bound = least - beyond if seen < least else most + beyond
        level, limit = "fail", bound
        whose, other = "this badge" if sheet.built else "a badge of any build", "less" if seen < least else "more"
        text = f"{words}; {whose}, seen through any lens that the film allows, gives no {other} than "
        text += f"{sheet.expected * bound:.2g}, three error bars included."
    elif vague or gain < 0:
        limit += beyond
        text = "How far the fringes move is too uncertain to decide. Give the camera's focal length, or film from the "
        text += "front and with more motion."
    else:
        text = words + sheet.cause(gain)
    return Reason("gain", level, shown, sheet.expected * limit, "ratio", text)


def lens_reason(gain: float, gain_sd: float, sheet: SheetGain, lens_room: tuple[float, float]) -> Reason | None:
    """The finding that the film does not show which lens took it, where another lens would explain a gain.

    Parameters: as `gain_reason`.
    """
    low, high = sheet.room_for(gain_sd)
    if low <= gain <= high or not low * lens_room[0] <= gain <= high * lens_room[1]:
        return None
    text = (
        "The film does not show which lens took it, and another one would explain how far the fringes move. State "
        "the camera's lens, or film again with the badge tilted by 15 to 25 degrees."
    )
    return Reason("lens", "undecided", lens_room[1] / lens_room[0], None, "ratio", text)
