"""The path by which the README begins: from nothing to a shopping list, a page, a mount put together and a verdict."""

from __future__ import annotations

import csv
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from kit.places import ROOT
from kit.programs import needs

#: The film is simulated and read twice, and the mount takes the CAD kernel.
pytestmark = pytest.mark.slow

SECTION = "## From the shopping list to a verdict"


def commands() -> list[list[str]]:
    """The commands of the README's section, without what is said of them; the studio is tried by a browser."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = re.search(rf"{SECTION}\n\n```console\n(.*?)```", text, re.DOTALL)
    assert block is not None
    return [shlex.split(line, comments=True) for line in block[1].splitlines() if "serve" not in line]


def pages(path: Path, folder: Path) -> list[np.ndarray]:
    """The pages of a PDF as poppler paints them, grey."""
    subprocess.run([needs("pdftoppm"), "-r", "50", "-gray", "-png", path, folder / path.stem], check=True)
    return [np.asarray(Image.open(one)) for one in sorted(folder.glob(f"{path.stem}-*.png"))]


@pytest.mark.claim("The README leads from an empty folder to verdicts")
def test_a_stranger_gets_to_a_verdict_by_the_readme(tmp_path: Path) -> None:
    """Catches: a command of the README that fails in a fresh folder, or whose output no reader opens; an empty page; a
    mount without its parts; a true film that is not accepted."""
    listed = commands()
    own = {"HOME": tmp_path / "home", "XDG_DATA_HOME": tmp_path / "data", "XDG_CONFIG_HOME": tmp_path / "config"}
    gone = {"MOIREID_REGISTRY", "MOIREID_KEYS", "MOIREID_SEEN"}
    environment = {key: value for key, value in os.environ.items() if key not in gone} | {
        **{key: str(folder) for key, folder in own.items()},
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    }
    desk = tmp_path / "desk"
    desk.mkdir()
    said = {}
    for command in listed:
        name = command[0] if command[0] != "moireid" else command[1]
        # One identity, so that each run is alike.
        command += ["--payload", "0123456789abcdef"] if name == "print-your-badge" else []
        done = subprocess.run(command, cwd=desk, env=environment, capture_output=True, text=True, timeout=500)
        assert done.returncode == 0, (command, done.stderr)
        said[name] = done.stdout
    looked = tmp_path / "looked"
    looked.mkdir()

    shopping = desk / "shopping"
    rows = list(csv.DictReader((shopping / "shopping-list.csv").open(encoding="utf-8-sig")))
    amounts = {row["key"]: row["quantity"] for row in rows}
    assert float(amounts["lens-sheet"]) >= 10 and {"paper", "filament", "lanyard"} <= amounts.keys()

    for path, least in [
        (shopping / "cutting-plan.pdf", 1),
        (desk / "ada" / "badge.pdf", 1),
        (desk / "ada" / "assembly.pdf", 2),
    ]:
        painted = pages(path, looked)
        assert len(painted) >= least and all((page < 128).mean() > 0.003 for page in painted), path
    assert (pages(desk / "ada" / "badge.pdf", looked)[0] < 128).mean() > 0.05

    scene = trimesh.load(desk / "ada" / "mount.glb", force="scene")
    parts = set(scene.geometry)
    assert {"printed-tray", "printed-page", "printed-sheet-0", "acrylic-base", "acrylic-cover"} <= parts
    # Metres: an A6 badge in its mount, and the stack next to it.
    assert 0.3 < scene.extents[0] < 0.5 and all(one.is_watertight for name, one in closed(scene).items()), parts

    identity = json.loads((desk / "ada" / "badge.json").read_text())["id"]
    assert said["verify"].startswith("ACCEPT: Genuine, and Ada Lovelace's") and identity in said["enroll"]
    assert said["identify"].startswith("FOUND: Genuine, and Ada Lovelace's")


def closed(scene: trimesh.Scene) -> dict[str, trimesh.Trimesh]:
    """The bodies of a scene; what is printed on the page is a surface."""
    bodies = {name: one.copy() for name, one in scene.geometry.items() if not name.endswith("-print")}
    for one in bodies.values():
        one.merge_vertices(merge_tex=True, merge_norm=True)
    return bodies
