"""The acrylic parts as a laser cuts them: kerf, fits, register, view, and which drawings are refused.

The drawings are read here with ezdxf and with the SVG's own words, and held against the badge's page coordinates.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np
import pytest

from kit.mounting import board_of, framed, sight_volume
from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError
from moireid.fabrication.acrylic import drawings
from moireid.fabrication.acrylic.plates import AcrylicPlan, plan_acrylic
from moireid.fabrication.process_figures import AcrylicProcess


@pytest.fixture(scope="module")
def badge() -> Badge:
    """Ada's badge with its sheet 3 mm above the middle, so that a cover turned upside down does not fit."""
    issued = design_badge(Order("Ada Lovelace", lens="50lpi"), payload_for_name("Ada Lovelace"))
    x0, y0, x1, y1 = issued.gratings[0].rect_mm
    return replace(issued, gratings=(replace(issued.gratings[0], rect_mm=(x0, y0 - 3, x1, y1 - 3)),))


@pytest.fixture(scope="module")
def plan(badge: Badge) -> AcrylicPlan:
    return plan_acrylic(badge)


def written(plan: AcrylicPlan, kerf_mm: float, folder: Path) -> tuple[Path, Path, drawings.CuttingDrawing]:
    drawing = drawings.draw(plan, kerf_mm)["acrylic"]
    files = folder / "acrylic.dxf", folder / "acrylic.svg"
    drawings.write_dxf(drawing, files[0])
    drawings.write_svg(drawing, files[1])
    drawings.check_dxf(files[0], drawing)
    drawings.check_svg(files[1], drawing)
    return *files, drawing


def drawing_of(path: Path) -> Any:
    # Here, as it takes more than a second to load, and each worker of the tests loads this file.
    import ezdxf

    return ezdxf.readfile(path)


def polygons(path: Path) -> dict[str, list[np.ndarray]]:
    """Every cutting path of a DXF file as a polygon, by plate name, outline first."""
    from ezdxf.path import make_path

    found: dict[str, list[np.ndarray]] = {}
    names, low, right = iter(("base", "frame", "cover", "lips")), math.inf, -math.inf
    for entity in drawing_of(path).modelspace().query('LWPOLYLINE[layer ? "CUT-.*"]'):
        points = np.array([(p.x, p.y) for p in make_path(entity).flattening(0.001)])
        if not low < points[:, 0].min() < right:
            name, low, right = next(names), points[:, 0].min(), points[:, 0].max()
        found.setdefault(name, []).append(points)
    return found


def extent(points: np.ndarray) -> np.ndarray:
    return np.ptp(points, axis=0)


@pytest.mark.parametrize("kerf", [0.0, 0.15, 1.0])
def test_kerf_makes_outlines_larger_and_openings_smaller(kerf: float, plan: AcrylicPlan, tmp_path: Path) -> None:
    """Catches: kerf on the wrong side, the whole instead of half of it, and openings forgotten."""
    path, _, _ = written(plan, kerf, tmp_path)
    parts = polygons(path)
    for name in ("base", "frame", "lips", "cover"):
        # 146 + 2 x 0.14 of air + 2 x 10.5 of rim; the burnt line takes half its width off each side again.
        assert extent(parts[name][0]) - kerf == pytest.approx([167.28, 181.28], abs=1e-3)
    assert extent(parts["frame"][1]) + kerf - (146, 160) == pytest.approx([0.28, 0.28], abs=1e-3)
    holes = [p for p in parts["base"][1:] if extent(p)[0] < 5]
    assert len(holes) == 6
    for hole in holes:
        assert extent(hole) + kerf == pytest.approx([3.4, 3.4], abs=2e-3)
        middle = (hole.max(axis=0) + hole.min(axis=0)) / 2
        assert np.linalg.norm(hole - middle, axis=1) == pytest.approx((3.4 - kerf) / 2, abs=2e-3)
    # The cover is set back by 2.5 mm.
    assert extent(parts["cover"][1]) + kerf == pytest.approx([151.0, 165.0], abs=1e-3)
    # Between the lips the film's window is 146 - 2 x 2 mm wide, along the sheet's 88.88 mm.
    window = manifold3d.CrossSection([parts["lips"][1]])
    area = (146.28 - kerf) * (160.28 - kerf) - 2 * (2.14) * (88.88 + kerf)
    # Rounded corners: four of the window inwards, four at the lips' tips, and four at their roots.
    assert window.area() == pytest.approx(area, abs=12 * 1.1**2)


