"""The lanyard mount as a thing: what fits, what slides, what stays in sight, and which files are refused.

The stack and the sight lines are laid out here from the badge's page coordinates alone, on a badge whose sheet is not
in the middle, and held against the STL with manifold3d.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np
import pytest
import trimesh

from moireid.badge import Badge
from moireid.designer import Request, design_badge, payload_for_name
from moireid.errors import FabricationError, MissingExtraError, SpecError
from moireid.fabrication import mount, solids
from moireid.fabrication.mount import MountProcess, MountReport, lanyard_mount, write_mount

CARD_MM, LENS_MM, PLAY_MM = 0.3, 1.0, 0.3
#: Where the numbers meet exactly, float32 vertices leave overlaps thinner than 1e-5 mm.
TOUCH_MM3 = 0.01


@pytest.fixture(scope="module")
def badge() -> Badge:
    """Ada's badge with its sheet 3 mm above the middle, so that a mount turned upside down does not fit."""
    issued = design_badge(Request("Ada Lovelace"), payload_for_name("Ada Lovelace"))
    x0, y0, x1, y1 = issued.gratings[0].rect_mm
    return replace(issued, gratings=(replace(issued.gratings[0], rect_mm=(x0, y0 - 3, x1, y1 - 3)),))


@pytest.fixture(scope="module")
def report(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> MountReport:
    return write_mount(badge, tmp_path_factory.mktemp("mount"))


@pytest.fixture(scope="module")
def printed(report: MountReport) -> Any:
    """The mount as a slicer sees it."""
    mesh = trimesh.load_mesh(report.stl)
    return manifold3d.Manifold(manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)))


def box(rect: tuple[float, ...], low: float, high: float, *, up: float = 0.0) -> Any:
    """A box over a rectangle of the frame, swept `up` mm towards the open top."""
    x0, y0, x1, y1 = rect
    return manifold3d.Manifold.cube((x1 - x0, y1 + up - y0, high - low)).translate((x0, y0, low))


def framed(rect: tuple[float, ...], badge: Badge) -> tuple[float, ...]:
    """A page rectangle seen from the board's centre, y up."""
    bx0, by0, bx1, by1 = badge.outline_mm
    cx, cy = (bx0 + bx1) / 2, (by0 + by1) / 2
    return rect[0] - cx, cy - rect[3], rect[2] - cx, cy - rect[1]


def card_and_sheet(badge: Badge, *, up: float = 0.0) -> tuple[Any, Any]:
    card = framed(badge.outline_mm, badge)
    rows = framed(badge.gratings[0].rect_mm, badge)
    sheet = (card[0], rows[1], card[2], rows[3])
    return box(card, 0.0, CARD_MM, up=up), box(sheet, CARD_MM, CARD_MM + LENS_MM, up=up)


def overlap_mm3(one: Any, other: Any) -> float:
    return (one ^ other).volume()


def test_card_and_sheet_lie_in_the_tray_and_cannot_leave_but_upwards(badge: Badge, printed: Any) -> None:
    card, sheet = card_and_sheet(badge)
    for piece, sideways in ((card, 0.29), (sheet, 0.29)):
        for dx, dy in ((0, 0), (sideways, 0), (-sideways, 0), (0, -0.29)):
            assert overlap_mm3(piece.translate((dx, dy, 0)), printed) < TOUCH_MM3
        # Clearance is 0.3 mm left, right and below: a wider one is as wrong as a narrower one.
        for dx, dy in ((0.35, 0), (-0.35, 0), (0, -0.35)):
            assert overlap_mm3(piece.translate((dx, dy, 0)), printed) > 0.01
    assert overlap_mm3(card.translate((0, 0, -0.05)), printed) == pytest.approx(146 * 160 * 0.05, rel=1e-3)
    # Two feet, 2 mm of each under the sheet, carry it 0.3 mm lower; they begin 0.1 mm above the card.
    assert overlap_mm3(sheet.translate((0, -0.35, 0)), printed) == pytest.approx(2 * 2 * 0.05 * 0.9, rel=0.01)
    # The lips begin 0.1 mm above the sheet and reach 2 mm over it, left and right, along all its 88.88 mm.
    assert overlap_mm3(sheet.translate((0, 0, 0.09)), printed) < TOUCH_MM3
    assert overlap_mm3(sheet.translate((0, 0, 0.15)), printed) == pytest.approx(2 * 2 * 88.88 * 0.05, rel=0.01)
    assert overlap_mm3(card.translate((0, 0, 0.09)), printed) < TOUCH_MM3


