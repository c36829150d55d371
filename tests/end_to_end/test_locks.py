"""The lock files, the list of parts, and the check for known holes.  Each test names what it catches."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from kit.places import ROOT

DEVELOPMENT = {"hypothesis", "mkdocs", "mypy", "pip-audit", "playwright", "pytest", "ruff"}


def locked(name: str) -> dict[str, tuple[str, frozenset[str]]]:
    """Each package of a lock file, with its version and its hashes; of several versions that for this Python."""
    found = {}
    for entry in re.split(r"\n(?=[a-z])", (ROOT / name).read_text(encoding="utf-8")):
        if match := re.match(r"([a-z0-9.-]+)==(\S+)", entry):
            marker = Requirement(entry.splitlines()[0].rstrip(" \\")).marker
            if match[1] in found and marker is not None and not marker.evaluate():
                continue
            found[match[1]] = (match[2], frozenset(re.findall(r"--hash=(sha256:\w+)", entry)))
    return found


@pytest.fixture(scope="module")
def everything() -> dict[str, tuple[str, frozenset[str]]]:
    return locked("locks/requirements.lock")


#: The machine of which the lists of parts are.
LINUX = {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix", "platform_machine": "x86_64"}
LINUX |= {"python_version": "3.11", "python_full_version": "3.11.7"}
#: Folders of the distributions, and the list of parts in the wheels of two of them.
DISTRIBUTIONS = (".", "studio", "lab")


def wanted(folder: str, *, development: bool = False) -> set[str]:
    """The packages of others that a pyproject.toml names; development: those of the extras docs and dev too."""
    project = tomllib.loads((ROOT / folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project.get("optional-dependencies", {})
    lists = [project["dependencies"], *(extras[name] for name in extras if development or name not in ("dev", "docs"))]
    return {canonicalize_name(Requirement(line).name) for one in lists for line in one} - {"moireid"}


def test_a_server_gets_what_was_tested_and_no_tools(everything: dict[str, tuple[str, frozenset[str]]]) -> None:
    """Catches: a lock that was renewed alone, so that servers run versions without a test; test tools on a server."""
    server = locked("locks/requirements-server.lock")
    assert {name: everything[name] for name in server} == server
    assert {"fastapi", "psycopg", "c2pa-python", "dlib-bin", "build123d", "numpy"} <= set(server)
    # Workers of a studio are installed from the same lock.
    assert "distributed" in server and "s3fs" not in everything
    assert not (DEVELOPMENT | {"numba", "mitsuba"}) & set(server) and set(everything) >= DEVELOPMENT
    assert all(hashes for _, hashes in everything.values())


def test_the_locks_name_all_that_the_project_asks_for(everything: dict[str, tuple[str, frozenset[str]]]) -> None:
    """Catches: a dependency that was added without `make lock`."""
    for folder in DISTRIBUTIONS:
        assert wanted(folder, development=True) <= set(everything)


class Database(BaseHTTPRequestHandler):
    """A stand-in for the OSV database's server, which knows a hole in thing 1.0, and some in FFmpeg n4.0 and n8.1."""

    def do_POST(self) -> None:
        asked = json.loads(self.rfile.read(int(self.headers["content-length"])))
        hole = {
            "id": "TEST-1",
            "summary": "a hole",
            "affected": [
                {
                    "package": {"name": "thing", "ecosystem": "PyPI"},
                    "ranges": [{"type": "ECOSYSTEM", "events": [{"introduced": "0"}, {"fixed": "1.1"}]}],
                }
            ],
        }
        name, version = asked["package"]["name"], asked["version"]
        known = (name, version) == ("thing", "1.0")
        known |= name.endswith("/FFmpeg.git") and version in ("n4.0", "n8.1")
        answer = json.dumps({"vulns": [hole]} if known else {}).encode()
        self.send_response(200)
        self.send_header("content-length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def database() -> Iterator[str]:
    server = HTTPServer(("127.0.0.1", 0), Database)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


def audit(tmp_path: Path, url: str, *lines: str, ffmpeg: str | None = None) -> subprocess.CompletedProcess[str]:
    """`.ci/audit.py` on a lock of these packages, and a list with that FFmpeg, where nothing is reached but `url`."""
    lock = tmp_path / "some.lock"
    lock.write_text("".join(f"{line} --hash=sha256:{'0' * 64}\n" for line in lines), encoding="utf-8")
    closed = {"HTTPS_PROXY": "http://127.0.0.1:9", "NO_PROXY": "127.0.0.1", "HOME": str(tmp_path)}
    command = [sys.executable, str(ROOT / ".ci" / "audit.py"), str(lock), "--osv-url", url]
    if ffmpeg is not None:
        inside = [{"name": "ffmpeg", "version": ffmpeg}, {"name": "libx-1.so.2"}]
        (tmp_path / "parts.json").write_text(json.dumps({"components": [{"name": "av", "components": inside}]}))
        command += ["--parts", str(tmp_path / "parts.json")]
    return subprocess.run(command, env=closed, capture_output=True, text=True, check=False)
