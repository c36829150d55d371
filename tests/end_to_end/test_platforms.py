"""The kernel built for other machines than this one.  Each test names what it would catch."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from kit.releasing import copy_of_project

#: What the platforms' libraries begin with.
MAGIC = {
    "manylinux_2_17_x86_64": b"\x7fELF\x02",
    "manylinux_2_17_aarch64": b"\x7fELF\x02",
    "macosx_11_0_x86_64": b"\xcf\xfa\xed\xfe\x07",
    "macosx_11_0_arm64": b"\xcf\xfa\xed\xfe\x0c",
    "win_amd64": b"MZ",
    "win_arm64": b"MZ",
}


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_of_project(tmp_path_factory.mktemp("platforms") / "source", 0o644)


def run_hook(source: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a module of Python where no program of the system is found, so no compiler of it either."""
    command, plain = [sys.executable, *arguments], {"PATH": "", "HOME": str(source), **environment}
    return subprocess.run(command, cwd=source, env=plain, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_this_machine_makes_the_wheels_of_all_platforms(source: Path, tmp_path: Path):
    """Catches: a target that does not compile, needs a compiler of the system, or whose wheel has another's library."""
    done = run_hook(source, "hatch_build.py", str(tmp_path))
    assert done.returncode == 0, done.stderr
    wheels = {file.name.removesuffix(".whl").split("py3-none-")[1]: file for file in tmp_path.glob("*.whl")}
    assert wheels.keys() == MAGIC.keys()
    for tag, file in wheels.items():
        with zipfile.ZipFile(file) as wheel:
            (library,) = [name for name in wheel.namelist() if "/_kernel." in name]
            assert wheel.read(library).startswith(MAGIC[tag])
            (facts,) = [name for name in wheel.namelist() if name.endswith(".dist-info/WHEEL")]
            assert f"Tag: py3-none-{tag}" in wheel.read(facts).decode()


def test_an_unknown_platform_is_one_sentence(source: Path):
    """Catches: a traceback, or a wheel of this machine under another name."""
    done = run_hook(source, "-m", "hatchling", "build", "--target", "wheel", MOIREID_PLATFORM="vax")
    assert done.returncode != 0 and done.stderr.strip().splitlines()[-1].startswith(
        "error: MOIREID_PLATFORM=vax is none of manylinux_2_17_x86_64,"
    )


@pytest.mark.slow
def test_a_kernel_that_does_not_compile_is_one_sentence_and_leaves_no_file(source: Path, tmp_path: Path):
    """Catches: half a library; the compiler's message lost."""
    broken = copy_of_project(tmp_path / "broken", 0o644)
    (broken / "src/moireid/verifier/kernel/rows.c").write_text("int broken(")
    done = run_hook(broken, "hatch_build.py", str(tmp_path / "out"))
    assert done.returncode != 0 and "error: the kernel does not compile for " in done.stderr
    assert os.listdir(tmp_path / "out") == []
