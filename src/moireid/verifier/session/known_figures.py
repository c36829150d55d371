"""A capture's figures against those that are known of a badge: they may not take their place unseen.

1. No figures are known: the gain must be one that lens sheets can have under this design (`sheet_gain.designed`), and
   the place of the sheet known well enough to distinguish copies (`MOST_OFFSET_SD_RAD`).
2. They differ from those in use, by `compare_built.agree`: they are another build, or no build at all.
3. They agree: those in use stay, as else a film that shows less would widen what agrees, and many small steps would
   lead anywhere; but figures that also say what those in use do not (a map of places, a live check) are taken.
   Where a live check agrees with those of a film, and is too unsure for its own to be taken, they stay, and count as
   witnessed from then on, if it knows the place of the sheet as a first capture must.

What is refused here needs a reason and the authority's signature (`Registry.store_as_built`): a forger who can draw
films, and cannot sign, changes nothing.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Literal

from moireid.asbuilt import AsBuilt, as_built_from_json
from moireid.badge import Badge
from moireid.errors import SpecError
from moireid.verifier.decision.sheet_gain import designed
from moireid.verifier.fringes.place_map import knots_mm
from moireid.verifier.identity.compare_built import FIGURES, FigurePair, agree
from moireid.verifier.limits import ENROLLED_GAINS, GAIN_REJECTED_SDS
from moireid.verifier.measuring import AGREES_SDS

#: An error bar that is larger than the known one by more than this is of a film that shows less.  Set by hand.
LESS_SURE_RATIO = 2.0
#: A copy's sheet may lie anywhere over the lines: with a larger standard deviation its place would agree with that of
#: more than a quarter of all copies.  The share is set by hand; 28 enrolments of two films have 0.002 to 0.025 rad.
MOST_OFFSET_SD_RAD = math.pi / 4 / AGREES_SDS


@dataclass(frozen=True)
class CaptureComparison:
    """What a capture's figures are next to the known ones, figure by figure.

    outcome: "new" where none are known; "same": they agree; "refines": they agree, and say more; "confirms": they agree
    and are of a live check, which those in use are not; "differs"; where none are known, "odd": no sheet that is sold
    explains the gain, or "vague": too many copies would agree with them.
    """

    outcome: Literal["new", "same", "refines", "confirms", "differs", "odd", "vague"]
    pairs: tuple[FigurePair, ...]

    @property
    def refused(self) -> bool:
        """Whether the figures need a reason and a signature."""
        return self.outcome in ("differs", "odd", "vague")

    @property
    def text(self) -> str:
        """Why they are refused; a sentence's end."""
        if self.outcome == "odd":
            return "no lens sheet as sold, with air under it or without, moves fringes so far under this design"
        if self.outcome == "vague":
            return (
                f"its place of the lens sheet has an error bar of {self.pairs[1].new_sd:.2f} rad, and "
                f"with more than {MOST_OFFSET_SD_RAD:.2f} over a quarter of all copies would agree with it"
            )
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
    Source: module docstring; limits of `compare_built.agree`.
    """
    vague = new.offset_sd > MOST_OFFSET_SD_RAD
    if known is None:
        (low, high), beyond = designed(badge).reach, GAIN_REJECTED_SDS * new.gain_sd
        explained = low - beyond <= new.gain_ratio <= high + beyond
        alone = tuple(
            FigurePair(name, unit, None, None, *(getattr(new, of) for of in names)) for name, unit, *names in FIGURES
        )
        return CaptureComparison("odd" if not explained else "vague" if vague else "new", alone)
    pairs = tuple(agree(new, known, badge).values())
    if any(pair.differs for pair in pairs):
        return CaptureComparison("differs", pairs)
    if _says_more(new, known):
        return CaptureComparison("refines", pairs)
    # Vague figures agree with any copy, so they confirm nothing.
    return CaptureComparison("confirms" if new.witnessed > known.witnessed and not vague else "same", pairs)


def checked_figures(document: object, badge: Badge) -> AsBuilt:
    """Figures that another process measured, which may be in a stranger's hands.

    Raises: SpecError unless they are of this badge, and such as this version can measure.
    """
    found = as_built_from_json(json.dumps(document))
    if found.badge_id != badge.id:
        raise SpecError(f"figures of badge {found.badge_id} came, and those of {badge.id} were to be measured")
    if not ENROLLED_GAINS[0] <= found.gain_ratio <= ENROLLED_GAINS[1]:
        raise SpecError(f"figures of gain {found.gain_ratio:.3g} came, which no capture shows")
    if found.place_maps and [len(row) for row in found.place_maps] != [len(knots_mm(one)) for one in badge.gratings]:
        raise SpecError("a map of places came that is not of this badge's gratings")
    return found


def _says_more(new: AsBuilt, known: AsBuilt) -> bool:
    """Whether figures say what the known ones do not, and are as certain in all else."""
    more = bool(new.place_maps and not known.place_maps) or (new.witnessed and not known.witnessed)
    sure = all(getattr(new, sd) <= LESS_SURE_RATIO * getattr(known, sd) for *_, sd in FIGURES)
    keeps = (bool(new.place_maps) or not known.place_maps) and new.witnessed >= known.witnessed
    return more and keeps and sure


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