#: Colours of LightBurn's first eight layers, by the documentation's table of its palette.
LIGHTBURN = ["#000000", "#0000ff", "#ff0000", "#00e000", "#d0d000", "#ff8000", "#00e0e0", "#ff00ff"]


def lightburn_layer(colour: tuple[int, int, int]) -> int:
    """The layer into which LightBurn puts a colour: the nearest of its palette's."""
    palette = [[int(text[k : k + 2], 16) for k in (1, 3, 5)] for text in LIGHTBURN]
    return int(np.argmin(np.linalg.norm(np.array(palette) - colour, axis=1)))


def test_a_stock_is_a_layer_of_its_own_in_lightburn(plan: AcrylicPlan, tmp_path: Path) -> None:
    """Catches: one red for all plates, text, which LightBurn leaves out, plates of another stock in a stock's file, an
    SVG in pixels or upside down, and a scale bar that is none."""
    import ezdxf.colors

    stocks = {"acrylic-3mm": ["base"], "acrylic-2mm": ["frame", "cover"], "acrylic-film-0.25mm": ["lips"]}
    made = drawings.draw(plan, 0.15)
    assert list(made) == ["acrylic", *stocks]
    seen: dict[str, set[int]] = {}
    for name, drawing in made.items():
        dxf_path, svg_path = tmp_path / f"{name}.dxf", tmp_path / f"{name}.svg"
        drawings.write_dxf(drawing, dxf_path)
        drawings.write_svg(drawing, svg_path)
        document, text = drawing_of(dxf_path), svg_path.read_text()
        things = list(document.modelspace())
        assert {thing.dxftype() for thing in things} == {"LWPOLYLINE"} and "<text" not in text
        layers = {document.layers.get(thing.dxf.layer) for thing in things}
        seen[name] = {lightburn_layer(ezdxf.colors.aci2rgb(layer.color)) for layer in layers}
        colours = [tuple(bytes.fromhex(found)) for found in re.findall(r'stroke="#(\w{6})"', text)]
        assert len(layers) == len(colours) == len(seen[name]) and set(map(lightburn_layer, colours)) == seen[name]
        wanted = stocks.get(name, [plate.name for plate in plan.plates])
        assert sorted(re.findall(r'<path id="(\w+)"', text)) == sorted(wanted)
        lines = [thing for thing in things if thing.dxf.layer == "ENGRAVE" and len(thing) == 2]
        assert max(math.dist(*line.get_points("xy")) for line in lines) == pytest.approx(100.0)
        size = re.search(r'width="([\d.]+)mm" height="([\d.]+)mm" viewBox="0 0 ([\d. ]+)"', text)
        assert size and f"{size[1]} {size[2]}" == size[3]
        # The first point of the SVG's plate is that of the DXF's, with y turned round.
        first = re.search(rf'<path id="{wanted[0]}" d="M ([\d.]+) ([\d.]+)', text)
        assert first and next(thing for thing in things if thing.dxf.layer != "ENGRAVE").get_points("xy")[0] == (
            pytest.approx((float(first[1]), float(size[2]) - float(first[2])), abs=1e-4)
        )
    # A stock has the same colour on all its drawings, and no two have the same; blue engraves on all.
    alone = [seen[name] - {1} for name in stocks]
    assert [len(layers) for layers in alone] == [1, 1, 1] and set.union(*alone) | {1} == seen["acrylic"]
    assert len(seen["acrylic"]) == 4 and all(1 in layers for layers in seen.values())


def test_files_are_the_same_for_the_same_badge(plan: AcrylicPlan, tmp_path: Path) -> None:
    """Catches: the time of writing in a file."""
    folders = tmp_path / "a", tmp_path / "b"
    for folder in folders:
        folder.mkdir()
        written(plan, 0.15, folder)
    assert len({tuple(path.read_bytes() for path in sorted(folder.iterdir())) for folder in folders}) == 1


