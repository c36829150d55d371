"""Mounts at their extremes: each is right, made in part with the reason stated, or refused with what would work.

Figures in a refusal are read out of its sentence and tried, since advice that does not work is worse than none.
"""

from __future__ import annotations

import math
import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np
import pytest
import trimesh

from kit.mounting import box, framed, sight_volume
from moireid.badge import Badge, Lens
from moireid.cli.printing.print_options import mount_figure
from moireid.designer import Order, design_badge
from moireid.errors import FabricationError, MoireIdError
from moireid.fabrication.mount_parts import Parts, plan_parts
from moireid.fabrication.printed.mount import write_mount
from moireid.fabrication.process_figures import MountFigures, MountProcess, mount_figures
from moireid.profiles import LensProfile, lens_named, save_profile

KINDS = ("lanyard", "clip", "stand")
#: Boards by their size, with a range that suits it, a small one being filmed from near.
BOARDS = {(30.0, 30.0): (0.3, 0.5), (30.0, 40.0): (0.3, 0.5), (60.0, 66.0): (0.5, 0.7)}
BOARDS |= dict.fromkeys([(146.0, 160.0), (180.0, 267.0), (300.0, 300.0)], Order.range_m)
#: The smallest board has room for two letters.  A thin sheet has narrow lenses: it needs a fine printer, a near camera.
PLAIN = Order("Ex", lens="50lpi")
FINE = replace(PLAIN, printer_dpi=4800, range_m=(0.4, 1.2))
#: A lens that is as thick as its focal length is at most 0.72 of that wide, at the refractive index of 1.56.
THIN_PITCH_SHARE = 0.7


@dataclass(frozen=True)
class Extreme:
    """A wish for a badge, the lens sheet's thickness where it is no label's, and figures of mounts."""

    request: Order
    lens_mm: float | None = None
    figures: tuple[str, ...] = ()

    def planned(self, kind: str) -> Parts:
        """What is made of a mount.  Raises: MoireIdError where it is refused."""
        with tempfile.TemporaryDirectory() as folder:
            request = self.request
            if self.lens_mm is not None:
                path, nominal = Path(folder) / "sheet.json", lens_named(request.lens)
                pitch_mm = min(nominal.pitch_mm, THIN_PITCH_SHARE * self.lens_mm)
                lens = Lens("lenticular", pitch_mm, self.lens_mm, nominal.refractive_index)
                save_profile(LensProfile("sheet", lens, 1e-4), path)
                request = replace(request, lens=str(path))
            return plan_parts(
                design_badge(request, bytes(range(8))), kind, mount_figures(dict(map(mount_figure, self.figures)))
            )

    def outcome(self, kind: str = "lanyard") -> tuple[str, str]:
        """Which mounts are made, and why not both."""
        try:
            parts = self.planned(kind)
        except MoireIdError as error:
            return "refused", str(error)
        made = "whole" if not parts.left_out else "printed" if parts.printed != "none" else "acrylic"
        return made, "; ".join(parts.left_out.values())


CASES = {
    f"board {size[0]:g}x{size[1]:g} mm, {front}": Extreme(replace(PLAIN, front=front, size_mm=size, range_m=range_m))
    for size, range_m in BOARDS.items()
    for front in ("lens", "mask")
}
CASES |= {f"kerf {kerf:g} mm": Extreme(PLAIN, figures=(f"kerf_mm={kerf:g}",)) for kerf in (0.0, 1.0, 5.0)}
CASES |= {f"sheet {mm:g} mm": Extreme(PLAIN if mm > 1 else FINE, mm) for mm in (0.2, 0.3, 2.5, 4.0, 6.0)}
CASES |= {
    f"spacer {gap:g} mm": Extreme(replace(PLAIN, front="mask", lens_thickness_mm=gap)) for gap in (0.2, 0.5, 3.0, 6.0)
}
#: What becomes of each extreme, with every mount; the rest is made whole.
REFUSED = ("board 30x30 mm", "board 300x300 mm", "kerf 5 mm", "spacer 0.2 mm")
PRINTED_ALONE = ("board 30x40 mm", "sheet 0.2 mm", "sheet 0.3 mm", "sheet 6 mm", "spacer 6 mm")


@pytest.mark.slow
def test_every_extreme_is_whole_or_says_why_not() -> None:
    """Catches: a mount refused for the other's sake, a refusal without a reason."""
    for name, case in CASES.items():
        for kind in KINDS:
            wanted = "refused" if name.startswith(REFUSED) else "whole"
            wanted = "printed" if wanted == "whole" and name.startswith(PRINTED_ALONE) else wanted
            made, why = case.outcome(kind)
            assert made == wanted and bool(why) == (wanted != "whole"), (name, kind, made, why)


def numbers(pattern: str, text: str) -> list[float]:
    found = re.search(pattern, text)
    assert found, text
    return [float(group) for group in found.groups()]


