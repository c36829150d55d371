"""What goes wrong when a badge is printed and put together, drawn once for each build."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from outside.page import Page

#: Largest errors: of a hand that places the sheet, of the printer's feed, and of the sheet's pitch as sold.
OFFSET_MM, TWIST_DEG, SCALE, ASPECT, PITCH = 0.3, 0.15, 3e-3, 5e-4, 2e-3


@dataclass(frozen=True)
class Build:
    """One built badge.  scale: true over nominal mm of the print, along x and y; sheets: rows as `trace.trace` reads.

    A row: centre x and y, cosine and sine of the axis, half size across and along, place of a lens's edge, pitch.
    """

    scale: tuple[float, float]
    sheets: NDArray[np.float64]
    twist_deg: float
    pitch_share: float


def built(page: Page, rng: np.random.Generator | None = None) -> Build:
    """A badge as built; without chance, as it ought to be."""
    draw = (lambda most: float(rng.uniform(-most, most))) if rng is not None else (lambda most: 0.0)
    common, aspect, pitch = draw(SCALE), draw(ASPECT), draw(PITCH)
    scale = (1 + common + aspect / 2, 1 + common - aspect / 2)
    rows, twists = [], []
    for sheet in page.sheets:
        twist = draw(TWIST_DEG)
        angle = sheet.angle_rad + math.radians(twist)
        center = sheet.center_mm[0] * scale[0] + draw(OFFSET_MM), sheet.center_mm[1] * scale[1] + draw(OFFSET_MM)
        # Where the sheet was cut through a lens.
        edge = draw(page.lens.pitch_mm / 2)
        rows.append([*center, math.cos(angle), math.sin(angle), *sheet.half_mm, edge, page.lens.pitch_mm * (1 + pitch)])
        twists.append(twist)
    return Build(scale, np.array(rows).reshape(-1, 8), max(twists, key=abs, default=0.0), pitch)
