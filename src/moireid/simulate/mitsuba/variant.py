"""Which of Mitsuba's variants this machine can run, found out without risk to the caller.

Mitsuba compiles its fast variants with the machine's own libLLVM.  An old one (Debian's 14 and 15 were tried) does not
refuse the code, it aborts the process: "Cannot select: fminimum".  So each library is first tried in a child process,
with a scene of four by four pixels, and only one whose child came back with the right picture is ever loaded here.

Convention: variants end in `_rgb`, because `mitsuba` uses the three colours as three channels of figures.
Source: Mitsuba 3.9.1 and Dr.Jit, which reads the library's path from DRJIT_LIBLLVM_PATH when LLVM is first used.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from moireid.errors import SpecError
from moireid.extras import missing_extra

FAST_VARIANT = "llvm_ad_rgb"
PLAIN_VARIANT = "scalar_rgb"
LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"
#: Older ones abort; see the module docstring.
OLDEST_LLVM = 16
#: A trial takes 1.2 s on two cores; a machine that is busy may need many times that.
TRIAL_TIMEOUT_S = 60.0
#: After this many libraries that fail, the next one is not tried.
MOST_TRIALS = 3
FOLDERS = ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/opt/homebrew/opt", "/usr/local/opt")
#: Debian has them in lib/<machine> and lib/llvm-19/lib, Fedora in lib64, Homebrew in opt/llvm@19/lib.
PATTERNS = ("libLLVM*", "*-linux-gnu/libLLVM*", "llvm*/lib*/libLLVM*")
#: 19 of libLLVM-19.so, libLLVM.so.19.1, llvm@19/lib/libLLVM.dylib, and of no other file.
VERSION = re.compile(r"(?:llvm[-@/]|/libLLVM-|/libLLVM\.so\.)(\d+)(?:[^/]*|.*/libLLVM)(?:\.so[\d.]*|\.dylib|[\d.])$")

# The child renders refraction, an emitter and stratified samples: what the badge's scene asks of the compiler.  Before
# that it compiles a kernel with a fresh number in it, because Dr.Jit keeps finished kernels on disk, and one that
# another libLLVM left there would hide an abort.  It leaves no core file behind.
TRIAL = f"""
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
import random
import drjit as dr
import mitsuba as mi
mi.set_variant({FAST_VARIANT!r})
lowest = dr.minimum(dr.arange(mi.Float, 8), 0.5 + random.random())
assert abs(float(dr.sum(dr.maximum(lowest, -1.0)).numpy()[0])) > 3.0
sheet = {{"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, 1])}}
picture = mi.render(mi.load_dict({{
    "type": "scene",
    "integrator": {{"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}},
    "sensor": {{
        "type": "perspective", "fov": 10, "to_world": mi.ScalarTransform4f().look_at([0, 0, 9], [0, 0, 0], [0, 1, 0]),
        "film": {{"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {{"type": "box"}}}},
        "sampler": {{"type": "multijitter", "sample_count": 16}},
    }},
    "sheet": {{**sheet, "bsdf": {{"type": "dielectric", "int_ior": 1.0, "ext_ior": 1.0}}}},
    "lamp": {{"type": "rectangle", "emitter": {{"type": "area", "radiance": 2.0}}}},
}}))
assert abs(float(picture.array.numpy().mean()) - 2.0) < 1e-3
"""


@contextmanager
def mitsuba_with(variant: str | None) -> Iterator[Any]:
    """Mitsuba's module with a variant set, None for `choose_variant`'s; the caller's own is set again afterwards.

    Convention: module docstring.
    Raises: MissingExtraError without mitsuba; SpecError for a variant that is unknown, or does not run here.
    Source: Mitsuba keeps one variant for each process.
    """
    try:
        import mitsuba as mi
    except ImportError as missing:
        raise missing_extra("this renderer", "mitsuba", "simulate") from missing
    chosen = variant or choose_variant()
    if chosen not in mi.variants() or not chosen.endswith("_rgb"):
        fit = ", ".join(one for one in mi.variants() if one.endswith("_rgb"))
        raise SpecError(f"variant {chosen!r} of Mitsuba does not serve here; choose one of {fit}")
    if chosen.startswith("llvm") and choose_variant() == PLAIN_VARIANT:
        raise SpecError(f"no libLLVM on this machine runs {chosen!r}; install libLLVM 19, or choose {PLAIN_VARIANT!r}")
    before = mi.variant()
    try:
        mi.set_variant(chosen)
    except ImportError as refused:
        raise SpecError(f"variant {chosen!r} does not start on this machine; choose {PLAIN_VARIANT!r}") from refused
    # A library must not print by itself, and Mitsuba would print on stdout.
    loudness = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield mi
    finally:
        mi.set_log_level(loudness)
        if before is not None:
            mi.set_variant(before)


@cache
def choose_variant() -> str:
    """The fastest variant of Mitsuba that runs here: `llvm_ad_rgb`, or `scalar_rgb` where no libLLVM serves.

    Convention: found out once in a process; points DRJIT_LIBLLVM_PATH at the library that was tried, because Dr.Jit
        would otherwise load whichever it finds first.
    Returns: the name for `mitsuba.set_variant`.
    Source: module docstring; nothing is loaded into this process.
    """
    for library in llvm_candidates()[:MOST_TRIALS]:
        if _renders_with(library):
            os.environ[LIBRARY_VARIABLE] = str(library)
            return FAST_VARIANT
    return PLAIN_VARIANT


def llvm_candidates() -> list[Path]:
    """libLLVM files worth a trial: the one that DRJIT_LIBLLVM_PATH names, then those installed, newest first.

    Convention: the named one is tried whatever its version, since the trial is safe; others from `OLDEST_LLVM` on.
    Source: the places where Debian, Fedora and Homebrew put them.
    """
    # Several links to one file are one candidate; a name without a version is such a link.
    files = {path.resolve() for folder in FOLDERS for pattern in PATTERNS for path in Path(folder).glob(pattern)}
    versions = {path: int(found[1]) for path in files if (found := VERSION.search(str(path))) and path.is_file()}
    newest_first = sorted((path for path, version in versions.items() if version >= OLDEST_LLVM), key=str)
    newest_first.sort(key=lambda path: -versions[path])
    named = os.environ.get(LIBRARY_VARIABLE)
    return [Path(named), *newest_first] if named else newest_first


def _renders_with(library: Path) -> bool:
    """Whether a child process renders a small scene with that library, without dying over it."""
    if not library.is_file():
        return False
    try:
        # -P: else the child would import modules from the user's present folder.
        child = subprocess.run(
            [sys.executable, "-P", "-c", TRIAL],
            env={**os.environ, LIBRARY_VARIABLE: str(library)},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=TRIAL_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return child.returncode == 0
