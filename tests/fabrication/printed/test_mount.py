"""The printed mounts as things: what fits, what slides, what stays in sight, and which files are refused.

The stack and the sight lines are computed here from the badge's page coordinates alone, on a badge whose sheet is not
in the middle, and held against the STL with manifold3d.
"""

from __future__ import annotations

import math
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np
import pytest
import trimesh

from kit.mounting import box, framed, sight_volume
from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication import solids
from moireid.fabrication.mount_parts import plan_parts
from moireid.fabrication.package import print_badge
from moireid.fabrication.printed import mount
from moireid.fabrication.printed.mount import MountProcess, MountReport, mount_bodies, write_mount
from moireid.fabrication.printed.tray import plan_tray, seated_twist_deg

CARD_MM, LENS_MM, PLAY_MM, CARD_ROOM_MM = 0.3, 1.0, 0.3, 0.1
#: Where the numbers meet exactly, float32 vertices leave overlaps thinner than 1e-5 mm.
TOUCH_MM3 = 0.01


@pytest.fixture(scope="module")
def badge() -> Badge:
    """Ada's badge with its sheet 3 mm above the middle, so that a mount turned upside down does not fit."""
    issued = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace"))
    x0, y0, x1, y1 = issued.gratings[0].rect_mm
    return replace(issued, gratings=(replace(issued.gratings[0], rect_mm=(x0, y0 - 3, x1, y1 - 3)),))


@pytest.fixture(scope="module")
def report(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> MountReport:
    return write_mount(badge, tmp_path_factory.mktemp("mount"))


def manifold(mesh: Any) -> Any:
    return manifold3d.Manifold(manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)))


@pytest.fixture(scope="module")
def sprung(report: MountReport) -> Any:
    """The mount as a slicer sees it, its springs at rest."""
    return manifold(trimesh.load_mesh(report.stls[0]))


#: Where springs may touch the card: 71 to 72.2 mm from the middle, below the lips, at their tongues' lower ends.
PADS = [(side * 71.6, y) for side in (-1, 1) for y in (-19.22 - 8.5, 25.22 - 8.5)]


@pytest.fixture(scope="module")
def printed(sprung: Any) -> Any:
    """The mount with its springs bent back by card and sheet: the part of the pads above the floor is gone."""
    bent = sprung
    for x, y in PADS:
        bent -= manifold3d.Manifold.cube((1.21, 3.02, 0.4), True).translate((x, y, 0.2))
    return bent


def card_and_sheet(badge: Badge, *, up: float = 0.0) -> tuple[Any, Any]:
    card = framed(badge.outline_mm, badge)
    rows = framed(badge.gratings[0].rect_mm, badge)
    sheet = (card[0], rows[1], card[2], rows[3])
    return box(card, 0.0, CARD_MM, up=up), box(sheet, CARD_MM, CARD_MM + LENS_MM, up=up)


def overlap_mm3(one: Any, other: Any) -> float:
    return (one ^ other).volume()


