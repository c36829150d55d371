"""The parts of a mount as build123d solids."""

from __future__ import annotations

import math
from dataclasses import replace

import manifold3d
import pytest

from moireid.designer import Order, design_badge
from moireid.fabrication import mount_solids
from moireid.fabrication.acrylic.plates import plan_acrylic
from moireid.fabrication.printed.mount import mount_bodies
from moireid.fabrication.process_figures import AcrylicProcess, MountFigures

BADGE = design_badge(Order("Ada", lens="50lpi"), bytes(8))


def test_acrylic_solids_are_the_stack_s() -> None:
    """Catches: parts without name or colour, in another place or of another size than those that are cut."""
    from build123d import Solid

    thick = MountFigures(acrylic=replace(AcrylicProcess(), base_mm=4.0))
    solids, plan = mount_solids(BADGE, "acrylic", thick), plan_acrylic(BADGE, thick.acrylic)
    assert {"page", "sheet-0", "screw-0", *(plate.name for plate in plan.plates)} <= solids.keys()
    for name, solid in solids.items():
        assert isinstance(solid, Solid) and solid.is_valid and solid.label == name
    for plate in plan.plates:
        solid, box = solids[plate.name], solids[plate.name].bounding_box()
        area = manifold3d.CrossSection([plate.outline.flat(64)]).area()
        area -= sum(manifold3d.CrossSection([hole.flat(64)]).area() for hole in plate.openings)
        assert math.isclose(solid.volume, area * plate.thickness_mm, rel_tol=1e-4), plate.name
        x0, y0, x1, y1 = plate.outline.bounds
        wanted = [x0, y0, plate.low_mm, x1, y1, plate.low_mm + plate.thickness_mm]
        assert [*box.min, *box.max] == pytest.approx(wanted, abs=1e-4), plate.name
    assert solids["base"].color is not None
    assert tuple(solids["base"].color) != tuple(solids["cover"].color)


def test_printed_solids_are_in_their_place_in_use() -> None:
    """Catches: parts as they lie on the printer's bed, next to each other; springs that reach into the page."""
    solids = mount_solids(BADGE, "clip")
    used = {body.name: body.used for body in mount_bodies(BADGE, "clip")}
    assert solids.keys() == {*used, "page", "sheet-0"}
    for name, solid in used.items():
        assert solids[name].label == name
        # Four pads of 1.2 x 3 mm with ramps, 0.25 mm of each.
        less = 4 * 1.2 * 3 * 0.25 if name == "tray" else 0.0
        assert solids[name].volume == pytest.approx(solid.volume - less, abs=0.2 * less + 1e-6)
        assert tuple(solids[name].center()) == pytest.approx(tuple(solid.center()), abs=0.01)
