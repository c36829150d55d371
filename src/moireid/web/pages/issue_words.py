"""The link budget in words."""

from __future__ import annotations

import math

from moireid.idcodes.spacing import PHASE_LEVELS
from moireid.web.jobs.orders import Checked


def sentences(checked: Checked) -> list[str]:
    """What a person should know before a badge is made: from where it can be read, and how surely."""
    badge = checked.badge
    assert badge.range_m is not None
    told = [
        f"Badge {badge.id} carries {badge.payload_bits} bits, and is made to be filmed from {badge.range_m[0]:g} to "
        f"{badge.range_m[1]:g} m with a phone at 1080p."
    ]
    for metres, link in checked.links:
        told.append(
            f"At {metres:g} m a cell is {link.cell_px:.1f} pixels wide, and the whole identity is read "
            f"{_chance(link.decode_probability)}: a cell's phase is off by {link.phase_error_rad:.2f} rad, and "
            f"an error of {math.pi / PHASE_LEVELS:.2f} rad would turn one symbol into the next."
        )
    return told


def _chance(probability: float) -> str:
    """A probability as a share of films."""
    if probability >= 0.9999:
        return "from more than 9,999 of 10,000 films of eight seconds"
    if probability >= 0.01:
        return f"from about {100 * probability:.{0 if probability < 0.99 else 1}f} of 100 films of eight seconds"
    return "from hardly any film"
