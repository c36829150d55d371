"""Mounts put together, and all files of a mount as `print_badge` writes them, read back by packages that share no code
with the writers' own checks: cadquery for STEP, trimesh and the file's own JSON for GLB."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from moireid.badge import Badge
from moireid.errors import FabricationError
from moireid.fabrication import package
from moireid.fabrication.acrylic.plates import AcrylicPlan, plan_acrylic
from moireid.fabrication.assembly_files import write_assembly_step
from moireid.fabrication.mount_parts import plan_parts
from moireid.fabrication.printed.mount import KINDS
from moireid.fabrication.process_figures import mount_figures
from moireid.fabrication.solid_parts import SolidPart, acrylic_parts, check_parts, mount_solids


@pytest.fixture(scope="module")
def plan(ada: Badge) -> AcrylicPlan:
    return plan_acrylic(ada)


def test_every_part_is_where_it_was_planned(plan: AcrylicPlan) -> None:
    """Catches: a part on the wrong face, one turned over, and a sheet below the page."""
    placed = {part.name: part.shape for part in acrylic_parts(plan)}
    lows = {plate.name: plate.low_mm for plate in plan.plates} | {"sheet-0": plan.card_mm, "screw-0": plan.base.low_mm}
    for name, low in lows.items():
        assert pytest.approx(low, abs=1e-6) == placed[name].bounding_box().min.Z
    assert pytest.approx(plan.cover.low_mm + plan.cover.thickness_mm + 1.65) == placed["screw-0"].bounding_box().max.Z
    # The lanyard's slot shows which way is up: it is cut out of the top rim of all plates.
    for plate in plan.plates:
        assert placed[plate.name].center().Y < -0.005


@pytest.mark.slow
def test_parts_that_share_volume_are_refused(plan: AcrylicPlan) -> None:
    """Catches: a check of bounding boxes, of neighbours only, or none: each fault is in another pair."""
    (frame,) = plan.frames
    tight = replace(frame, openings=(frame.openings[0].grown(-0.3), *frame.openings[1:]))
    with pytest.raises(FabricationError, match=r"frame and pad share .* mm³, allowed is none"):
        check_parts(acrylic_parts(replace(plan, frames=(tight,))))
    high = replace(frame, thickness_mm=frame.thickness_mm + 1.0)
    with pytest.raises(FabricationError, match=r"frame share"):
        check_parts(acrylic_parts(replace(plan, frames=(high,))))
    narrow = replace(plan.base, openings=tuple(hole.grown(-0.3) for hole in plan.base.openings))
    with pytest.raises(FabricationError, match=r"screw-0 and base share"):
        check_parts(acrylic_parts(replace(plan, base=narrow)))


@pytest.fixture(scope="module")
def folder(ada: Badge, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, package.PrintResult, list[str]]:
    """Everything for one badge with a clip, as the command line orders it."""
    steps: list[str] = []
    place = tmp_path_factory.mktemp("ada")
    figures = mount_figures({"kerf_mm": 0.2, "base_mm": 4})
    return place, package.print_badge(ada, place, parts=plan_parts(ada, "clip", figures), progress=steps.append), steps


@pytest.mark.slow
def test_every_promised_file_is_there(folder: tuple[Path, package.PrintResult, list[str]]) -> None:
    """Catches: a file of the contract left out, left over, or reported under another name."""
    place, printed, steps = folder
    names = {
        "badge.json",
        "badge.pdf",
        "preview.png",
        "fringes.webp",
        "assembly.pdf",
        "mount.step",
        "mount.stl",
        "mount-clip.stl",
        "mount.3mf",
        "acrylic.step",
        "mount.glb",
    }
    drawn = ("acrylic", "acrylic-4mm", "acrylic-2mm", "acrylic-film-0.25mm")
    names |= {f"{name}.{kind}" for name in drawn for kind in ("dxf", "svg")}
    assert {path.name for path in place.iterdir()} == set(printed.files) == names
    assert {name for line in steps for name in line.replace(",", " ").split() if "." in name} == names - {"badge.json"}
    assert printed.mount_mass_g is not None and 12 < printed.mount_mass_g < 30
    assert "CUT-ACRYLIC-4MM" in printed.files["acrylic-4mm.dxf"].read_text()


@pytest.mark.slow
def test_step_holds_each_part_in_its_place_and_colour(plan: AcrylicPlan, tmp_path: Path) -> None:
    """Catches: parts in another's colour, which the writer's check passes over; parts lost, swapped or moved."""
    import cadquery

    parts, path = acrylic_parts(plan), tmp_path / "acrylic.step"
    write_assembly_step("stack", parts, path)
    read = cadquery.Assembly.importStep(str(path)).children
    assert [one.name for one in read] == [part.name for part in parts]
    for one, part in zip(read, parts, strict=True):
        shape = one.obj.moved(one.loc)
        assert shape.Volume() == pytest.approx(part.shape.volume) and shape.isValid()
        assert shape.Center().toTuple() == pytest.approx(tuple(part.shape.center()), abs=1e-6)
        seen = np.array(one.color.toTuple())
        seen[:3] = np.where(seen[:3] > 0.04045, ((seen[:3] + 0.055) / 1.055) ** 2.4, seen[:3] / 12.92)
        assert seen == pytest.approx(tuple(part.shape.color), abs=0.005), part.name


@pytest.mark.slow
def test_glb_shows_both_mounts_put_together(folder: tuple[Path, package.PrintResult, list[str]]) -> None:
    """Catches: millimetres for glTF's metres, mounts in each other, an opaque lens, a page without its print,
    parts that are not below their mount's node, light colours for dark ones."""
    path = folder[1].files["mount.glb"]
    data = path.read_bytes()
    magic, version, length, head = struct.unpack("<4sIII", data[:16])
    assert (magic, version, length) == (b"glTF", 2, len(data))
    document = json.loads(data[20 : 20 + head])
    materials = {m["name"]: m for m in document["materials"]}
    assert {"base", "page", "sheet", "frame", "cover", "screw", "tray", "clip", "print"} <= set(materials)
    assert materials["sheet"]["alphaMode"] == "BLEND" and materials["base"].get("alphaMode", "OPAQUE") == "OPAQUE"
    # 60 of 255 in sRGB is 0.045 of the light.
    assert materials["tray"]["pbrMetallicRoughness"]["baseColorFactor"][0] == pytest.approx(0.045, abs=0.003)
    assert len(document["images"]) >= 1
    nodes = {node["name"]: node for node in document["nodes"]}
    for mount, parts in (("printed", {"tray", "clip", "page", "sheet-0", "print"}), ("acrylic", {"base", "cover"})):
        below = {document["nodes"][k]["name"] for k in nodes[mount]["children"]}
        assert {f"{mount}-{part}" for part in parts} <= below
    scene = trimesh.load(path, force="scene")
    placed = {
        name: scene.geometry[scene.graph[name][1]].copy().apply_transform(scene.graph[name][0])
        for name in nodes
        if name in scene.graph.nodes_geometry
    }
    assert np.ptp(placed["acrylic-base"].bounds, axis=0)[2] == pytest.approx(0.004, abs=1e-6)
    lows = {name: mesh.bounds[0][2] for name, mesh in placed.items()}
    assert lows["printed-tray"] == pytest.approx(-0.0016, abs=1e-6) and lows["printed-tray"] > lows["printed-clip"]
    assert lows["printed-sheet-0"] == pytest.approx(0.0004, abs=1e-6)
    assert placed["printed-tray"].bounds.sum(axis=0)[0] == pytest.approx(0.0, abs=1e-5)
    assert placed["acrylic-base"].bounds[0][0] > placed["printed-tray"].bounds[1][0] + 0.01


