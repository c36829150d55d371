"""Identities as line spacing: payload <-> symbols <-> cells of a grating.

family.py   what every code family offers, and what a reader measures of a cell
words.py    payload <-> code word: check and Reed-Solomon
pitch.py    the beat-frequency identity: bands, each with its own pitch
"""

from moireid.idcodes.family import CellReading, CodeFamily, Decoded, family_named
from moireid.idcodes.pitch import PitchFamily

__all__ = ["CellReading", "CodeFamily", "Decoded", "PitchFamily", "family_named"]
