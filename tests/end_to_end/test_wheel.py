"""The wheel and the source archive, built as for a release.  Each test names the wrong release it catches."""

from __future__ import annotations

import hashlib
import os
import zipfile
from pathlib import Path

import pytest

from kit.places import ROOT
from kit.releasing import build, copy_of_project, tracked_files
from moireid import __version__
from moireid.verifier.kernel.library import NAME

PARTS = "moireid.cdx.json"
#: Settings of machines that must not show in what they build.
HERE = {"TZ": "UTC", "LC_ALL": "C", "PYTHONHASHSEED": "1"}
ELSEWHERE = {"TZ": "Pacific/Auckland", "LC_ALL": "C.UTF-8", "PYTHONHASHSEED": "2", "USER": "someone"}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Source archive and wheel, built under a narrow umask."""
    folder = tmp_path_factory.mktemp("release")
    return build(copy_of_project(folder / "here", 0o600), folder / "dist", umask=0o077, environment=HERE)


def digests(files: list[Path]) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


@pytest.mark.slow
def test_two_machines_build_the_same_bytes(built: list[Path], tmp_path: Path) -> None:
    """Catches: bytes that depend on folder, rights, umask, time zone, language, hashes, or when files were written."""
    source = copy_of_project(tmp_path / "another" / "place", 0o664)
    for name in tracked_files():
        os.utime(source / name, (1_600_000_000, 1_600_000_000))
    again = build(source, tmp_path / "dist", umask=0o002, environment=ELSEWHERE)
    assert digests(again) == digests(built) and len(built) == 2
    document = (built[0].parent / "SHA256SUMS").read_text(encoding="utf-8").split()
    assert (
        digests(built).items() <= dict(zip(document[1::2], document[::2], strict=True)).items() and len(document) == 12
    )


@pytest.mark.slow
def test_the_wheel_holds_the_package_and_nothing_else(built: list[Path]) -> None:
    """Catches: a schema or template that is missing; caches, tests and files of the developer's folder that slip in."""
    package = {name.removeprefix("src/") for name in tracked_files() if name.startswith("src/moireid/")}
    # The kernel is compiled, and its sources are in the source archive.
    package = {name for name in package if not name.endswith((".c", ".h"))}
    package.add(f"moireid/verifier/kernel/{NAME}")
    with zipfile.ZipFile(built[1]) as wheel:
        names = set(wheel.namelist())
        assert {name for name in names if ".dist-info/" not in name} == package
        (parts,) = [name for name in names if "/sboms/" in name]
        assert parts.endswith(f".dist-info/sboms/{PARTS}")
        assert wheel.read(parts) == (ROOT / "locks" / PARTS).read_bytes()
        assert {f"moireid-{__version__}.dist-info/licenses/{name}" for name in ("LICENSE", "THIRD_PARTY.md")} <= names
