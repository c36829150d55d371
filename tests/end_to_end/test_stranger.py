"""The path by which the README begins: from nothing to a shopping list, a page, a mount and a verdict."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from kit.places import ROOT

#: The film is simulated and read twice, and the mount takes the CAD kernel.
pytestmark = pytest.mark.slow

SECTION = "## From the shopping list to a verdict"


def commands() -> list[list[str]]:
    """The commands of the README's section, without what is said of them; the studio is tried by a browser."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    block = re.search(rf"{SECTION}\n\n```console\n(.*?)```", text, re.DOTALL)
    assert block is not None
    return [shlex.split(line, comments=True) for line in block[1].splitlines() if "serve" not in line]


@pytest.mark.claim("The README leads from an empty folder to verdicts")
def test_a_stranger_gets_to_a_verdict_by_the_readme(tmp_path: Path) -> None:
    """Catches: a command of the README that fails in a fresh folder; a true film that is not accepted."""
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
    identity = json.loads((desk / "ada" / "badge.json").read_text())["id"]
    assert said["verify"].startswith("ACCEPT: Genuine, and Ada Lovelace's") and identity in said["enroll"]
    assert said["identify"].startswith("FOUND: Genuine, and Ada Lovelace's")
