"""The acrylic stack put together, and all files of a mount as `print_badge` writes them."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from moireid.badge import Badge
from moireid.cli.printing.print_cmd import print_command
from moireid.errors import FabricationError, SpecError
from moireid.fabrication import package
from moireid.fabrication.acrylic import stack
from moireid.fabrication.acrylic.plates import AcrylicPlan, plan_acrylic
from moireid.fabrication.acrylic.stack_step import check_stack_step
from moireid.fabrication.printed.mount import KINDS
from moireid.fabrication.process_figures import mount_figures


@pytest.fixture(scope="module")
def plan(ada: Badge) -> AcrylicPlan:
    return plan_acrylic(ada)


def test_every_part_is_where_it_was_planned(plan: AcrylicPlan) -> None:
    """Catches: a part on the wrong face, one turned over, and a sheet below the page."""
    placed = {part.name: part.body for part in stack.assemble(plan)}
    lows = {"base": -3.0, "page": 0.0, "frame": 0.0, "sheet": 0.3, "cover": 1.3, "screw-0": -3.0}
    for name, low in lows.items():
        x0, _, z0, _, y1, _ = placed[name].bounding_box()
        assert z0 == pytest.approx(low, abs=1e-3)
        if name in ("base", "frame", "cover"):
            assert (x0, y1) == pytest.approx((-83.14, 90.14), abs=1e-3)
    assert placed["screw-0"].bounding_box()[5] == pytest.approx(2.8 + 1.65, abs=1e-3)
    # The lanyard's slot shows which way is up: it is cut out of the top rim of all three plates.
    for name in ("base", "frame", "cover"):
        assert stack._mesh(placed[name]).center_mass[1] < -0.005


def test_a_part_that_hangs_in_the_air_is_refused(plan: AcrylicPlan) -> None:
    """Catches: a check of overlaps alone, which a cover too high above its sheet passes."""
    stack.check_stack(plan)
    high = replace(plan.cover, low_mm=plan.cover.low_mm + 0.2)
    with pytest.raises(FabricationError, match=r"cover is 0\.2000 mm from the sheet that it lies on"):
        stack.check_stack(replace(plan, cover=high))


@pytest.mark.slow
def test_parts_that_share_volume_are_refused(plan: AcrylicPlan) -> None:
    """Catches: a check of bounding boxes, of neighbours only, or none: each fault is in another pair."""
    stack.check_stack(plan)
    tight = replace(plan.frame, openings=(plan.frame.openings[0].grown(-0.3), *plan.frame.openings[1:]))
    with pytest.raises(FabricationError, match=r"frame and page share .* mm³, allowed is none"):
        stack.check_stack(replace(plan, frame=tight))
    with pytest.raises(FabricationError, match=r"sheet and frame share|cover and frame share"):
        stack.check_stack(replace(plan, frame=replace(plan.frame, thickness_mm=1.5)))
    narrow = replace(plan.base, openings=tuple(hole.grown(-0.3) for hole in plan.base.openings))
    with pytest.raises(FabricationError, match=r"screw-0 and base share"):
        stack.check_stack(replace(plan, base=narrow))


@pytest.fixture(scope="module")
def folder(ada: Badge, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, package.PrintResult, list[str]]:
    """Everything for one badge with a clip, as the command line orders it."""
    steps: list[str] = []
    place = tmp_path_factory.mktemp("ada")
    figures = mount_figures(["kerf_mm=0.2", "base_mm=4"])
    return place, package.print_badge(ada, place, mount="clip", figures=figures, progress=steps.append), steps


@pytest.mark.slow
def test_every_promised_file_is_there(folder: tuple[Path, package.PrintResult, list[str]]) -> None:
    """Catches: a file of the contract left out, left over, or reported under another name."""
    place, printed, steps = folder
    names = {
        "badge.json",
        "badge.pdf",
        "preview.png",
        "preview.webp",
        "assembly.pdf",
        "mount.step",
        "mount.stl",
        "mount.3mf",
    }
    names |= {"acrylic.dxf", "acrylic.svg", "acrylic.step", "stack.glb"}
    assert {path.name for path in place.iterdir()} == set(printed.files) == names
    assert {name for line in steps for name in line.replace(",", " ").split() if "." in name} == names - {"badge.json"}
    assert printed.mount_mass_g is not None and 40 < printed.mount_mass_g < 70
    figures = printed.mount_figures
    assert (figures["kerf_mm"], figures["base_mm"], figures["frame_mm"]) == (0.2, 4.0, 1.0)
    assert max(figures["twist_deg"], figures["acrylic_twist_deg"]) < 0.3
    assert "CUT-BASE-4MM" in printed.files["acrylic.dxf"].read_text()


@pytest.mark.slow
def test_glb_shows_stack_and_mount(folder: tuple[Path, package.PrintResult, list[str]]) -> None:
    """Catches: millimetres for glTF's metres, parts on top of each other, an opaque lens, a page without its print."""
    path = folder[1].files["stack.glb"]
    data = path.read_bytes()
    magic, version, length, head = struct.unpack("<4sIII", data[:16])
    assert (magic, version, length) == (b"glTF", 2, len(data))
    document = json.loads(data[20 : 20 + head])
    materials = {m["name"]: m for m in document["materials"]}
    assert {"base", "page", "sheet", "frame", "cover", "screw", "tray", "clip", "print"} <= set(materials)
    assert materials["sheet"]["alphaMode"] == "BLEND" and materials["base"].get("alphaMode", "OPAQUE") == "OPAQUE"
    assert len(document["images"]) >= 1
    scene = trimesh.load(path, force="scene")
    assert np.ptp(scene.geometry["base"].bounds, axis=0) == pytest.approx((0.16628, 0.18028, 0.004), abs=1e-5)
    lows = {name: mesh.bounds[0][2] for name, mesh in scene.geometry.items()}
    # Drawn apart by 15 mm for each part below.
    high = {"base": -0.004, "page": 0.015, "frame": 0.015, "sheet": 0.0303, "cover": 0.0463}
    assert [lows[name] for name in high] == pytest.approx(list(high.values()), abs=1e-5)
    assert lows["cover"] < lows["screw-0"] + 0.02
    assert lows["tray"] > lows["clip"]
    assert (lows["page-held"], lows["sheet-held-0"]) == pytest.approx((0.0, 0.0003), abs=1e-6)
    assert scene.geometry["tray"].bounds[0][0] > scene.geometry["cover"].bounds[1][0]