@pytest.mark.slow
def test_what_the_refusals_advise_does_work() -> None:
    """Catches: advice copied from another refusal, a limit rounded to the wrong side, a bound that is not the bound."""

    def why(name: str) -> str:
        return CASES[name].outcome()[1]

    def whole(name: str, **wish: Any) -> bool:
        own = {key: wish.pop(key) for key in ("lens_mm", "figures") if key in wish}
        return replace(CASES[name], request=replace(CASES[name].request, **wish), **own).outcome("clip")[0] == "whole"

    tall = "board 30x40 mm, lens"
    (height,) = numbers(r"board \(size_mm\) of ([\d.]+) mm or more in height, wider in proportion", why(tall))
    assert whole(tall, size_mm=(30.0 / 40.0 * height, height))
    for name, pattern in (
        ("sheet 0.2 mm", r"sheet \(lens[a-z_]*\) of ([\d.]+) mm or more"),
        ("sheet 6 mm", r"\) of ([\d.]+) mm or less"),
    ):
        assert whole(name, lens_mm=numbers(pattern, why(name))[0])
    assert not whole("sheet 6 mm", lens_mm=5.1)
    assert whole("spacer 6 mm", lens_thickness_mm=numbers(r"\) of ([\d.]+) mm or less", why("spacer 6 mm"))[0])
    for name in ("board 30x30 mm, lens", "board 300x300 mm, lens"):
        size = numbers(r"at (?:least|most) ([\d.]+) ?x ?([\d.]+)", why(name))
        assert whole(name, size_mm=(size[0], size[1]))
    (kerf,) = numbers(r"0 to ([\d.]+)", why("kerf 5 mm"))
    assert whole("kerf 5 mm", figures=(f"kerf_mm={kerf:g}",))


# A thick sheet's tray, constructed here from the badge's page coordinates alone.


@pytest.fixture(scope="module")
def thick() -> Badge:
    """A default badge under a sheet of 6 mm."""
    badge = design_badge(Order("Thick", lens="50lpi"), bytes(8))
    return replace(badge, lens=replace(badge.lens, thickness_mm=6.0, radius_mm=3.0))


