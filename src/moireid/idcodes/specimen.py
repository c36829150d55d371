"""A badge without a holder, with the layout of another: all that a reader needs to read any badge of that layout."""

from __future__ import annotations

from dataclasses import replace

from moireid.badge import Badge
from moireid.idcodes.families import family_named
from moireid.idcodes.pitch import code_of


def specimen_of(badge: Badge, badge_id: str | None = None) -> Badge:
    """Rewrite a badge's lines, so that they reveal nothing about its holder.

    Parameters
    ----------
    badge : Badge
        Of the wanted layout.
    badge_id : str, optional
        The identity to write, hex digits; None for one of zeros alone, which is then left out of the specimen.

    Returns
    -------
    Badge
        Without a name and without print data.

    Raises
    ------
    CodeError
        Where the badge's code family is not known.

    Notes
    -----
    Convention: `Badge.layout_key` is that of the given badge.
    Source: the family's own `write`.
    """
    coded = tuple(grating for grating in badge.gratings if grating.code)
    bare = replace(badge, id=badge_id, name="", print=None)
    if not coded:
        return bare
    payload = bytes.fromhex(badge_id) if badge_id else bytes(code_of(coded[0]).payload_bits // 8)
    written = iter(family_named(coded[0].family).write(payload, coded, badge.lens.pitch_mm))
    gratings = []
    for grating in badge.gratings:
        if grating.code is None:
            gratings.append(grating)
            continue
        cells = next(written)
        gratings.append(replace(grating, cells=cells, pitch_mm=cells[grating.code.reference_cell].pitch_mm))
    return replace(bare, gratings=tuple(gratings))