@pytest.mark.claim("A printed mount holds card and sheet")
@pytest.mark.slow
def test_card_and_sheet_lie_in_the_tray_and_cannot_leave_but_upwards(badge: Badge, printed: Any) -> None:
    card, sheet = card_and_sheet(badge)
    for piece, sideways in ((card, 0.29), (sheet, 0.29)):
        for dx, dy in ((0, 0), (sideways, 0), (0, -0.29)):
            assert overlap_mm3(piece.translate((dx, dy, 0)), printed) < TOUCH_MM3
        # Clearance is 0.3 mm at the right and below: a wider one is as wrong as a narrower one.  At the left two stops
        # are at the board's edge, at either end of the sheet's 88.88 mm, so that a piece against both cannot turn.
        for dx, dy in ((0.35, 0), (-0.05, 0), (0, -0.35)):
            assert overlap_mm3(piece.translate((dx, dy, 0)), printed) > 0.01
        middle_y = 3.0
        for turn_deg in (0.1, -0.1):
            turned = piece.translate((73, -middle_y, 0)).rotate((0, 0, turn_deg)).translate((-73, middle_y, 0))
            assert overlap_mm3(turned, printed) > TOUCH_MM3
    # The floor is right under the card; what is left out of it is looked at below.
    assert overlap_mm3(card.translate((0, 0, -0.05)), printed) > 0.15 * 146 * 160 * 0.05
    # Two feet carry the sheet 0.3 mm lower; from 0.1 mm above the card they rise by 45 degrees.
    assert overlap_mm3(sheet.translate((0, -0.35, 0)), printed) == pytest.approx(2 * 0.05 * 0.9**2 / 2, rel=0.01)
    # So do the lips, from 0.1 mm above the sheet's edges, left and right, along all its 88.88 mm.
    assert overlap_mm3(sheet.translate((0, 0, 0.09)), printed) < TOUCH_MM3
    assert overlap_mm3(sheet.translate((0, 0, 0.3)), printed) == pytest.approx(88.88 * 0.2**2, rel=0.02)
    # A sheet cut 0.2 mm too narrow comes up by as much more, and no farther.
    narrow = box((sheet.bounding_box()[0] + 0.2, -1, sheet.bounding_box()[3] - 0.2, 1), CARD_MM, CARD_MM + LENS_MM)
    assert overlap_mm3(narrow.translate((0, 0, 0.29)), printed) < TOUCH_MM3
    assert overlap_mm3(narrow.translate((0, 0, 0.4)), printed) > TOUCH_MM3
    assert overlap_mm3(card.translate((0, 0, 0.09)), printed) < TOUCH_MM3


def test_card_and_sheet_slide_in_from_the_top(badge: Badge, printed: Any) -> None:
    card, sheet = card_and_sheet(badge, up=250.0)
    assert overlap_mm3(card, printed) < TOUCH_MM3
    assert overlap_mm3(sheet, printed) < TOUCH_MM3
    # Nothing is higher than the rim above the sheet's rows, nor below its feet.
    x0, y0, x1, y1 = framed(badge.gratings[0].rect_mm, badge)
    for rect in ((x0 - 20, y1 + 0.01, x1 + 20, y1 + 200), (x0 - 20, y0 - 200, x1 + 20, y0 - 2.31)):
        assert overlap_mm3(box(rect, 1.401, 10), printed) == 0.0
    # Both lanyard slots go through: straps of 14 x 3 mm, far apart, with a tab all round each and nothing between.
    top, far = (badge.outline_mm[3] - badge.outline_mm[1]) / 2, 73 - 7.7 - 8
    for x in (-far, far):
        assert overlap_mm3(box((x - 7.0, top + 4.5, x + 7.0, top + 7.5), -5, 5), printed) == 0.0
        for dx, low, dx1, high in ((-7.5, 8.2, 7.5, 11), (-7.5, 0.5, 7.5, 3.5), (8.5, 5, 9.5, 7), (-9.5, 5, -8.5, 7)):
            assert overlap_mm3(box((x + dx, top + low, x + dx1, top + high), -5, 5), printed) > 1.0
    assert overlap_mm3(box((-far + 17, top + 0.5, far - 17, top + 20), -5, 5), printed) == 0.0


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


@pytest.mark.claim("A damaged mesh is refused before it is written")
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
    expected = report.bodies[0]
    assert expected.lower_mm == pytest.approx((-75.3, -82.3, -1.6))
    assert expected.upper_mm == pytest.approx((75.3, 92.0, 3.0))
    solids.check_stl(report.stls[0], expected)
    mesh = trimesh.load_mesh(report.stls[0])
    damage(mesh)
    mesh.export(tmp_path / "damaged.stl")
    with pytest.raises(FabricationError, match=complaint):
        solids.check_stl(tmp_path / "damaged.stl", expected)