@pytest.fixture(scope="module")
def tray(thick: Badge, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Its tray as a slicer sees it."""
    mesh = trimesh.load_mesh(write_mount(thick, tmp_path_factory.mktemp("thick")).stls[0])
    return manifold3d.Manifold(manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)))


@pytest.mark.slow
def test_thick_sheet_is_held_and_hides_nothing(thick: Badge, tray: Any) -> None:
    """Catches: a rim as high as the sheet next to the markers, lips that reach down to them, a sheet that falls out."""
    half = thick.markers.size_mm / 2
    for x, y in thick.markers.centers_mm:
        rect = framed((x - half, y - half, x + half, y + half), thick)
        # Sight lines up to 8 mm above the card, which is higher than the lips.
        spread = 8.0 * math.tan(math.radians(45))
        x0, y0, x1, y1 = rect
        lower = [(u, v, 0.3) for u in (x0, x1) for v in (y0, y1)]
        turns = [math.tau * k / 32 for k in range(32)]
        ways = [(spread * math.cos(turn), spread * math.sin(turn)) for turn in turns]
        upper = [(u + dx, v + dy, 8.3) for u in (x0, x1) for v in (y0, y1) for dx, dy in ways]
        view = manifold3d.Manifold.hull_points(lower + upper)
        for dx, dy in ((0.29, 0.0), (-0.29, 0.0), (0.0, -0.29)):
            assert (view.translate((dx, dy, 0.0)) ^ tray).volume() < 1e-6
    rows = framed(thick.gratings[0].rect_mm, thick)
    fringes = sight_volume(rows, 6.3, 60, up_and_down=False)
    assert (fringes ^ tray).volume() < 1e-6
    sheet = box((-73.0, rows[1], 73.0, rows[3]), 0.3, 6.3)
    # The springs' pads are bent back in use.
    free = tray - box((-73.0, -80.0, 73.0, 80.0), 0.0, 0.36)
    for shift in ((0.29, 0, 0), (0, -0.29, 0), (0, 0, 0.09)):
        assert (sheet.translate(shift) ^ free).volume() < 0.01
    # It is stopped left, right, below and in front.
    for shift in ((0.4, 0, 0), (-0.05, 0, 0), (0, -0.4, 0), (0, 0, 0.3)):
        assert (sheet.translate(shift) ^ tray).volume() > 0.1
    sliding = box((-73.0, rows[1], 73.0, rows[3]), 0.3, 6.3, up=250.0)
    assert (sliding ^ free).volume() < 0.01


@pytest.mark.slow
def test_springs_stay_below_the_lips_that_were_drawn_back(thick: Badge, tray: Any) -> None:
    """Catches: a spring where there is no lip any more, which would bow the sheet."""
    floor = tray ^ box((-72.9, -79.9, 72.9, 79.9), 0.01, 0.29)
    lips = tray ^ box((-74.9, -79.9, 74.9, 79.9), 6.45, 6.55)
    pads, held = (sorted((p.bounding_box() for p in solid.decompose()), key=lambda b: b[1]) for solid in (floor, lips))
    assert len(pads) == 4 and len(held) == 2
    for pad in pads:
        assert any(lip[1] <= pad[1] and pad[4] <= lip[4] and lip[0] * pad[0] > 0 for lip in held)


# Figures by name.


@pytest.mark.slow
def test_figures_are_set_by_the_names_that_messages_give() -> None:
    """Catches: a figure that goes to the wrong workshop, a shared one that goes to one, insistence on what was not
    asked for."""
    assert mount_figures({}) == MountFigures()
    both = mount_figures({"card_mm": 0.5})
    assert both.printed.card_mm == both.acrylic.card_mm == 0.5 and not both.insisted
    one = mount_figures({"acrylic.clearance_mm": 0.1, "slot_mm": (20, 5), "wall_mm": 3})
    assert (one.acrylic.clearance_mm, one.printed) == (0.1, MountProcess(slot_mm=(20.0, 5.0), wall_mm=3.0))
    assert one.insisted == {"printed", "acrylic"} and mount_figures({"kerf_mm": 0}).insisted == {"acrylic"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("kerf=0.2", "is not known; give NAME=MM with one of .*kerf_mm"),
        ("wall_mm", "is not understood; give NAME=MM"),
        ("slot_mm=16", "slot_mm=16.0 is not possible; give"),
        ("kerf_mm=1e9", "is not possible; give 0 to 1"),
        ("wall_mm=nan", "wall_mm=nan is not possible"),
        ("wall_mm=0.9", "wall_mm=0.9 is not possible; give 1 to 6"),
        ("slot_mm=16x20", "is no slot for a strap; give more width than height"),
        ("printed.lip_reach_mm=0.6", "lip_reach_mm=0.6 holds no sheet that lies 0.3 mm to the side; give 0.7 mm"),
        ("acrylic.clearance_mm=0.5", "give a clearance_mm of 0.149 or less"),
        ("printed.lip_mm=4.5", "take a smaller lip_reach_mm or lip_mm"),
    ],
)
def test_figures_that_cannot_be_are_named(pair: str, words: str, ada: Badge) -> None:
    """Catches: a traceback, a figure that is taken in silence, one that makes a useless mount."""
    with pytest.raises(MoireIdError, match=words):
        plan_parts(ada, "clip", mount_figures(dict([mount_figure(pair)])))


@pytest.mark.slow
def test_a_figure_of_its_own_is_an_order(ada: Badge) -> None:
    """Catches: an acrylic stack left out although its kerf was given, a printed mount that goes with it, and a
    refusal that keeps one reason to itself."""
    thin = replace(ada, lens=replace(ada.lens, thickness_mm=0.2, radius_mm=1.0))
    assert plan_parts(thin, "clip").files == ("mount.step", "mount.stl", "mount-clip.stl", "mount.3mf", "mount.glb")
    with pytest.raises(FabricationError, match="too thin for a frame"):
        plan_parts(thin, "clip", mount_figures({"kerf_mm": 0.1}))
    # A hook needs a slot of 3 mm: the printed clip is left out, the stack is made.
    slotted = replace(MountFigures(), printed=MountProcess(slot_mm=(16.0, 2.0)))
    parts = plan_parts(ada, "clip", slotted)
    assert parts.printed == "none" and not any(name.endswith((".stl", ".3mf")) for name in parts.files)
    assert "slot_mm of 8x3" in parts.left_out["printed"]
    with pytest.raises(FabricationError, match="slot_mm of 8x3"):
        plan_parts(ada, "clip", mount_figures({"slot_mm": (16, 2)}))
    with pytest.raises(FabricationError, match=r"no mount can be made: printed, .* hook.*; in acrylic, .* too thin"):
        plan_parts(thin, "clip", slotted)


@pytest.mark.slow
@pytest.mark.parametrize("figure", ["wall_mm=1", "printed.lip_reach_mm=0.7"])
def test_least_figures_make_sound_solids(figure: str, tmp_path: Path) -> None:
    """Catches: a chamfer that eats the corners of a thin wall, a spring that has no room below a short lip."""
    badge = design_badge(Order("Fine", lens="50lpi", size_mm=(60.0, 66.0), range_m=(0.5, 0.7)), bytes(8))
    report = write_mount(badge, tmp_path, process=mount_figures(dict([mount_figure(figure)])).printed)
    assert trimesh.load_mesh(report.stls[0]).is_watertight
