"""A command as a container of `deploy/` runs it, as far as that goes without a container engine.

Its own mounts with everything read-only but the folders that are named, a user and groups of its own, no capability, no
new privileges, and the shipped filter of system calls.  It has the machine's network and sees its processes: those
are a container engine's to close.

    python -m kit.contained PROFILE COMMAND...      load the filter, then become the command
"""

from __future__ import annotations

import json
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from kit.places import ROOT
from moireid.sandbox.seccomp import ALLOW, EQ, MASKED_EQ, Argument, Filter, refuse

PROFILE = ROOT / "deploy" / "seccomp.json"
MEANINGS = {"SCMP_CMP_EQ": EQ, "SCMP_CMP_MASKED_EQ": MASKED_EQ}
#: Of calls that a processor has not, the engines drop the rule.
_HERE = {"x86_64": "SCMP_ARCH_X86_64", "aarch64": "SCMP_ARCH_AARCH64"}


def load_profile(profile: Mapping[str, Any]) -> None:
    """Put an engine's profile in force for this process.  Raises: OSError; LookupError for another processor."""
    if _HERE[platform.machine()] not in [one["architecture"] for one in profile["archMap"]]:
        raise LookupError(platform.machine())
    with Filter(refuse(profile["defaultErrnoRet"])) as calls:
        for rule in profile["syscalls"]:
            action = ALLOW if rule["action"] == "SCMP_ACT_ALLOW" else refuse(rule["errnoRet"])
            conditions = [
                Argument(one["index"], MEANINGS[one["op"]], one["value"], one.get("valueTwo", 0))
                for one in rule.get("args", ())
            ]
            for name in rule["names"]:
                try:
                    calls.add(action, name, *conditions)
                except LookupError:
                    continue
        calls.load()


def contained(
    command: Sequence[str],
    *,
    user: int,
    group: int,
    groups: Sequence[int],
    writable: Sequence[Path],
    hidden: Sequence[Path] = (),
    **environment: str,
) -> subprocess.Popen[str]:
    """Start a command; writable: the folders that it may write to; hidden: folders that it finds empty.

    The machine's temporary folder is read-only too, as this project may be in it: give one as TMPDIR.
    """
    if not _may_contain():
        # Not skipped: where CI runs, that would count as failed, though nothing is wrong with the change.
        pytest.xfail("only root, where mounts of one's own are allowed, may start a command as a container would")
    binds = [f"mount --bind {shlex.quote(str(path))} {shlex.quote(str(path))}" for path in writable]
    empty = [f"mount -t tmpfs -o ro,mode=755 none {shlex.quote(str(path))}" for path in hidden]
    rights = f"--reuid {user} --regid {group} " + (
        f"--groups {','.join(map(str, groups))}" if groups else "--clear-groups"
    )
    own = [sys.executable, "-m", "kit.contained", str(PROFILE), *command]
    become = f"exec setpriv {rights} --no-new-privs --bounding-set=-all --inh-caps=-all {shlex.join(own)}"
    script = " && ".join([*_open_python(), *binds, "mount -o remount,bind,ro /", *empty, become])
    kept = {"PATH": os.environ["PATH"], "PYTHONPATH": str(ROOT / "tests"), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        ["unshare", "--mount", "--propagation", "private", "sh", "-c", script],
        env=kept | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


@cache
def _may_contain() -> bool:
    if os.getuid() != 0 or not (shutil.which("unshare") and shutil.which("setpriv")):
        return False
    return (
        subprocess.run(["unshare", "--mount", "--propagation", "private", "true"], capture_output=True).returncode == 0
    )


def _open_python() -> list[str]:
    """What lets other users reach this Python where it is in a home that is closed to them; no more of it is shown."""
    base = Path(sys.base_prefix).resolve()
    closed = [path for path in base.parents if not path.stat().st_mode & 0o001]
    if not closed:
        return []
    stage, inside = '"$stage"', shlex.quote(str(base))
    return [
        "stage=$(mktemp -d)",
        f"mount --bind {inside} {stage}",
        f"mount -t tmpfs -o mode=755 none {shlex.quote(str(closed[-1]))}",
        f"mkdir -p {inside}",
        f"mount --bind {stage} {inside}",
        f"umount {stage}",
        f"rmdir {stage}",
    ]


if __name__ == "__main__":
    load_profile(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
    os.execvp(sys.argv[2], sys.argv[2:])