@pytest.mark.slow
def test_nothing_is_left_of_a_failure(badge: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a mount that fails its check and stays; an older one that is destroyed by it."""
    export = solids.export_stl

    def another_part(part: Any, path: Path) -> None:
        import build123d

        export(build123d.Box(150.6, 174.3, 4.2), path)

    parts = replace(plan_parts(badge, "lanyard"), acrylic=None)
    (tmp_path / "mount.stl").write_text("the older one")
    monkeypatch.setattr(mount, "export_stl", another_part)
    with pytest.raises(FabricationError, match=r"STL file holds 110248\.2 mm³, allowed is \d{5}\.. mm³"):
        print_badge(badge, tmp_path, parts=parts, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["mount.stl"]
    assert (tmp_path / "mount.stl").read_text() == "the older one"


# What presses page and lens on each other, and keeps them from turning.


def test_springs_press_card_and_sheet_on_the_lips_and_nowhere_else(sprung: Any, printed: Any) -> None:
    """Catches: a pocket with air between lens and page, and a spring away from a lip, which would bow the sheet."""
    # The room is 0.1 mm, and each pad is 0.25 mm higher than that.
    for x, y in PADS:
        below = sprung ^ box((x - 1, y - 3, x + 1, y + 3), 0.01, 1.0)
        assert below.bounding_box()[5] == pytest.approx(CARD_ROOM_MM + 0.25, abs=0.005)
        assert below.bounding_box()[0] == pytest.approx(x - 0.6, abs=0.01)
        # A lip is in front of the board's edge next to it.
        edge = box((72.8, y - 1.5, 73.0, y + 1.5) if x > 0 else (-73.0, y - 1.5, -72.8, y + 1.5), 1.5, 1.6)
        assert overlap_mm3(edge, sprung) == pytest.approx(3 * 0.015, rel=0.02)
    # Elsewhere the floor is flat, and round each tongue a slit goes right through the plate.
    floor = box((-72.9, -79.9, 72.9, 79.9), 0.01, 0.29)
    assert overlap_mm3(floor, printed) < TOUCH_MM3
    for x, y in PADS:
        inner = np.sign(x) * (abs(x) - 4.0)
        assert overlap_mm3(box((inner - 0.1, y, inner + 0.1, y + 10), -2, 0.5), sprung) == 0.0
        assert overlap_mm3(box((x - 0.2, y - 2.1, x + 0.2, y - 1.7), -2, 0.5), sprung) == 0.0


def test_pocket_is_wider_than_the_board_by_the_stated_clearance(printed: Any, badge: Badge, tmp_path: Path) -> None:
    """Catches: a clearance taken once for two sides, or lost in the facets: measured on the mesh within 0.02 mm."""
    assert pocket_mm(printed, 0.7) - 146.0 == pytest.approx(2 * 0.3, abs=0.02)
    tight = write_mount(badge, tmp_path, kind="stand", process=MountProcess(clearance_mm=0.15, card_mm=0.5))
    body = manifold(trimesh.load_mesh(tight.stls[0]))
    assert pocket_mm(body, 0.7) - 146.0 == pytest.approx(2 * 0.15, abs=0.02)
    # Floor to lip at the board's edge: card, sheet, and 0.1 mm to slide in by.
    under = body ^ box((72.99, 20, 73.0, 21), 0.05, 5.0)
    assert under.bounding_box()[2] == pytest.approx(0.5 + 1.0 + 0.1, abs=0.02)


def pocket_mm(solid: Any, level: float) -> float:
    """Free width of the pocket near the top, between left and right rim."""
    strip = solid ^ box((-100, 70, 100, 71), level, level + 0.1)
    left, right = sorted((piece.bounding_box() for piece in strip.decompose()), key=lambda b: b[0])
    return float(right[0] - left[3])


def test_register_edges_bound_the_twist(badge: Badge) -> None:
    """Catches: a bound in radians, one for a single edge, and none at all."""
    # Two edges 0.05 mm off in opposite ways, 144.8 mm apart, and the same again would be two parts' errors.
    process = MountProcess()
    turned = seated_twist_deg(plan_tray(badge, process), process)
    assert turned == pytest.approx(math.degrees(math.atan(0.1 / 144.8)))
    with pytest.raises(FabricationError, match=r"turns the sheet by 0\.40 degrees, allowed are 0\.3") as caught:
        mount_bodies(badge, "lanyard", MountProcess(seat_mm=0.5))
    assert caught.value.details["twist_deg"] == pytest.approx(math.degrees(math.atan(1.0 / 144.8)))


# Clip and stand.


@pytest.fixture(scope="module")
def held(badge: Badge, tmp_path_factory: pytest.TempPathFactory) -> dict[str, MountReport]:
    return {kind: write_mount(badge, tmp_path_factory.mktemp(kind), kind=kind) for kind in ("clip", "stand")}


def in_use(report: MountReport) -> list[Any]:
    """The mount's bodies in their places, as meshes of the CAD shapes."""
    solids_ = []
    for body in report.bodies:
        vertices, faces = body.used.tessellate(0.02)
        solids_.append(manifold(trimesh.Trimesh([tuple(v) for v in vertices], faces)))
    return solids_


# The 3MF file, read here by the standard library alone.


def test_each_body_of_the_3mf_file_has_its_colour(held: dict[str, MountReport]) -> None:
    """Catches: a clip in the tray's colour, and colours in another order than the bodies."""
    with zipfile.ZipFile(held["clip"].stls[0].with_name("mount.3mf")) as archive:
        model = archive.read("3D/3dmodel.model").decode()
    assert re.findall(r'displaycolor="(#\w+)"', model) == ["#3C414BFF", "#C85A32FF"]
    assert re.findall(r'<object [^>]*pindex="(\d)"', model) == ["0", "1"]


def test_clip_goes_in_from_behind_and_the_bar_rests_in_its_hook(held: dict[str, MountReport]) -> None:
    """Catches: a hook too large for the slot, one that does not hold, and a clip that nothing can be clipped with."""
    tray, clip = in_use(held["clip"])
    for back in (0.0, 1.0, 2.0, 3.0, 4.0):
        assert overlap_mm3(clip.translate((0, -2.0, -back)), tray) < TOUCH_MM3
    # The tray hangs: it can sink 0.05 mm and no more, and swing neither forward nor back.
    for shift in ((0, -0.2, 0), (0, 0, 0.5), (0, 0, -0.5), (3.0, 0, 0)):
        assert overlap_mm3(clip, tray.translate(shift)) > (0.01 if shift[0] == 0 else -1)
    assert overlap_mm3(clip, tray.translate((0, -0.04, 0))) < TOUCH_MM3
    low, high = clip.bounding_box()[:3], clip.bounding_box()[3:]
    assert high[0] - low[0] == pytest.approx(12.0, abs=1e-3)
    # Cloth of 2 mm fits between the arms below their bend, and is pinched to 0.4 mm at the bump.
    spine = -1.6 - 0.3 - 2.0
    assert overlap_mm3(box((-6, 70, 6, 90), spine - 2.2, spine - 0.2), clip) == 0.0
    assert overlap_mm3(box((-6, 58, 6, 59), spine - 2.2, spine - 0.2), clip) > 10.0
    assert overlap_mm3(box((-6, 50, 6, 90), spine - 0.35, spine - 0.05), clip) == 0.0


def test_stand_leans_the_badge_back_and_does_not_fall_over(badge: Badge, held: dict[str, MountReport]) -> None:
    """Catches: a badge that leans to the viewer, lies flat, tips backwards, or is hidden by the stand's wall."""
    tray, stand = in_use(held["stand"])
    turn = np.eye(4)[:3]
    angle = math.radians(-12)
    turn[1:, 1:3] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    # Leaning back by 12 degrees: up of the tray goes away from the viewer, and then the foot is level.
    table = stand.transform(turn).bounding_box()
    foot = stand.transform(turn) ^ box((-200, table[1] - 1, 200, table[1] + 0.01), -200, 200)
    depth = foot.bounding_box()[5] - foot.bounding_box()[2]
    # It touches the table at both ends of both posts.
    for x in (table[0], table[3]):
        post = foot ^ box((x - 6.3, -200, x + 6.3, 200), -200, 200)
        assert post.bounding_box()[5] - post.bounding_box()[2] == pytest.approx(depth, abs=0.01)
    card, sheet = card_and_sheet(badge)
    weights = [(tray, 1.24), (stand, 1.24), (card, 0.8), (sheet, 1.3)]
    middle = [centroid(solid.transform(turn)) for solid, _ in weights]
    mass = [solid.volume() * density for solid, density in weights]
    centre = sum(m * c[2] for m, c in zip(mass, middle, strict=True)) / sum(mass)
    assert foot.bounding_box()[2] + 10 < centre < foot.bounding_box()[5] - 10
    half = badge.markers.size_mm / 2
    for x, y in badge.markers.centers_mm:
        view = sight_volume(framed((x - half, y - half, x + half, y + half), badge), CARD_MM, 45, up_and_down=True)
        assert overlap_mm3(view.translate((0, -PLAY_MM, 0)), stand) == 0.0


def centroid(solid: Any) -> np.ndarray:
    mesh = solid.to_mesh()
    return trimesh.Trimesh(mesh.vert_properties[:, :3], mesh.tri_verts).center_mass


@pytest.mark.parametrize("kind", ["lanyard", "clip", "stand"])
def test_nothing_is_printed_in_mid_air(kind: str, report: MountReport, held: dict[str, MountReport]) -> None:
    """Catches: a flat lip, a hook on its back, a rest that leans over: what would sag, or need supports."""
    made = report if kind == "lanyard" else held[kind]
    # A file a part, each of which a slicer can lay on a bed of its own.
    assert [path.name for path in made.stls] == ["mount.stl", *([f"mount-{kind}.stl"] if kind != "lanyard" else [])]
    for path in made.stls:
        (piece,) = trimesh.load_mesh(path).split()
        assert solids.overhang_mm2(piece) < 0.5
    flat = trimesh.creation.box((20.0, 1.5, 1.0), trimesh.transformations.translation_matrix((0, 2.0, 3.0)))
    wall = trimesh.creation.box((20.0, 3.0, 6.0), trimesh.transformations.translation_matrix((0, 0, 3.0)))
    shelf = trimesh.boolean.union([wall, flat])
    # A shelf 1.25 mm deep hangs but for what a line's other part holds.
    assert solids.overhang_mm2(shelf) == pytest.approx(20 * (1.25 - 0.42), rel=0.02)
    with pytest.raises(FabricationError, match=r"shelf has 16\.\d mm² of faces that would be printed in mid-air"):
        solids.check_overhangs(shelf, "shelf")


# The extremes.


def test_thin_wall_in_a_mesh_is_found() -> None:
    """Catches: a check that looks at the design's figures alone, and one that takes a corner's tip for a wall."""
    plate = box((0.0, 0.0, 20.0, 20.0), 0.0, 5.0)
    solids.check_walls(plate, [2.5], 0.8, "plate")
    thin = plate + box((19.0, 5.0, 30.0, 5.6), 0.0, 5.0)
    with pytest.raises(FabricationError, match=r"plate has walls thinner than 0\.8 mm at z = 2\.50 mm"):
        solids.check_walls(thin, [2.5], 0.8, "plate")
    solids.check_walls(plate + box((19.0, 5.0, 30.0, 5.81), 0.0, 5.0), [2.5], 0.8, "plate")
