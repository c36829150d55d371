"""How sharp is a film, by its page's printed edges?  At each test: the wrong implementation it catches."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from moireid.designer import Order, design_badge
from moireid.verifier.picture import as_picture, counts_of
from moireid.verifier.tracking.edge_spread import EdgeReader
from moireid.verifier.tracking.patches import patches_of

PX_PER_MM = 2.0
#: Interpolation between pixels, and their own square, add to a blur, px^2.
OWN_PX2 = 1 / 6 + 1 / 12


@pytest.mark.claim("The spread of a page's edges is measured within 8 %")
@pytest.mark.parametrize("markers", ["squares", "frame"])
@pytest.mark.parametrize("blur_px", [(0.8, 0.8), (1.6, 0.8), (0.8, 2.0)])
def test_the_blur_of_a_picture_is_measured_along_each_axis(markers, blur_px, rng):
    """Catches: axes that are exchanged; counts in place of light; print next to an edge, or a notch, taken for blur."""
    badge = design_badge(Order("Guest", markers=markers), bytes(8))
    width, height = (np.array(badge.page_mm) * PX_PER_MM).astype(int)
    fine = 4
    page = np.full((height * fine, width * fine), 200.0, np.float32)
    for patch in patches_of(badge.markers):
        low, high = (
            np.rint((np.array(patch.center_mm) + sign * np.array(patch.half_mm)) * PX_PER_MM * fine).astype(int)
            for sign in (-1, 1)
        )
        x, y = ((np.arange(*ends) + 0.5) / (PX_PER_MM * fine) for ends in zip(low, high, strict=True))
        page[low[1] : high[1], low[0] : high[0]] = 10 + 190 * patch.print(
            x - patch.center_mm[0], y - patch.center_mm[1]
        )
    soft = cv2.GaussianBlur(page, (0, 0), blur_px[0] * fine, sigmaY=blur_px[1] * fine)
    light = cv2.resize(soft, (width, height), interpolation=cv2.INTER_AREA)
    light += rng.normal(0.0, 2.0, light.shape).astype(np.float32)
    reader = EdgeReader(badge.markers)
    seen = reader.read(as_picture(counts_of(light)), np.array([[PX_PER_MM, 0, -0.5], [0, PX_PER_MM, -0.5], [0, 0, 1]]))
    true = np.sqrt(np.square(blur_px) + OWN_PX2) / PX_PER_MM
    assert reader.spread_mm(seen) == pytest.approx(true, rel=0.08)