def test_a_part_that_hangs_in_the_air_is_refused(plan: AcrylicPlan) -> None:
    """Catches: a check of overlaps alone, which a cover too high above its sheet passes."""
    check_parts(acrylic_parts(plan))
    high = replace(plan.cover, low_mm=plan.cover.low_mm + 0.2)
    with pytest.raises(FabricationError, match=r"cover is 0\.2000 mm from the \S+ that it must touch"):
        check_parts(acrylic_parts(replace(plan, cover=high)))


@pytest.mark.parametrize("kind", KINDS)
def test_page_and_sheet_are_held_as_designed(kind: str, ada: Badge) -> None:
    """Catches: springs that reach into the page, a sheet that no lip touches, air between page and sheet."""
    parts = {name: SolidPart(name, shape).solid for name, shape in mount_solids(ada, kind).items()}
    carrier, page, sheet = parts["tray"], parts["page"], parts["sheet-0"]
    assert page.min_gap(sheet, 1.0) < 1e-3 and page.min_gap(carrier, 1.0) < 1e-3
    for one, other in ((page, sheet), (page, carrier), (sheet, carrier)):
        assert (one ^ other).volume() < 0.01
    # Lips press on the sheet.
    assert sheet.min_gap(carrier, 1.0) == pytest.approx(0.0, abs=2e-3)
    assert page.bounding_box()[2] == pytest.approx(0.1, abs=1e-6)
