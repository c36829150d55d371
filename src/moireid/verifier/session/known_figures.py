"""A capture's figures against those that are known of a badge: they may not take their place unseen.

1. No figures are known: the gain must be one that lens sheets can have under this design (`sheet_gain.designed`).
2. They differ from those in use, by `compare_built` or in their gain: they are another build, or no build at all.
3. They agree: those in use stay, as else a film that shows less would widen what agrees, and many small steps would
   lead anywhere; but figures that also say what those in use do not (a newer model, a map of places) are taken.

What is refused here needs a reason and the authority's signature (`Registry.store_as_built`): a forger who can draw
films, and cannot sign, changes nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from moireid.asbuilt import MODEL, AsBuilt
from moireid.badge import Badge
from moireid.verifier.decision.sheet_gain import designed
from moireid.verifier.identity.compare_built import compare_built
from moireid.verifier.limits import GAIN_REJECTED_SDS
from moireid.verifier.session.capture import gain_room

#: An error bar that is larger than the known one by more than this is of a film that shows less.  Set by hand.
LESS_SURE_RATIO = 2.0
#: Value and standard deviation of a figure in `AsBuilt`, with its name and unit.
FIGURES = (
    ("beat", "cycles/mm", "beat_frequency_per_mm", "beat_frequency_sd"),
    ("offset", "rad", "offset_rad", "offset_sd"),
    ("twist", "rad/mm", "twist_rad_per_mm", "twist_sd"),
    ("gain", "", "gain_ratio", "gain_sd"),
)


@dataclass(frozen=True)
class FigurePair:
    """One figure of a capture next to the known one.

    known, known_sd: None where none is known; apart_sds: difference over the error bars of both, None likewise; limit:
    how large the difference may be, with what weather and repetition do.
    """

    name: str
    unit: str
    known: float | None
    known_sd: float | None
    new: float
    new_sd: float
    difference: float | None = None
    limit: float | None = None

    @property
    def apart_sds(self) -> float | None:
        """The difference in error bars."""
        if self.difference is None or self.known_sd is None:
            return None
        return self.difference / max(math.hypot(self.known_sd, self.new_sd), 1e-12)

    @property
    def limit_sds(self) -> float | None:
        """How many error bars apart it may be."""
        if self.apart_sds is None or not self.difference or self.limit is None:
            return None
        return self.apart_sds * self.limit / self.difference

    @property
    def differs(self) -> bool:
        """Whether it is another figure."""
        return self.difference is not None and self.limit is not None and self.difference > self.limit


@dataclass(frozen=True)
class CaptureComparison:
    """What a capture's figures are next to the known ones, figure by figure.

    outcome: "new" where none are known; "same": they agree; "refines": they agree, and say more; "differs"; "odd": none
    are known, and no sheet that is sold explains the gain.
    """

    outcome: Literal["new", "same", "refines", "differs", "odd"]
    pairs: tuple[FigurePair, ...]

    @property
    def refused(self) -> bool:
        """Whether the figures need a reason and a signature."""
        return self.outcome in ("differs", "odd")

    @property
    def text(self) -> str:
        """Why they are refused; a sentence's end."""
        if self.outcome == "odd":
            return "no lens sheet as sold, with air under it or without, moves fringes so far under this design"
        return f"its figures differ from the known ones ({', '.join(one.name for one in self.pairs if one.differs)})"


def compare_capture(new: AsBuilt, known: AsBuilt | None, badge: Badge) -> CaptureComparison:
    """Compare a capture's figures with those in use.

    Parameters
    ----------
    new : AsBuilt
        Of the capture.
    known : AsBuilt or None
        Figures in use; None if there are none.
    badge : Badge
        As it was issued.

    Returns
    -------
    CaptureComparison
        The figures side by side.

    Notes
    -----
    Convention: differences are without sign.
    Source: module docstring; limits of `compare_built` and `capture.gain_room`.
    """
    if known is None:
        (low, high), beyond = designed(badge).reach, GAIN_REJECTED_SDS * new.gain_sd
        explained = low - beyond <= new.gain_ratio <= high + beyond
        pairs = tuple(FigurePair(name, unit, None, None, *_figure(new, names)) for name, unit, *names in FIGURES)
        return CaptureComparison("new" if explained else "odd", pairs)
    compared = compare_built(new, known, badge)
    apart = {reason.code.removeprefix("as_built_"): (reason.measured, reason.limit) for reason in compared.reasons}
    apart["gain"] = (abs(new.gain_ratio - known.gain_ratio), gain_room(known, new))
    pairs = tuple(
        FigurePair(name, unit, *_figure(known, names), *_figure(new, names), *map(_number, apart[name]))
        for name, unit, *names in FIGURES
    )
    if "map" in apart:
        sds = known.place_map_sd or math.nan, new.place_map_sd or math.nan
        pairs += (
            FigurePair("map off", "rad", 0.0, sds[0], _number(apart["map"][0]), sds[1], *map(_number, apart["map"])),
        )
    if any(pair.differs for pair in pairs):
        return CaptureComparison("differs", pairs)
    return CaptureComparison("refines" if _says_more(new, known) else "same", pairs)


def _figure(built: AsBuilt, names: list[str]) -> tuple[float, float]:
    value, sd = (float(getattr(built, name)) for name in names)
    return value, sd


def _number(value: object) -> float:
    assert isinstance(value, float)
    return value


def _says_more(new: AsBuilt, known: AsBuilt) -> bool:
    """Whether figures say what the known ones do not, and are as certain and as sharp in all else."""
    more = known.model < new.model <= MODEL or bool(new.place_maps and not known.place_maps)
    sure = all(getattr(new, sd) <= LESS_SURE_RATIO * getattr(known, sd) for *_, sd in FIGURES)
    sharp = (new.third_harmonic or 0.0) >= (known.third_harmonic or 0.0) / LESS_SURE_RATIO
    return more and sure and sharp and (bool(new.place_maps) or not known.place_maps)


def side_by_side(pairs: tuple[FigurePair, ...]) -> list[str]:
    """A table of known and new figures, each with its error bar, one line a figure."""
    lines = [f"{'figure':<17}{'known':>22}{'new':>22}  apart, in error bars"]
    for one in pairs:
        name = f"{one.name}, {one.unit}" if one.unit else one.name
        known = "none" if one.known is None else f"{one.known:.5g} ± {one.known_sd:.2g}"
        apart = "" if one.apart_sds is None else f"{one.apart_sds:.1f}"
        apart += "" if one.limit_sds is None else f" of {one.limit_sds:.1f} allowed{' ✗' if one.differs else ''}"
        lines.append(f"{name:<17}{known:>22}{f'{one.new:.5g} ± {one.new_sd:.2g}':>22}  {apart}".rstrip())
    return lines