@pytest.mark.slow
def test_step_names_each_part_and_keeps_arcs(folder: tuple[Path, package.PrintResult, list[str]]) -> None:
    """Catches: bodies without names or colours, arcs cut into lines, and a check that counts without measuring."""
    path = folder[1].files["acrylic.step"]
    text = path.read_text()
    assert all(f"PRODUCT('{name}'" in text for name in ("base", "page", "frame", "sheet-0", "cover", "screw-0"))
    assert "COLOUR_RGB" in text and "CYLINDRICAL_SURFACE" in text
    with pytest.raises(FabricationError, match=r"acrylic\.step holds the parts .*'base'.*, allowed are \['base'\]"):
        check_stack_step(path, {"base": 1.0})


@pytest.mark.slow
def test_damaged_glb_is_refused(folder: tuple[Path, package.PrintResult, list[str]], tmp_path: Path) -> None:
    """Catches: a check that does not read, and one that counts parts without looking at them."""
    path = folder[1].files["stack.glb"]
    scene = trimesh.load(path, force="scene")
    volumes = {}
    for name, mesh in scene.geometry.items():
        if not name.startswith("picture"):
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
            volumes[name] = float(mesh.volume) * 1e9
    stack.check_glb(path, volumes)
    with pytest.raises(FabricationError, match=r"stack\.glb holds cover with"):
        stack.check_glb(path, volumes | {"cover": 1.1 * volumes["cover"]})
    with pytest.raises(FabricationError, match=r"stack\.glb holds the parts"):
        stack.check_glb(path, volumes | {"hat": 1.0})
    cut = tmp_path / "cut.glb"
    cut.write_bytes(path.read_bytes()[:9000])
    with pytest.raises(FabricationError, match=r"stack\.glb cannot be read back"):
        stack.check_glb(cut, volumes)


def test_assembly_sheet_lists_what_the_mount_needs(ada: Badge, tmp_path: Path) -> None:
    """Catches: a lanyard for a clip, plates or screws of another badge, a line that runs off the page."""
    import pypdfium2 as pdfium

    figures = mount_figures(["kerf_mm=0.2", "base_mm=4"])
    parts = package.plan_parts(ada, "clip", figures)
    package.write_assembly_pdf(ada, tmp_path / "a.pdf", mount="clip", acrylic=parts.acrylic, figures=figures)
    document = pdfium.PdfDocument(tmp_path / "a.pdf")
    text = document[0].get_textpage()
    words = text.get_text_range()
    right = max(text.get_charbox(k)[2] for k in range(text.count_chars()))
    width = document[0].get_size()[0]
    document.close()
    assert "with its clip" in words and "lanyard" not in words
    assert "base 4 mm, frame 1 mm, cover 1.5 mm" in words and "6 button-head screws M3 × 10" in words
    assert "0.14 mm of air" in words and right < width - 40


@pytest.mark.slow
def test_a_mount_that_fails_leaves_no_file(ada: Badge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a badge.pdf next to a mount that does not fit it, and a late refusal of what could be known at once."""
    steps: list[str] = []
    thin = replace(ada, lens=replace(ada.lens, thickness_mm=0.2, radius_mm=1.0))
    with pytest.raises(FabricationError, match="too thin for a frame"):
        package.print_badge(thin, tmp_path, figures=mount_figures(["kerf_mm=0.2"]), progress=steps.append)
    assert steps == [] and list(tmp_path.iterdir()) == []
    package.print_badge(thin, tmp_path / "plain", mount="none")

    def broken(*_: Any, **__: Any) -> None:
        raise FabricationError("no room")

    monkeypatch.setattr(stack, "check_stack", broken)
    (tmp_path / "here").mkdir()
    with pytest.raises(FabricationError, match="no room"):
        package.print_badge(ada, tmp_path / "here")
    assert list((tmp_path / "here").iterdir()) == []
    (tmp_path / "here" / "acrylic.svg").write_text("mine")
    with pytest.raises(SpecError, match=r"acrylic\.svg exists already"):
        package.print_badge(ada, tmp_path / "here")


def test_mount_that_is_none_of_ours_is_named(ada: Badge, tmp_path: Path) -> None:
    """Catches: an unknown word taken for a lanyard, or a KeyError."""
    kinds = "lanyard, clip, stand, holder, none"
    with pytest.raises(FabricationError, match=f"mount 'magnet' is not known; choose one of {kinds}"):
        package.print_badge(ada, tmp_path, mount="magnet")


def test_command_line_workshop_and_package_know_the_same_mounts() -> None:
    """Catches: a mount that --mount does not offer, or offers and no one can make (the list is written three times)."""
    option = next(entry for entry in print_command.params if entry.name == "mount")
    assert tuple(option.type.choices) == package.MOUNTS == (*KINDS, "none")
