"""All effects by name and strength."""

from __future__ import annotations

from moireid.errors import SpecError
from moireid.simulate.effects import framing, retiming, stabilising, toning
from moireid.simulate.effects.effect import Effect, Kind

STRENGTHS = ("light", "ordinary", "strong")
KINDS: dict[str, Kind] = {
    kind.name: kind
    for room in (framing, stabilising, retiming, retiming, toning, framing, retiming)
    for kind in room.KINDS
}
#: Names of cameras that are a phone with one effect at ordinary strength.
CAMERAS = {
    "eis": "eis",
    "tnr": "tnr",
    "zoom": "zoom",
    "autoframe": "autoframe",
    "breathing": "breathing",
    "hlg": "hlg",
    "call-tile": "tile",
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
