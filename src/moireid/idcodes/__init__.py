"""Identities as line spacing: payload <-> symbols <-> cells of a grating.

family.py        the interface of a code family, and the measured figures of a cell
words.py         payload <-> code word of both families: check and Reed-Solomon
pitch.py         the beat-frequency identity: bands, each with its own pitch; 24 bits; arithmetic of beat levels
spacing.py       non-uniform line spacing: cells of shifted lines, and a personal beat; 64 or 128 bits
families.py      both families by name
specimen.py      a badge without a holder, with the layout of another
"""

from moireid.idcodes.families import family_named, spells_its_id
from moireid.idcodes.family import CellReading, CodeFamily, DecodeResult
from moireid.idcodes.pitch import PitchFamily
from moireid.idcodes.spacing import SpacingFamily
from moireid.idcodes.specimen import specimen_of

__all__ = [
    "CellReading",
    "CodeFamily",
    "DecodeResult",
    "PitchFamily",
    "SpacingFamily",
    "family_named",
    "specimen_of",
    "spells_its_id",
]
