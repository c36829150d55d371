"""The wheels, installed by `uv tool install` in an empty place: moireid alone, and with each extra and distribution.

An installation has the versions of the lock file; where MOIREID_NEWEST is set, as `make release` does, the newest that
the wheel allows.  Each test names what it catches.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from kit.places import FILMS, ROOT
from kit.releasing import build, copy_of_project

UV = Path(sys.executable).with_name("uv")
FILM, BADGE = str(FILMS / "genuine_1.0m.mp4"), str(FILMS / "badge.json")


@dataclass(frozen=True)
class Place:
    """An empty home with nothing but uv; PATH has what the system has, and none of the developer's environment."""

    folder: Path

    def environment(self) -> dict[str, str]:
        cache = subprocess.run([UV, "cache", "dir"], capture_output=True, text=True, check=True).stdout.strip()
        passed = {name: word for name, word in os.environ.items() if name.startswith(("SSL_", "PIP_", "LC_", "LANG"))}
        locked = {} if "MOIREID_NEWEST" in os.environ else {"UV_CONSTRAINT": str(ROOT / "locks" / "requirements.lock")}
        tools, programs = self.folder / "tools", self.folder / "bin"
        own = {"HOME": str(self.folder), "UV_CACHE_DIR": cache, "UV_PYTHON": sys.executable}
        own |= {"UV_TOOL_DIR": str(tools), "UV_TOOL_BIN_DIR": str(programs), "UV_PYTHON_DOWNLOADS": "never"}
        return passed | locked | own | {"PATH": f"{programs}:{self.folder / 'uv'}:/usr/bin:/bin"}

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        """Run a line as a user types it."""
        return subprocess.run(
            shlex.split(command),
            cwd=self.folder,
            env=self.environment(),
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
            executable=shutil.which(shlex.split(command)[0], path=self.environment()["PATH"]),
        )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("built with a space")
    return build(copy_of_project(folder / "source", 0o644), folder / "dist")[1]


@pytest.fixture
def place(wheel: Path, tmp_path: Path) -> Place:
    """A place in which the wheel alone is installed, with the files that the commands want."""
    (tmp_path / "uv").mkdir()
    (tmp_path / "uv" / "uv").symlink_to(UV)
    found = Place(tmp_path)
    done = found.run(f"uv tool install {shlex.quote(str(wheel))}")
    assert done.returncode == 0, done.stderr
    return found


@pytest.mark.slow
def test_the_wheel_alone_prints_enrolls_and_verifies(place: Place) -> None:
    """Catches: a package that the core needs and only an extra names; a help that loads one."""
    helped = place.run("moireid --help")
    assert helped.returncode == 0 and "verify" in helped.stdout, helped.stderr
    verified = place.run(f"moireid verify {FILM} --badge {BADGE}")
    assert verified.returncode == 0, verified.stderr
    printed = place.run("print-your-badge Ada --out ada --mount none --registry sqlite:///people.sqlite3")
    assert printed.returncode == 0 and (place.folder / "ada" / "badge.pdf").is_file(), printed.stderr
    assert place.run("moireid enroll ada/badge.json --registry sqlite:///people.sqlite3").returncode == 0
    assert place.run("moireid registry audit --registry sqlite:///people.sqlite3").returncode == 0