def test_card_and_sheet_slide_in_from_the_top(badge: Badge, printed: Any) -> None:
    card, sheet = card_and_sheet(badge, up=250.0)
    assert overlap_mm3(card, printed) < TOUCH_MM3
    assert overlap_mm3(sheet, printed) < TOUCH_MM3
    # Nothing stands higher than the rim above the sheet's rows, nor below its feet.
    x0, y0, x1, y1 = framed(badge.gratings[0].rect_mm, badge)
    for rect in ((x0 - 20, y1 + 0.01, x1 + 20, y1 + 200), (x0 - 20, y0 - 200, x1 + 20, y0 - 2.31)):
        assert overlap_mm3(box(rect, 1.401, 10), printed) == 0.0
    # The lanyard's slot goes through: a strap of 14 x 3 mm, with the tab all round it.
    top = (badge.outline_mm[3] - badge.outline_mm[1]) / 2
    assert overlap_mm3(box((-7.0, top + 4.5, 7.0, top + 7.5), -5, 5), printed) == 0.0
    for rect in ((-7.5, top + 8.2, 7.5, top + 11), (-7.5, top + 0.5, 7.5, top + 3.5), (8.5, top + 5, 9.5, top + 7)):
        assert overlap_mm3(box(rect, -5, 5), printed) > 1.0


def sight_volume(rect: tuple[float, ...], level: float, angle_deg: float, *, up_and_down: bool) -> Any:
    """All that lies on a sight line to the rectangle from within that angle, up to 3 mm above it."""
    spread = 3.0 * math.tan(math.radians(angle_deg))
    x0, y0, x1, y1 = rect
    dy = spread if up_and_down else 0.0
    lower = [(x, y, level) for x in (x0, x1) for y in (y0, y1)]
    upper = [(x, y, level + 3.0) for x in (x0 - spread, x1 + spread) for y in (y0 - dy, y1 + dy)]
    return manifold3d.Manifold.hull_points(lower + upper)


def test_fringes_and_markers_stay_in_sight(badge: Badge, printed: Any) -> None:
    fringes = sight_volume(framed(badge.gratings[0].rect_mm, badge), CARD_MM + LENS_MM, 60, up_and_down=False)
    half = badge.markers.size_mm / 2
    rects = [framed((x - half, y - half, x + half, y + half), badge) for x, y in badge.markers.centers_mm]
    views = [fringes, *(sight_volume(rect, CARD_MM, 45, up_and_down=True) for rect in rects)]
    for view in views:
        for dx, dy in ((PLAY_MM, 0), (-PLAY_MM, 0), (0, -PLAY_MM)):
            assert overlap_mm3(view.translate((dx, dy, 0)), printed) == 0.0
    flat = sight_volume(framed(badge.gratings[0].rect_mm, badge), CARD_MM + LENS_MM, 80, up_and_down=False)
    assert overlap_mm3(flat, printed) > 0.01


def test_mount_that_hides_something_is_refused(badge: Badge) -> None:
    with pytest.raises(FabricationError, match=r"lip leaves 2\.70 mm beside grating 0, but .* 60 degrees") as caught:
        lanyard_mount(badge, MountProcess(lip_mm=3.2))
    # Lip 3.2 mm, chamfered by half of it: its lower edge stands 1.7 mm above the sheet.
    assert caught.value.details["need_mm"] == pytest.approx(1.7 * math.sqrt(3))
    # Of a thinner lip the chamfer's upper edge decides, which lies half a thickness further out.
    assert lanyard_mount(badge, MountProcess(lip_mm=2.0)).is_valid
    with pytest.raises(FabricationError, match=r"lip leaves 3\.75 mm") as caught:
        lanyard_mount(badge, MountProcess(lip_mm=2.1))
    assert caught.value.details["need_mm"] == pytest.approx(2.2 * math.sqrt(3))
    x0, y0, x1, y1 = badge.gratings[0].rect_mm
    wide_on_the_right = replace(badge, gratings=(replace(badge.gratings[0], rect_mm=(x0, y0, x1 + 2, y1)),))
    with pytest.raises(FabricationError, match="beside grating 0"):
        lanyard_mount(wide_on_the_right)
    centers = badge.markers.centers_mm
    low = replace(badge.markers, centers_mm=(*centers[:3], (centers[3][0], centers[3][1] + 4.5)))
    with pytest.raises(FabricationError, match=r"rim leaves .* beside marker 3"):
        lanyard_mount(replace(badge, markers=low))


def test_report_and_files_agree(report: MountReport) -> None:
    # 146 + 2 (0.3 + 2.0); 160 + 0.3 + 2.0 and a tab of 12; 1.6 + 0.3 + 1.0 + 0.1 + 1.2.
    assert report.size_mm == pytest.approx((150.6, 174.3, 4.2))
    mesh = trimesh.load_mesh(report.stl)
    assert np.ptp(mesh.bounds, axis=0) == pytest.approx(report.size_mm, abs=0.02)
    assert mesh.bounds[0] == pytest.approx((-75.3, -82.3, -1.6), abs=0.02)
    assert mesh.volume == pytest.approx(report.volume_mm3, rel=0.001)
    assert report.triangles == len(mesh.faces)
    assert report.mass_g == pytest.approx(report.volume_mm3 * 0.00124)
    assert {path.name for path in report.step.parent.iterdir()} == {"mount.step", "mount.stl", "mount.3mf"}


