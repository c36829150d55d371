"""A refusal's advice is tried: every figure in its details is put into the wish, until a badge is made."""

from __future__ import annotations

from dataclasses import replace

import pytest

from moireid.designer import Order, design_badge
from moireid.errors import MoireIdError

WISH = Order("Al", lens="50lpi")


def followed(request: Order, error: MoireIdError) -> Order:
    """The wish changed as an error advises; the same one where it advises nothing."""
    details = error.details
    request = replace(request, printer_dpi=details.get("least_dpi", request.printer_dpi))
    if "size_mm" in details:
        return replace(request, size_mm=details["size_mm"])
    if "near_m" in details:
        near, far = float(details["near_m"]), float(details["far_m"])
        wanted = max(near, request.range_m[0]), min(far, request.range_m[1])
        return replace(request, range_m=wanted if wanted[0] <= wanted[1] else (near, far))
    return request


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        (replace(WISH, printer_dpi=150), ["print at 300 dpi or more"]),
        (replace(WISH, size_mm=(30.0, 30.0)), ["at least 60x66"]),
        (replace(WISH, size_mm=(30.0, 150.0)), list[str]()),
        (replace(WISH, size_mm=(300.0, 300.0)), [""]),
        (replace(WISH, size_mm=(200.0, 280.0), paper="letter"), [""]),
    ],
)
def test_advice_leads_to_a_badge_that_fits_its_page(wish: Order, words: list[str]) -> None:
    """Catches: advice that is refused in its turn, or advises nothing; a size that does not fit the paper that it was
    advised for."""
    for word in words:
        with pytest.raises(MoireIdError) as refused:
            design_badge(wish, bytes.fromhex("0f38c1a2b3d4e5f6"))
        assert word in str(refused.value)
        wish = followed(wish, refused.value)
    badge = design_badge(wish, bytes.fromhex("0f38c1a2b3d4e5f6"))
    x0, y0, x1, y1 = badge.outline_mm
    assert min(x0, y0) >= 12 - 1e-6 and x1 <= badge.page_mm[0] - 12 + 1e-6 and y1 <= badge.page_mm[1] - 12 + 1e-6
