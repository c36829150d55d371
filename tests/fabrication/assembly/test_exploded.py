"""The exploded views of assembly.pdf, read off the page.  Each test names the wrong drawing it catches."""

from __future__ import annotations

import math

import manifold3d
import numpy as np
import pytest

from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.assembly.assembly_words import BuildPlan
from moireid.fabrication.assembly.exploded import Part, plain_parts, prism
from moireid.fabrication.assembly.guide import _views
from moireid.fabrication.mount_parts import plan_parts, shape_parts
from moireid.fabrication.printed.mount import plan_mount
from moireid.fabrication.process_figures import MountFigures, MountProcess

PAYLOAD = bytes.fromhex("0f38c1a2b3d4e5f6")


@pytest.fixture(scope="module")
def lens() -> Badge:
    return design_badge(Order("Ada", lens="50lpi"), PAYLOAD)


@pytest.fixture(scope="module")
def mask() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", front="mask", lens_thickness_mm=2.0), PAYLOAD)


def seen(x: float, y: float, z: float = 0.0) -> np.ndarray:
    """Where the stated view puts a place: turned by 30 degrees, seen from 32 above, at life size."""
    turn, rise = math.radians(30), math.radians(32)
    away = x * math.sin(turn) + y * math.cos(turn)
    return np.array([x * math.cos(turn) - y * math.sin(turn), away * math.sin(rise) + z * math.cos(rise)])


def views(badge: Badge, mount: str, figures: MountFigures | None = None) -> list[list[Part]]:
    """The parts of each exploded view."""
    parts = plan_parts(badge, mount, figures)
    build = BuildPlan(badge, parts, "command")
    return [found for _, found in _views(build, shape_parts(badge, parts).drawn)]


@pytest.mark.slow
def test_parts_are_those_of_the_plans(lens: Badge, mask: Badge) -> None:
    """Catches: a forgotten part, an order that cannot be put together, figures of the defaults for somebody's own."""
    process = MountProcess(card_mm=0.5, back_mm=2.0)
    assert [part.name for part in plain_parts(mask, process)] == ["printed card", "clear spacer", "mask film"]
    names = [part.name.split(",")[0] for part in views(mask, "clip", MountFigures(process))[0]]
    assert names == ["clip", "tray", "printed card", "clear spacer", "mask film"]
    tray, card, sheet = views(lens, "lanyard", MountFigures(process))[0]
    assert tray.low == pytest.approx(-2.0) and (card.low, card.high) == (0.0, 0.5)
    assert (sheet.low, sheet.high) == (0.5, 0.5 + lens.lens.thickness_mm)
    stack = views(lens, "lanyard")[1]
    assert [part.name for part in stack] == [
        "6 nuts",
        "acrylic base",
        "acrylic frame",
        "3 layers of card",
        "printed card",
        "lens sheet",
        "lips of film",
        "acrylic cover",
        "6 screws",
    ]
    # Each screw, and the window and the holes through which the part behind is seen.
    assert len(stack[0].pieces) == len(stack[-1].pieces) == 6
    assert len(stack[2].pieces[0].outlines) == 1 + 1 + 6 + 2
    with pytest.raises(FabricationError, match="slot"):
        plan_mount(lens, "clip", MountProcess(slot_mm=(16.0, 2.0)))


def test_solids_are_drawn_from_where_the_view_says(lens: Badge) -> None:
    """Catches: a view that is mirrored, turned, or in perspective: the kernel draws a box as `prism` does."""
    from moireid.fabrication.assembly.solid_views import drawn_solids
    from moireid.fabrication.solid_parts import SolidPart, box

    rect = (-10.0, -20.0, 30.0, 5.0)
    drawn = drawn_solids([SolidPart("box", box(rect, 1.0, 4.0))])["box"]
    plain = prism(((-10.0, -20.0), (30.0, -20.0), (30.0, 5.0), (-10.0, 5.0)), 1.0, 4.0)
    for one, other in ((drawn, plain), (plain, drawn)):
        for corner in {corner for line in one.lines for corner in line}:
            assert min(math.dist(corner, place) for line in other.lines for place in line) < 1e-4
    silhouettes = [manifold3d.CrossSection([list(piece.outlines[0])]) for piece in (drawn, plain)]
    assert (silhouettes[0] ^ silhouettes[1]).area() == pytest.approx(silhouettes[0].area(), rel=1e-4)
    assert silhouettes[1].area() == pytest.approx(silhouettes[0].area(), rel=1e-4)
    # The highest corner of the picture is the far one, and the lowest is near, below.
    assert max((v for line in drawn.lines for _, v in line)) == pytest.approx(seen(30, 5, 4)[1], abs=1e-4)
    assert min((v for line in drawn.lines for _, v in line)) == pytest.approx(seen(-10, -20, 1)[1], abs=1e-4)
