"""The snap-in holder as a thing: a badge goes in, is held, is seen, and comes out.  Each test says what it catches.

Stack and sight lines are computed here from the badge's page coordinates, and held against the STL with manifold3d.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import manifold3d
import numpy as np
import pytest
import trimesh

from kit.mounting import box, framed, sight_volume
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.printed.mount import MountProcess, MountReport, plan_mount, write_mount
from moireid.fabrication.printed.snap import check_snap, plan_snap

CARD_MM, LENS_MM, AIR_MM, BITE_MM = 0.3, 0.4572, 0.2, 0.55


@pytest.fixture(scope="module")
def badge() -> Badge:
    return design_badge(Order("Ada Lovelace", format="cr80", orientation="landscape"), bytes(8))


@pytest.fixture(scope="module")
def report(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> MountReport:
    return write_mount(badge, tmp_path_factory.mktemp("holder"), kind="holder")


@pytest.fixture(scope="module")
def printed(report: MountReport) -> Any:
    mesh = trimesh.load_mesh(report.stls[0])
    assert mesh.is_watertight
    return manifold3d.Manifold(manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)))


def stack(badge: Badge, *, grown: float = 0.0, high: float = 0.0) -> Any:
    """Card and sheet, larger on each side, swept forward by `high`."""
    x0, y0, x1, y1 = framed(badge.outline_mm, badge)
    rows = framed(badge.gratings[0].rect_mm, badge)
    card = box((x0 - grown, y0 - grown, x1 + grown, y1 + grown), 0.0, CARD_MM + high)
    return card + box((x0 - grown, rows[1], x1 + grown, rows[3]), 0.0, CARD_MM + LENS_MM + high)


def shared(one: Any, other: Any) -> float:
    return float((one ^ other).volume())


def test_a_badge_lies_in_the_pocket_with_air_on_each_side(badge: Badge, printed: Any) -> None:
    """Catches: a pocket of the board's own size, one that rattles, a sheet thicker than the noses leave room for."""
    assert shared(stack(badge, grown=0.19), printed) < 0.01
    for shift in ((0.25, 0, 0), (-0.25, 0, 0), (0, 0.25, 0), (0, -0.25, 0)):
        assert shared(stack(badge).translate(shift), printed) > 0.01
    assert shared(stack(badge).translate((0, 0, 0.09)), printed) < 0.01


def test_catches_hold_a_badge_that_lies_to_one_side(badge: Badge, printed: Any) -> None:
    """Catches: a bite that the clearance takes away, catches at one edge alone, noses next to the sheet's rows."""
    for shift in (-0.19, 0.0, 0.19):
        lifted = stack(badge).translate((shift, 0, 0.1 + 0.4))
        assert shared(lifted, printed) > 0.01
    # From the board's edge a nose rises by 45 degrees: lifted by 0.3 mm a badge meets 0.3 x 0.3 / 2 of each, 4 mm long.
    assert shared(stack(badge).translate((0, 0, 0.1 + 0.3)), printed) == pytest.approx(2 * 4.0 * 0.3**2 / 2, rel=0.05)


def test_the_strain_is_that_of_a_cantilever(badge: Badge, report: MountReport) -> None:
    """Catches: a strain in per cent, one of the bite alone, one that a larger bite does not raise."""
    # 1.5 t y / L^2 with t = 1.6, y = 0.55 + 0.2, L = 18 mm.
    assert report.figures["strain"] == pytest.approx(1.5 * 1.6 * 0.75 / 18.0**2)
    assert report.figures["bite_mm"] == pytest.approx(0.35)
    # Two catches, 4.0572 mm deep, of 1500 N/mm2: 0.587 N each, and 1.2 / 0.8 of that along the badge's way.
    force_n = 1500 * 4.0572 * 1.6**3 * 0.55 / (4 * 18.0**3)
    assert report.figures["hold_n"] == pytest.approx(2 * 1.5 * force_n)
    with pytest.raises(FabricationError, match=r"catches would be strained by 1\.26 %, allowed are 0\.63 %"):
        plan_snap(badge, MountProcess(bite_mm=1.5))
    with pytest.raises(FabricationError, match=r"bite_mm=0\.45 holds .* by 0\.25 mm, 0\.3 mm are needed; give 0\.5 mm"):
        plan_snap(badge, MountProcess(bite_mm=0.45))


def test_fringes_and_markers_stay_in_sight(badge: Badge, printed: Any) -> None:
    """Catches: noses or a rim in a camera's view."""
    fringes = sight_volume(framed(badge.gratings[0].rect_mm, badge), CARD_MM + LENS_MM, 60, up_and_down=False)
    views = [fringes]
    views += [sight_volume(framed(rect, badge), CARD_MM, 45, up_and_down=True) for rect in badge.markers.dark_mm]
    for view in views:
        for shift in ((AIR_MM, 0, 0), (-AIR_MM, 0, 0), (0, AIR_MM, 0), (0, -AIR_MM, 0)):
            assert shared(view.translate(shift), printed) == 0.0
    x0, y0, x1, y1 = badge.gratings[0].rect_mm
    wide = replace(badge, gratings=(replace(badge.gratings[0], rect_mm=(x0, y0, x1 + 1.5, y1)),))
    with pytest.raises(FabricationError, match=r"catch leaves .* next to grating 0"):
        plan_snap(wide, MountProcess())


@pytest.mark.parametrize("form", ["cr80", "a7", "4x3in", "a6", "a5", "webcam", "board"])
@pytest.mark.parametrize("orientation", ["landscape", "portrait"])
@pytest.mark.parametrize("markers", ["squares", "frame"])
def test_every_format_has_a_holder(form: str, orientation: str, markers: str) -> None:
    """Catches: noses that hide the markers or the coded frame of a format, catches that have no room."""
    wish = Order("Ada Lovelace", markers=markers, format=form, orientation=orientation)
    plan, second = plan_mount(design_badge(wish, bytes(8)), "holder", MountProcess())
    assert second is None and len(plan.slots) == 2


def test_a_holder_that_lets_a_badge_fall_out_is_refused(badge: Badge, printed: Any) -> None:
    """Catches: a check that looks at the figures alone."""
    plan = plan_snap(badge, MountProcess())
    check_snap(printed, plan, MountProcess())
    worn = printed - box((-60, -30, 60, 30), plan.level + 0.05, 20.0)
    with pytest.raises(FabricationError, match="lets a badge fall out"):
        check_snap(worn, plan, MountProcess())
    # One catch of two, as a badge that is held on one side tips out.
    with pytest.raises(FabricationError, match="lets a badge fall out"):
        check_snap(printed - box((40, -30, 60, 30), plan.level + 0.05, 20.0), plan, MountProcess())
    with pytest.raises(FabricationError, match="has no room for a badge"):
        check_snap(printed + box((-5, -5, 5, 5), -0.1, 0.2), plan, MountProcess())
    with pytest.raises(FabricationError, match="does not let a badge out"):
        check_snap(printed + box((-45, 26.5, 45, 28.5), 1.5, 3.0), plan, MountProcess())
