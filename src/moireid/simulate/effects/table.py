"""All effects by name and strength, collected from the files of this folder.

A new effect is a `Kind` in the file of its theme, and a line of the help of `cli/simulate_cmd.py`.
"""

from __future__ import annotations

from moireid.errors import SpecError
from moireid.simulate.effects.coding import CODINGS
from moireid.simulate.effects.effect import Effect, Kind
from moireid.simulate.effects.framing import BACKDROPS, FRAMINGS
from moireid.simulate.effects.retiming import MIXINGS, RETIMINGS
from moireid.simulate.effects.stabilising import KINDS as STABILISINGS
from moireid.simulate.effects.toning import KINDS as TONINGS

STRENGTHS = ("light", "ordinary", "strong")
KINDS: dict[str, Kind] = {
    kind.name: kind
    for kinds in (FRAMINGS, STABILISINGS, MIXINGS, RETIMINGS, TONINGS, BACKDROPS, CODINGS)
    for kind in kinds
}


def effect_named(name: str) -> Effect:
    """An effect by NAME or NAME:STRENGTH; ordinary without a strength.  Raises: SpecError for others."""
    kind, _, strength = name.partition(":")
    if kind not in KINDS:
        raise SpecError(f"effect {kind!r} is not known; choose one of {', '.join(KINDS)}")
    if (strength or "ordinary") not in STRENGTHS:
        raise SpecError(f"effect {name!r} has no such strength; choose {', '.join(STRENGTHS)}, as in {kind}:light")
    one = KINDS[kind]
    return one.make(one.figures[STRENGTHS.index(strength or "ordinary")])
