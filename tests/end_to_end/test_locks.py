"""The lock files, the list of parts, and the check for known holes.  Each test names what it catches."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import platform
import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any

import av
import cv2
import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
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
PARTS = {".": "locks/moireid.cdx.json", "studio": "studio/moireid-studio.cdx.json"}


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


def parts_of(folder: str) -> dict[str, Any]:
    """The list of parts in a distribution's wheel."""
    return dict(json.loads((ROOT / PARTS[folder]).read_text(encoding="utf-8")))


@pytest.mark.parametrize("folder", PARTS)
def test_the_list_of_parts_is_valid_and_of_the_locked_versions(
    folder: str, everything: dict[str, tuple[str, frozenset[str]]]
) -> None:
    """Catches: a list that no reader takes, an old one, one that differs by the clock, one of the developer's tools."""
    parts = parts_of(folder)
    text = json.dumps(parts)
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text.replace('"version"', '"verison"')) is not None
    listed = {canonicalize_name(one["name"]): one["version"] for one in parts["components"]}
    assert listed == {name: everything[name][0] for name in listed}
    assert wanted(folder) <= set(listed) and not DEVELOPMENT & set(listed)
    assert "serialNumber" not in parts and "timestamp" not in parts["metadata"]


@pytest.mark.parametrize("folder", PARTS)
def test_the_list_of_parts_states_who_needs_whom(folder: str) -> None:
    """Catches: a bare list, which does not show through which package a hole comes in; parts without a licence."""
    parts = parts_of(folder)
    needs = {one["ref"]: one.get("dependsOn", []) for one in parts["dependencies"]}
    reached, due = set(), [parts["metadata"]["component"]["bom-ref"]]
    while due:
        one = due.pop()
        if one not in reached:
            reached.add(one)
            due += needs[one]
    assert {one["bom-ref"] for one in parts["components"]} <= reached
    unlicensed = [one["name"] for one in parts["components"] if not one.get("licenses")]
    assert len(unlicensed) < 0.1 * len(parts["components"]), unlicensed


def test_each_part_has_the_hashes_of_the_lock() -> None:
    """Catches: a list by which no one can check what was installed; hashes of another version; a package of a server
    that no list names."""
    digests = locked("locks/requirements.lock")
    listed = set()
    for folder in PARTS:
        for one in parts_of(folder)["components"]:
            name = canonicalize_name(one["name"])
            listed.add(name)
            assert {f"sha256:{given['content']}" for given in one["hashes"]} == digests[name][1] != set(), name
    server = (ROOT / "locks" / "requirements-server.lock").read_text(encoding="utf-8")
    wanted = [Requirement(line.rstrip(" \\")) for line in server.splitlines() if re.match("[a-z]", line)]
    # The lists are of Linux.
    assert {one.name for one in wanted if one.marker is None or one.marker.evaluate(LINUX)} <= listed


@pytest.mark.parametrize("name", ["av", "opencv-contrib-python-headless"])
def test_the_list_names_what_decoders_carry_inside(name: str) -> None:
    """Catches: a list without FFmpeg, which each film goes through, or with that of another wheel or build."""
    (part,) = [one for one in parts_of(".")["components"] if one["name"] == name]
    ffmpeg = next(one for one in part["components"] if one["name"] == "ffmpeg")
    inside = {one["name"]: one["version"] for one in ffmpeg["components"]}
    files = {one["name"]: one["hashes"][0]["content"] for one in part["components"] if one["type"] == "file"}
    assert ffmpeg["cpe"].split(":")[3:6] == ["ffmpeg", "ffmpeg", ffmpeg["version"]]
    if name == "av":
        assert ffmpeg["version"] == av.ffmpeg_version_info
        assert inside == {library: ".".join(map(str, number)) for library, number in av.library_versions.items()}
    else:
        said = cv2.getBuildInformation()
        assert len(inside) == 4 and all(f"{one[3:]}:" in said and f"YES ({inside[one]})" in said for one in inside)
    if sys.platform == "linux" and platform.machine() == "x86_64":
        # Each is the very file that is installed.
        for path in importlib.metadata.files(name) or ():
            if ".libs/" in str(path):
                assert files.pop(path.name) == hashlib.sha256(path.locate().read_bytes()).hexdigest()
        assert not files


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


@pytest.mark.slow
def test_a_known_hole_is_told_with_its_mend(tmp_path: Path, database: str) -> None:
    """Catches: an audit that passes over what the database knows, or finds holes everywhere."""
    found = audit(tmp_path, database, "other==3.0", "thing==1.0")
    assert found.returncode == 1 and "thing 1.0: TEST-1 (fixed in 1.1)" in found.stdout, found.stdout
    clean = audit(tmp_path, database, "other==3.0", "thing==1.1")
    assert clean.returncode == 0 and "no hole in any of the 2 packages" in clean.stdout, clean.stdout


@pytest.mark.slow
def test_an_audit_that_reached_nobody_says_so(tmp_path: Path) -> None:
    """Catches: 'no known holes' where no database was asked."""
    outcome = audit(tmp_path, "http://127.0.0.1:9/", "thing==1.0")
    assert outcome.returncode == 3 and "NOT CHECKED" in outcome.stdout and "no hole" not in outcome.stdout


@pytest.mark.slow
@pytest.mark.parametrize(("ffmpeg", "code"), [("8.1", 1), ("8.2", 0)])
def test_what_wheels_carry_inside_is_asked_for_too(tmp_path: Path, database: str, ffmpeg: str, code: int) -> None:
    """Catches: an audit that knows of packages alone, while FFmpeg inside of one has a hole; silence on what it did not
    ask for."""
    outcome = audit(tmp_path, database, "thing==1.1", ffmpeg=ffmpeg)
    assert outcome.returncode == code, outcome.stdout
    assert (f"known hole (OSV): FFmpeg {ffmpeg} (inside of av): TEST-1" in outcome.stdout) is (code == 1), (
        outcome.stdout
    )
    assert "NOT CHECKED: 1 other libraries inside of wheels, such as av: libx-1.so.2" in outcome.stdout