def test_mount_follows_size_and_sheet_of_another_badge() -> None:
    request = Request("Grace Hopper", lens="40lpi", size_mm=(110.0, 130.0), range_m=(0.8, 1.2))
    other = design_badge(request, payload_for_name("Grace Hopper"))
    part = lanyard_mount(other, MountProcess(wall_mm=3.0, slot_mm=(20.0, 5.0)))
    box_ = part.bounding_box()
    assert tuple(box_.min) == pytest.approx((-58.3, -68.3, -1.6), abs=1e-4)
    assert tuple(box_.max) == pytest.approx((58.3, 65 + 17, 0.3 + 1.25 + 0.1 + 1.2), abs=1e-4)
    assert len(part.solids()) == 1 and part.is_valid


def one_triangle_gone(mesh: Any) -> None:
    mesh.update_faces(np.arange(len(mesh.faces)) != 7)


def one_triangle_turned(mesh: Any) -> None:
    faces = mesh.faces.copy()
    faces[7] = faces[7, ::-1]
    mesh.faces = faces


def inside_out(mesh: Any) -> None:
    mesh.faces = mesh.faces[:, ::-1].copy()


def one_tenth_too_high(mesh: Any) -> None:
    mesh.apply_translation((0, 0, 0.1))


def shrunk(mesh: Any) -> None:
    mesh.vertices = mesh.vertices * 0.998


def twice(mesh: Any) -> None:
    # The same surface over itself bounds nothing for a slicer, though each copy is closed.
    mesh.vertices, mesh.faces = mesh.vertices, np.vstack([mesh.faces, mesh.faces])


@pytest.mark.parametrize(
    ("damage", "complaint"),
    [
        (one_triangle_gone, "holes"),
        (one_triangle_turned, "face both ways"),
        (inside_out, "-.* mm³"),
        (one_tenth_too_high, "reaches from"),
        (shrunk, "mm³"),
        (twice, "holes"),
    ],
)
def test_damaged_mesh_is_refused(
    damage: Callable[[Any], None], complaint: str, report: MountReport, tmp_path: Path
) -> None:
    expected = solids.Expected(report.volume_mm3, (-75.3, -82.3, -1.6), (75.3, 92.0, 2.6))
    assert solids.check_stl(report.stl, expected) == report.triangles
    mesh = trimesh.load_mesh(report.stl)
    damage(mesh)
    mesh.export(tmp_path / "damaged.stl")
    with pytest.raises(FabricationError, match=complaint):
        solids.check_stl(tmp_path / "damaged.stl", expected)


def test_manifold3d_refuses_on_its_own(report: MountReport) -> None:
    mesh = trimesh.load_mesh(report.stl)
    with pytest.raises(FabricationError, match=r"as manifold3d reads it holds"):
        solids._check_manifold(mesh, 1.01 * mesh.volume)
    one_triangle_gone(mesh)
    with pytest.raises(FabricationError, match=r"no manifold \(NotManifold\)"):
        solids._check_manifold(mesh, mesh.volume)


def test_file_that_breaks_off_is_refused(report: MountReport, tmp_path: Path) -> None:
    expected = solids.Expected(report.volume_mm3, (-75.3, -82.3, -1.6), (75.3, 92.0, 2.6))
    for path, check in ((report.stl, solids.check_stl), (report.step, solids.check_step)):
        for share in (0.0, 0.5):
            cut = tmp_path / path.name
            cut.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
            with pytest.raises(FabricationError, match=r"allowed is"):
                check(cut, expected)


@pytest.mark.parametrize("kind", ["step", "stl"])
def test_nothing_is_left_of_a_failure(kind: str, badge: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    export = getattr(solids, f"export_{kind}")

    def another_part(part: Any, path: Path, **options: float) -> None:
        import build123d

        export(build123d.Box(150.6, 174.3, 4.2), path, **options)

    monkeypatch.setattr(mount, f"export_{kind}", another_part)
    with pytest.raises(FabricationError, match=rf"{kind.upper()} file holds 110248\.2 mm³, allowed is 416.* mm³"):
        write_mount(badge, tmp_path)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mount.stl").write_text("the older one")
    with pytest.raises(SpecError, match=r"mount\.stl exists already"):
        write_mount(badge, tmp_path)
    with pytest.raises(FabricationError):
        write_mount(badge, tmp_path, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["mount.stl"]
    assert (tmp_path / "mount.stl").read_text() == "the older one"


def test_same_badge_gives_the_same_bytes(badge: Badge, report: MountReport, tmp_path: Path) -> None:
    again = write_mount(badge, tmp_path)
    assert again.step.read_bytes() == report.step.read_bytes()
    assert again.stl.read_bytes() == report.stl.read_bytes()


@pytest.mark.parametrize("package", ["build123d", "trimesh", "manifold3d", "lib3mf"])
def test_missing_package_says_what_to_install(
    package: str, badge: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"{package}.*pip install moireid\[cad\]"):
        write_mount(badge, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_importing_the_mount_costs_no_cad_package() -> None:
    heavy = "{'build123d', 'OCP', 'trimesh', 'manifold3d'}"
    code = f"import sys, moireid.fabrication.mount; print(sorted({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"


def test_impossible_figures_are_named() -> None:
    with pytest.raises(FabricationError, match="wall_mm=-2"):
        MountProcess(wall_mm=-2.0)
    with pytest.raises(FabricationError, match="slot_mm"):
        MountProcess(slot_mm=(16.0, math.nan))