def test_register_keeps_page_and_lens_within_the_twist(plan: AcrylicPlan) -> None:
    """Catches: a bound for one of the two pieces alone, in radians, or from the width; solved here without it."""

    def most_turn(width: float, height: float) -> float:
        """The angle at which a rectangle touches both upright edges."""
        low, high = 0.0, 0.1
        for _ in range(60):
            middle = (low + high) / 2
            wide = width * math.cos(middle) + height * math.sin(middle)
            low, high = (middle, high) if wide < width + 2 * plan.clearance_mm else (low, middle)
        return math.degrees(low)

    together = most_turn(146.0, 160.0) + most_turn(146.0, 88.88)
    assert 0.27 < together < 0.3
    assert plan.clearance_mm == 0.14


def test_page_and_lens_are_clamped_without_air(plan: AcrylicPlan) -> None:
    """Catches: a frame as thick as the stack or thicker, so that the film rests on it and not on the sheet."""
    assert [plate.thickness_mm for plate in plan.plates] == [3.0, 2.0, 0.25, 2.0]
    # Three layers of card below the page: 0.9 + 0.3 + 1.0 mm in a frame of 2 mm.
    assert plan.layers == 3 and plan.frames[0].low_mm == pytest.approx(-0.9) and plan.base.low_mm == pytest.approx(-3.9)
    assert plan.lips.low_mm == pytest.approx(0.3 + 1.0) and plan.cover.low_mm == pytest.approx(0.3 + 1.0 + 0.25)
    assert plan.squeeze_mm == pytest.approx(0.2)
    assert plan.screw_mm == pytest.approx(3.0 + 0.9 + 1.3 + 0.25 + 2.0 + 2.4)


@pytest.mark.claim("No mount hides a fringe or a marker")
def test_fringes_and_markers_stay_in_sight_of_cover_and_screws(badge: Badge, plan: AcrylicPlan, tmp_path: Path) -> None:
    """Catches: a lip over the fringes, a cover too thick, a window upside down; on the paths as a laser finds them."""
    path, _, _ = written(plan, 0.0, tmp_path)
    parts = polygons(path)
    outer = parts["cover"][0]
    middle = (outer.max(axis=0) + outer.min(axis=0)) / 2

    def solid_of(name: str, setback: float, thickness: float, low: float) -> Any:
        """A plate on the sheet, its window moved outwards."""
        outline, window, *holes = [manifold3d.CrossSection([points - points_middle(name)]) for points in parts[name]]
        section = outline - window.offset(setback, manifold3d.JoinType.Miter)
        for hole in holes:
            section -= hole
        return manifold3d.Manifold.extrude(section, thickness).translate((0, 0, low))

    def points_middle(name: str) -> np.ndarray:
        return (parts[name][0].max(axis=0) + parts[name][0].min(axis=0)) / 2

    assert middle == pytest.approx(points_middle("cover"))
    lips, cover = solid_of("lips", 0.0, 0.25, 1.3), solid_of("cover", 0.0, 2.0, 1.55)
    heads = [manifold3d.Manifold.cylinder(1.65, 2.85).translate((x, y, 3.55)) for x, y in plan.screws]
    half = badge.markers.size_mm / 2
    views = [sight_volume(framed(badge.gratings[0].rect_mm, badge), 1.3, 60, up_and_down=True)]
    views += [
        sight_volume(framed((x - half, y - half, x + half, y + half), badge), 0.3, 45, up_and_down=True)
        for x, y in badge.markers.centers_mm
    ]
    for view in views:
        for dx, dy in ((0.14, 0), (-0.14, 0), (0, 0.14), (0, -0.14)):
            assert all((view.translate((dx, dy, 0)) ^ thing).volume() == 0.0 for thing in (lips, cover, *heads))
    # A cover as far in as the film would hide fringes: it is set back for them.
    assert (views[0].translate((0.14, 0, 0)) ^ solid_of("cover", -4.5, 2.0, 1.55)).volume() > 0.01
    # The narrower the margin, the farther back it is, and the wider the rim that the screws need.
    narrow = plan_acrylic(board_of(badge, 146.0, 160.0, margin=3.0), AcrylicProcess(lip_reach_mm=0.5))
    assert narrow.cover.openings[0].bounds[2] - 73.0 > 2.5
    assert narrow.base.outline.bounds[2] > plan.base.outline.bounds[2]


