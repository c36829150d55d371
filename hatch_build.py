"""Build hook: compile the kernel of the verifier, for this machine or for the platform of a wheel.

The compiler is the one that the package `ziglang` carries, so none of the system is needed.  It also compiles for other
platforms: MOIREID_PLATFORM names one of `TARGETS`.  Called as a program, with a folder, it makes the wheels of all
platforms there.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNEL = Path(__file__).parent / "src" / "moireid" / "verifier" / "kernel"
#: Tag of the wheel: the compiler's name of the platform, and the library's file.
TARGETS = {
    "manylinux_2_17_x86_64": ("x86_64-linux-gnu.2.17", "_kernel.so"),
    "manylinux_2_17_aarch64": ("aarch64-linux-gnu.2.17", "_kernel.so"),
    "macosx_11_0_x86_64": ("x86_64-macos.11.0", "_kernel.dylib"),
    "macosx_11_0_arm64": ("aarch64-macos.11.0", "_kernel.dylib"),
    "win_amd64": ("x86_64-windows-gnu", "_kernel.dll"),
    "win_arm64": ("aarch64-windows-gnu", "_kernel.dll"),
}
FLAGS = (
    "-O3",
    "-std=c11",
    "-ffreestanding",
    "-fno-math-errno",
    "-fvisibility=hidden",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-s",
    "-nostdlib",
)


def this_platform() -> str:
    """The tag of this machine.

    Raises: SystemExit where no target fits.
    """
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    tags = {
        ("linux", "x86_64"): "manylinux_2_17_x86_64",
        ("linux", "aarch64"): "manylinux_2_17_aarch64",
        ("darwin", "x86_64"): "macosx_11_0_x86_64",
        ("darwin", "aarch64"): "macosx_11_0_arm64",
        ("win32", "x86_64"): "win_amd64",
        ("win32", "aarch64"): "win_arm64",
    }
    if (sys.platform, machine) not in tags:
        raise SystemExit(f"error: no kernel is built for {sys.platform} on {machine}; add a target to hatch_build.py")
    return tags[sys.platform, machine]


def compile_kernel(target: str, name: str, out: Path) -> Path:
    """Compile the kernel into a folder; the file appears whole or not at all.

    Parameters: target, name: of `TARGETS`.
    Raises: SystemExit where the compiler fails.
    """
    flags = ("-shared",) if "windows" in target else ("-shared", "-fPIC")
    sources = sorted(path.name for path in KERNEL.glob("*.c"))
    with tempfile.TemporaryDirectory(dir=out.absolute()) as folder:
        made = Path(folder) / name
        command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *FLAGS, *flags, *sources, "-o", str(made)]
        cache = {"ZIG_GLOBAL_CACHE_DIR": folder, "ZIG_LOCAL_CACHE_DIR": folder}
        done = subprocess.run(command, cwd=KERNEL, env=os.environ | cache, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"error: the kernel does not compile for {target}: {done.stderr.strip()}")
        return made.replace(out / name)


class KernelHook(BuildHookInterface[Any]):
    """Puts the kernel into a wheel, or next to its sources for an editable installation."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and name what was compiled."""
        tag = os.environ.get("MOIREID_PLATFORM") or this_platform()
        if tag not in TARGETS:
            raise SystemExit(f"error: MOIREID_PLATFORM={tag} is none of {', '.join(TARGETS)}")
        if version == "editable":
            compile_kernel(*TARGETS[this_platform()], KERNEL)
            return
        self._folder = tempfile.TemporaryDirectory()
        made = compile_kernel(*TARGETS[tag], Path(self._folder.name))
        build_data["force_include"][str(made)] = f"moireid/verifier/kernel/{made.name}"
        build_data["pure_python"], build_data["tag"] = False, f"py3-none-{tag}"


def main(out: Path) -> None:
    """Make the wheels of all platforms."""
    out.mkdir(parents=True, exist_ok=True)
    for tag in TARGETS:
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(out.absolute())],
            cwd=Path(__file__).parent,
            env=os.environ | {"MOIREID_PLATFORM": tag, "SOURCE_DATE_EPOCH": "1580601600"},
            check=True,
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
