"""Do the parts of the badge move as one?

A badge is rigid, so all of its parts follow one motion, within their noise.  A picture that is put together, generated,
or warped does not.  Each part's deviation from the rest is compared with what honest films show, where its logarithm
over its own error is normally distributed (`limits.PARTS`).

| part | deviation of |
|---|---|
| `rows` | the worst plain row from the others |
| `places` | the places within a row from the row |
| `code` | the code's worst row from the plain rows, over the film |
| `code_second` | the same in its worst second |

Convention: deviations are root mean squares, rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from moireid.verifier.decision.figures import Figures
from moireid.verifier.explanations.residuals import credible_error_rad
from moireid.verifier.identity.cell_slip import RowsApart
from moireid.verifier.limits import PARTS, PROOF_SDS, USUAL_SDS
from moireid.verifier.reasons import Reason

#: What the fringes of a part that moves apart do.
WORDS = {
    "rows": "The fringes of different rows of the badge move apart",
    "places": "The fringes move apart from place to place within a row of the badge",
    "code": "The fringes of the code's rows do not move as those of the plain rows do",
    "code_second": "For a second, the fringes of the code's rows do not move as those of the plain rows do",
}


@dataclass(frozen=True)
class Part:
    """A part's deviation; the most that honest films show but for few; what noise does not explain of the deviation, as
    in `Figures`; and what no honest film shows of that; rad.
    """

    name: str
    deviation_rad: float
    limit_rad: float
    beyond_rad: float
    proof_rad: float

    @classmethod
    def of(cls, name: str, deviation_rad: float, beyond_rad: float, figures: Figures) -> Part:
        """A part of a grating with these figures."""
        one, moved = PARTS[name], figures.excitation_rad
        noise = figures.strip_sd_rad, figures.rounding_rad
        # A film that is made noisy is not rejected, but must not buy room for a lie.
        excused = (credible_error_rad(moved, error_rad) for error_rad in noise)
        limit = one.quantile(USUAL_SDS, one.unit_rad(moved, 0.0, *excused))
        # From aside, one part of a sheet may lie on the page while another is glued to it.
        proof = math.hypot(one.quantile(PROOF_SDS, one.unit_rad(moved, 0.0, *noise)), figures.air_rad)
        return cls(name, deviation_rad, limit, beyond_rad, proof)


def parts_of(figures: Sequence[Figures], code: RowsApart, *, covered: bool = False) -> list[Part]:
    """All parts; figures: of each grating; code: deviations of the code's rows; covered: as `Doubts.covered`.

    Convention: noise is no motion, and neither is a hand.  So the code's rows prove a forgery only if two halves of a
        row share their motion, and nothing covers the badge.
    """
    plain = [Part.of("rows", one.strip_wander_rad, one.strip_beyond_rad, one) for one in figures]
    plain += [Part.of("places", one.place_wander_rad, one.place_beyond_rad, one) for one in figures]
    most = max(figures, key=lambda one: one.excitation_rad)
    coded = [Part.of(name, apart, apart, most) for name, apart in (("code", code.film), ("code_second", code.second))]
    if covered or code.coherent <= coded[0].limit_rad:
        coded = [replace(one, proof_rad=math.inf) for one in coded]
    return plain + coded


def parts(several: Sequence[Part], *, prove: bool = True) -> Reason:
    """The finding; prove: whether a forgery may be proven (`Doubts`)."""
    worst = max(several, key=lambda one: one.deviation_rad / one.limit_rad)
    broken = [one for one in several if one.beyond_rad > one.proof_rad]
    if prove and broken:
        worst = max(broken, key=lambda one: one.beyond_rad / one.proof_rad)
        text = f"{WORDS[worst.name]}, as on a badge that is put together from pictures."
        return Reason("parts", "fail", worst.beyond_rad, worst.proof_rad, "rad", text)
    if worst.deviation_rad <= worst.limit_rad:
        text = "The fringes of all parts of the badge move together."
        return Reason("parts", "pass", worst.deviation_rad, worst.limit_rad, "rad", text)
    text = f"{WORDS[worst.name]}, by more than usual errors. Film from nearer, in even light, without effects that mix "
    text += "frames."
    return Reason("parts", "undecided", worst.deviation_rad, worst.limit_rad, "rad", text)