def cutting_paths(document: Any) -> list[Any]:
    return [e for e in document.modelspace() if e.dxf.layer == "CUT-ACRYLIC-2MM"]


def one_open(document: Any) -> None:
    cutting_paths(document)[1].close(False)


def one_twice(document: Any) -> None:
    document.modelspace().add_entity(cutting_paths(document)[0].copy())


def one_gone(document: Any) -> None:
    document.modelspace().delete_entity(cutting_paths(document)[2])


def one_moved(document: Any) -> None:
    cutting_paths(document)[1].translate(0.01, 0, 0)


def in_inches(document: Any) -> None:
    document.units = 1


def in_a_line_type_of_no_name(document: Any) -> None:
    cutting_paths(document)[1].dxf.linetype = "NOWHERE"


def in_blue(document: Any) -> None:
    document.layers.get("CUT-ACRYLIC-2MM").color = 5


@pytest.mark.parametrize(
    ("damage", "complaint"),
    [
        (one_open, "open path on CUT-ACRYLIC-2MM"),
        (one_twice, "has 21 paths on CUT-ACRYLIC-2MM, allowed is 20"),
        (one_gone, "has 19 paths"),
        (one_moved, "another path on CUT-ACRYLIC-2MM"),
        (in_inches, "counts in unit 1"),
        (in_blue, "in colour 5"),
        (in_a_line_type_of_no_name, "has 1 faults in its audit"),
    ],
)
def test_damaged_dxf_is_refused(
    damage: Callable[[Any], None], complaint: str, plan: AcrylicPlan, tmp_path: Path
) -> None:
    """Catches: a check that looks at less than the whole file."""
    path, _, drawing = written(plan, 0.15, tmp_path)
    document = drawing_of(path)
    damage(document)
    document.saveas(path)
    with pytest.raises(FabricationError, match=complaint):
        drawings.check_dxf(path, drawing)
    whole = path.read_bytes()
    for share in (0.0, 0.001, 0.5, 0.99):
        path.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(FabricationError, match="DXF cannot be read back, allowed is a readable file"):
            drawings.check_dxf(path, drawing)


def test_clearance_follows_the_board_or_is_refused(badge: Badge) -> None:
    """Catches: one clearance for all boards, and a loose one let through."""
    small = design_badge(Order("A", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.6, 0.7)), payload_for_name("A"))
    assert plan_acrylic(small).clearance_mm == 0.05
    assert plan_acrylic(board_of(badge, 300.0, 300.0)).clearance_mm == 0.15
    with pytest.raises(
        FabricationError, match=r"with 0\.2 mm of air .* by 0\.40 degrees, and 0\.3 are allowed; .* 0\.149 or less"
    ):
        plan_acrylic(badge, AcrylicProcess(clearance_mm=0.2))
    with pytest.raises(
        FabricationError, match=r"0\.05 mm of air that a laser needs, one may turn on the other by 0\.\d\d degrees"
    ):
        plan_acrylic(board_of(badge, 30.0, 40.0))


@pytest.mark.parametrize(
    ("lens_mm", "margin", "words"),
    [
        (0.2, 5.0, r"too thin for a frame .* 0\.15 mm above it; give a lens sheet .lens. of 0\.35 mm or more"),
        (6.0, 5.0, r"film's lip leaves 3\.\d\d mm next to marker \d, .* give a lens sheet .lens. of \d\.\d+ mm or"),
        (
            14.0,
            40.0,
            r"14\.3 mm thick, and 3 plates of 4 mm make a frame of 12 mm; give a lens sheet .* of 12\.3 mm or less",
        ),
    ],
)
def test_sheets_that_no_frame_holds_are_refused(lens_mm: float, margin: float, words: str, badge: Badge) -> None:
    """Catches: a stack that cannot be built, or one whose lips hide the markers."""
    with pytest.raises(FabricationError, match=words):
        plan_acrylic(board_of(badge, 200.0, 200.0, margin=margin, lens_mm=lens_mm))
