"""The wheels, installed by `uv tool install` in an empty place: moireid alone, and with each extra and distribution.

An installation has the versions of the lock file; where MOIREID_NEWEST is set, as `make release` does, the newest that
the wheel allows.  Each test names what it catches.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from kit.places import FILMS, ROOT
from kit.releasing import build, copy_of_project
from kit.signing import certified_key

UV = Path(sys.executable).with_name("uv")
FILM, BADGE = str(FILMS / "genuine_1.0m.mp4"), str(FILMS / "badge.json")
#: What needs each extra or distribution, as a user would type it.  `ready` makes the files that they want.
NEEDS = {
    "c2pa": f"verify film.mp4 --badge {BADGE} --sign key.pem --c2pa sidecar",
    "cad": "print Ada --out mounted",
    "face": f"verify {FILM} --badge {BADGE} --overlap",
    "postgres": "registry list --registry postgresql://nobody@127.0.0.1:9/none",
    "simulate": "simulate plain/badge.json --out film.mp4 --frames 3",
    "moireid-lab": "lab evaluate films.csv --out scores",
    "moireid-studio": "serve --no-auth --port 0",
}


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


@pytest.mark.slow
@pytest.mark.parametrize("extra", NEEDS)
def test_what_lacks_its_extra_says_how_to_get_it_and_then_works(extra: str, place: Place) -> None:
    """Catches: a traceback, a sentence whose command does not work, an extra that is not whole by itself."""
    ready(place, extra)
    lacking = place.run(f"moireid {NEEDS[extra]}")
    assert lacking.returncode == 2 and lacking.stdout == "", lacking.stderr
    sentence = re.fullmatch(r"error: .+ needs [\w-]+, which is not installed; install it with: (.+)\n", lacking.stderr)
    assert sentence, lacking.stderr
    installed = place.run(sentence[1])
    named = extra if extra.startswith("moireid-") else f"[{extra}]"
    assert installed.returncode == 0 and named in sentence[1], installed.stderr
    if extra == "moireid-studio":
        assert_studio_answers(place)
        return
    done = place.run(f"moireid {NEEDS[extra]}")
    if extra == "postgres":
        assert done.returncode == 2 and "127.0.0.1" in done.stderr and "install" not in done.stderr, done.stderr
    else:
        assert done.returncode in ((0, 3) if extra == "face" else (0,)), done.stderr


@pytest.mark.slow
def test_a_second_extra_keeps_the_first(place: Place) -> None:
    """Catches: advice that installs the asked one, and takes away what was there."""
    first = place.run("moireid serve --no-auth").stderr.split("with: ")[1]
    assert place.run(first).returncode == 0
    second = place.run(f"moireid {NEEDS['face']}").stderr.split("with: ")[1]
    assert "[face]" in second and "--with" in second and place.run(second).returncode == 0
    assert_studio_answers(place)


@pytest.mark.slow
def test_the_servers_lock_serves(wheel: Path, tmp_path: Path) -> None:
    """Catches: a server's lock that lacks what the studio needs, or whose hashes do not hold."""
    place = Place(tmp_path)
    (tmp_path / "uv").mkdir()
    (tmp_path / "uv" / "uv").symlink_to(UV)
    both = [str(wheel), *map(str, wheel.parent.glob("moireid_studio-*.whl"))]
    for line in (
        "uv venv --quiet served",
        f"uv pip install --python served/bin/python --require-hashes -r {ROOT / 'locks' / 'requirements-server.lock'}",
        f"uv pip install --python served/bin/python --no-deps {' '.join(map(shlex.quote, both))}",
    ):
        done = place.run(line)
        assert done.returncode == 0, done.stderr
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "moireid").symlink_to(tmp_path / "served" / "bin" / "moireid")
    assert_studio_answers(place)
    assert place.run("moireid print Ada --out mounted").returncode == 0


def ready(place: Place, extra: str) -> None:
    """The files that the command of this extra wants."""
    if extra == "simulate":
        assert place.run("moireid print Ada --out plain --mount none").returncode == 0
    elif extra == "moireid-lab":
        (place.folder / "films.csv").write_text(
            f"video,label,claim,group\n{FILM},genuine,{BADGE},one\n", encoding="utf-8"
        )
    elif extra == "c2pa":
        shutil.copy(FILM, place.folder / "film.mp4")
        certified_key(place.folder / "key.pem", "p256")


def assert_studio_answers(place: Place) -> None:
    """The studio starts, and shows its first page."""
    command = [str(place.folder / "bin" / "moireid"), "serve", "--no-auth", "--port", "0"]
    with subprocess.Popen(
        command, cwd=place.folder, env=place.environment(), stderr=subprocess.PIPE, text=True
    ) as server:
        assert server.stderr is not None
        said = server.stderr.readline()
        assert "the studio is at http://" in said, said
        assert httpx.get(said.split()[4], timeout=100).status_code == 200
        server.send_signal(signal.SIGINT)
        assert server.wait(60) == 0
