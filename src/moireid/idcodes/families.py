"""The code families by name: a badge's grating names its family, and a reader finds the decoder by that name."""

from __future__ import annotations

from moireid.badge import Badge
from moireid.errors import CodeError, MoireIdError
from moireid.idcodes.family import CodeFamily
from moireid.idcodes.pitch import PitchFamily
from moireid.idcodes.spacing import SpacingFamily

_FAMILIES: dict[str, CodeFamily] = {family.name: family for family in (PitchFamily(), SpacingFamily())}


def spells_its_id(badge: Badge) -> bool:
    """Whether the cells of a badge are those that its id asks for; true for a board that carries no code.

    Source: the family's own writing, compared within a nanometre of pitch and ten of place.
    """
    coded = tuple(grating for grating in badge.gratings if grating.code)
    if not coded or badge.id is None:
        return True
    try:
        written = family_named(coded[0].family).write(bytes.fromhex(badge.id), coded, badge.lens.pitch_mm)
    except MoireIdError:
        return False
    return all(
        abs(cell.pitch_mm - wanted.pitch_mm) < 1e-6 and abs(cell.edge_mm - wanted.edge_mm) < 1e-5
        for grating, cells in zip(coded, written, strict=True)
        for cell, wanted in zip(grating.cells, cells, strict=True)
    )


def family_named(name: str) -> CodeFamily:
    """The family of that name.  Raises: CodeError where this version has none."""
    if name not in _FAMILIES:
        raise CodeError(f"code family {name!r} is not known to this version; it reads {', '.join(_FAMILIES)}")
    return _FAMILIES[name]
