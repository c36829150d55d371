"""Transfer curves of high dynamic range, in 10 bits, for pictures that are coded by a square root.

Convention: a white page under an even sky has radiance 1 and is shown as reference white, 203 cd/m2.
Source: ITU-R BT.2100 (curves), BT.2408 (reference white: 75 % of the signal in hybrid log-gamma).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Scene light of reference white in hybrid log-gamma, and its luminance, cd/m2.
WHITE_SCENE, WHITE_CD = 0.265, 203.0
#: Codes of ITU-T H.273: primaries BT.2020, matrix BT.2020 of non-constant luminance, and the two curves.
BT2020_PRIMARIES, BT2020_MATRIX, PQ_CODE, HLG_CODE = 9, 9, 16, 18


@dataclass(frozen=True)
class Curve:
    """counts (256,): 10-bit luma in the file for 8-bit luma from 16 to 235; tags: primaries, transfer and matrix."""

    counts: NDArray[np.uint16]
    tags: tuple[int, int, int]


def hybrid_log_gamma(light: Array) -> Array:
    """The signal, 0 to 1, of scene light, 0 to 1."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    return np.where(light <= 1 / 12, np.sqrt(3 * light), a * np.log(np.maximum(12 * light - b, 1e-9)) + c)


def perceptual_quantiser(luminance: Array) -> Array:
    """The signal, 0 to 1, of luminance, cd/m2."""
    m1, m2, c1, c2, c3 = 2610 / 16384, 2523 / 32, 3424 / 4096, 2413 / 128, 2392 / 128
    power = (luminance / 10000) ** m1
    return np.asarray(((c1 + c2 * power) / (1 + c3 * power)) ** m2)


def _curve(signal: Array, code: int) -> Curve:
    return Curve(np.rint(64 + 876 * signal).astype(np.uint16), (BT2020_PRIMARIES, code, BT2020_MATRIX))


#: Light of each 8-bit count in a file, by the square root of `recording.sensor`.
LIGHT = (np.clip(np.arange(256) - 16.0, 0, 219) / 219) ** 2
CURVES = {
    "hlg": _curve(hybrid_log_gamma(WHITE_SCENE * LIGHT), HLG_CODE),
    "pq": _curve(perceptual_quantiser(WHITE_CD * LIGHT), PQ_CODE),
}
