"""The lock files.  Each test names what it catches."""

from __future__ import annotations

import json
import re
import tomllib

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


@pytest.mark.parametrize("parts", ["locks/moireid.cdx.json", "studio/moireid-studio.cdx.json"])
def test_every_part_has_a_licence(parts: str) -> None:
    """Catches: a package whose metadata names none, or the encoders under the GPL in PyAV's wheel without theirs."""
    listed = json.loads((ROOT / parts).read_text(encoding="utf-8"))["components"]
    assert [part["name"] for part in listed if not part.get("licenses")] == []
    inside = {one["name"].partition("-")[0]: one for part in listed for one in part.get("components", ())}
    for name in {"libx264", "libx265"} & inside.keys():
        assert inside[name]["licenses"][0]["license"]["id"] == "GPL-2.0-or-later"
