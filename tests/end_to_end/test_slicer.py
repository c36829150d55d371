"""Every mount through a stock slicer, which must find nothing to repair.

PrusaSlicer shares no code with the packages that wrote and checked the files.
"""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from kit.programs import needs
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.fabrication.printed.mount import KINDS, MountReport, write_mount

#: A mount takes seconds to build and seconds to slice.
pytestmark = pytest.mark.slow

#: What `--info` tells only of a mesh that it had to repair.
MENDED = ("open_edges", "facets_removed", "facets_reversed", "backwards_edges", "degenerate", "edges_fixed", "repaired")
#: Extruded plastic over the solid's volume: three tenths with walls and a sparse core, more with skirt and support.
LEAST_SHARE, MOST_SHARE = 0.25, 1.3


@pytest.fixture(scope="module")
def slicer() -> str:
    """The slicer's path."""
    return needs("prusa-slicer")


@pytest.fixture(scope="module")
def badges() -> dict[str, Badge]:
    """A badge with a lens sheet, and one with a mask whose rim has steps."""
    plain = Order("Slice", lens="50lpi", size_mm=(100.0, 120.0), range_m=(0.5, 0.9))
    mask = Order("Slice", lens="50lpi", front="mask", lens_thickness_mm=3.0, size_mm=(100.0, 120.0), range_m=(0.5, 0.9))
    return {"lens": design_badge(plain, bytes(8)), "mask": design_badge(mask, bytes(8))}


def made(badge: Badge, kind: str, folder: Path) -> MountReport:
    return write_mount(badge, folder, kind=kind)


def sliced(slicer: str, *arguments: str, home: Path) -> str:
    """What the slicer says; its settings are those of a new user."""
    # The slicer keeps its settings below the home folder, and would read another user's there.
    environment = os.environ | {"HOME": str(home), "XDG_CONFIG_HOME": str(home), "LC_ALL": "C"}
    environment.pop("DISPLAY", None)
    done = subprocess.run(
        [slicer, *arguments], capture_output=True, text=True, timeout=120, env=environment, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.parametrize(("kind", "front"), [*((kind, "lens") for kind in KINDS), ("stand", "mask")])
def test_a_stock_slicer_finds_nothing_to_repair(
    kind: str, front: str, slicer: str, badges: dict[str, Badge], tmp_path: Path
) -> None:
    """Catches: a mesh with holes, turned or flat facets, bodies that a slicer merges, another unit, an empty layer."""
    report = made(badges[front], kind, tmp_path)
    volumes = [body.volume_mm3 for body in report.bodies]
    assert len(report.stls) == len(volumes) == (1 if kind == "lanyard" else 2)
    # An STL is a part, a 3MF has an object for each.
    for path, parts in (
        *((stl, [volume]) for stl, volume in zip(report.stls, volumes, strict=True)),
        (tmp_path / "mount.3mf", volumes),
    ):
        output = sliced(slicer, "--info", str(path), home=tmp_path)
        assert re.findall(r"^manifold = (\w+)$", output, re.MULTILINE) == ["yes"] * len(parts), output
        assert sum(map(int, re.findall(r"number_of_parts = +(\d+)", output))) == len(parts), output
        assert not [word for word in MENDED if word in output], output
        volume = sum(map(float, re.findall(r"^volume = ([\d.]+)$", output, re.MULTILINE)))
        assert volume == pytest.approx(sum(parts), rel=0.005)
        gcode = path.with_suffix(".gcode")
        output = sliced(slicer, "--export-gcode", "--output", str(gcode), str(path), home=tmp_path)
        assert not re.search(r"repair|empty layer|error|outside", output, re.IGNORECASE), output
        used = re.search(r"filament used \[mm\] = ([\d.]+)", gcode.read_text())
        assert used is not None
        # Stock filament is 1.75 mm thick.
        share = float(used.group(1)) * 3.14159 * 0.875**2 / sum(parts)
        assert LEAST_SHARE < share < MOST_SHARE, share
