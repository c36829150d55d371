"""The project as a release sees it: its tracked files in another folder, and what is built of them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from kit.places import ROOT


def tracked_files() -> list[str]:
    """The paths of the files that git keeps."""
    output = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [name for name in output.stdout.split("\0") if name and (ROOT / name).is_file()]


def copy_of_project(folder: Path, mode: int) -> Path:
    """The tracked files in `folder`, each with these rights; not a checkout of git."""
    for name in tracked_files():
        there = folder / name
        there.parent.mkdir(parents=True, exist_ok=True)
        there.write_bytes((ROOT / name).read_bytes())
        there.chmod(mode)
    return folder


def build(source: Path, out: Path, *, umask: int = 0o022, environment: Mapping[str, str] | None = None) -> list[Path]:
    """Run `.ci/build` of the project in `source`; the source archive and the wheel of the package `moireid`."""
    subprocess.run(
        ["bash", str(source / ".ci" / "build"), str(out)],
        env={**os.environ, "PYTHON": sys.executable, **(environment or {})},
        umask=umask,
        check=True,
        capture_output=True,
    )
    return [*out.glob("moireid-*.tar.gz"), *out.glob("moireid-*.whl")]
