"""The code families by name: a badge's grating names its family, and a reader finds the decoder by that name."""

from __future__ import annotations

from moireid.badge import Badge
from moireid.errors import CodeError, MoireIdError
from moireid.idcodes.family import CodeFamily
from moireid.idcodes.pitch import PitchFamily
from moireid.idcodes.spacing import SpacingFamily

_FAMILIES: dict[str, CodeFamily] = {family.name: family for family in (PitchFamily(), SpacingFamily())}


def spells_its_id(badge: Badge) -> bool:
    """Check whether the cells of a badge are those of its id.

    Parameters
    ----------
    badge : Badge
        Any badge.

    Returns
    -------
    bool
        True also for a badge that carries no code or has no id.

    Notes
    -----
    Convention: pitches are compared within a nanometre, and the places of edges within ten.
    Source: the family's own `write`.
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
    """Give the code family of a name.

    Parameters
    ----------
    name : str
        "pitch" or "spacing", as a grating's `family` names it.

    Returns
    -------
    CodeFamily
        The family, which writes and reads.

    Raises
    ------
    CodeError
        Where this version knows no such family.
    """
    if name not in _FAMILIES:
        raise CodeError(f"code family {name!r} is not known to this version; it reads {', '.join(_FAMILIES)}")
    return _FAMILIES[name]
