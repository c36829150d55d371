"""The parts of a mount as build123d solids."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from moireid.designer import Request, design_badge
from moireid.errors import FabricationError
from moireid.fabrication import mount_solids
from moireid.fabrication.acrylic.plates import plan_acrylic
from moireid.fabrication.acrylic.stack import assemble
from moireid.fabrication.printed.mount import mount_bodies
from moireid.fabrication.process_figures import AcrylicProcess, MountFigures

BADGE = design_badge(Request("Ada"), bytes(8))


def test_acrylic_solids_are_the_stack_s() -> None:
    """Catches: parts without name or colour, in another place or of another size than those that are cut."""
    from build123d import Solid

    thick = MountFigures(acrylic=replace(AcrylicProcess(), base_mm=4.0))
    solids, bodies = mount_solids(BADGE, "acrylic", thick), assemble(plan_acrylic(BADGE, thick.acrylic))
    assert len(solids) == len(bodies)
    for (name, solid), body in zip(solids.items(), bodies, strict=True):
        assert isinstance(solid, Solid) and solid.is_valid
        assert (solid.label, name.split("-")[0]) == (name, body.name.split("-")[0])
        assert math.isclose(solid.volume, body.body.volume(), rel_tol=0.01), name
        box, bounds = solid.bounding_box(), body.body.bounding_box()
        assert [*box.min, *box.max] == pytest.approx(list(bounds), abs=0.02), name
    assert solids["base"].color is not None
    assert tuple(solids["base"].color) != tuple(solids["cover"].color)


def test_printed_solids_are_in_their_place_in_use() -> None:
    """Catches: parts as they lie on the printer's bed, next to each other."""
    solids = mount_solids(BADGE, "clip")
    used = {body.name: body.used for body in mount_bodies(BADGE, "clip")}
    assert solids.keys() == used.keys() == {"tray", "clip"}
    for name, solid in solids.items():
        assert solid.label == name
        assert math.isclose(solid.volume, used[name].volume, rel_tol=1e-9)
        assert tuple(solid.center()) == pytest.approx(tuple(used[name].center()))


@pytest.mark.parametrize("name", ["none", "magnet"])
def test_a_mount_that_is_none_is_refused(name: str) -> None:
    """Catches: no parts for a word that is no mount."""
    with pytest.raises(FabricationError, match="choose one of lanyard, clip, stand, holder, acrylic"):
        mount_solids(BADGE, name)
