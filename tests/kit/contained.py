"""A command under the filter of calls of `deploy/`: `python -m kit.contained PROFILE COMMAND...`."""

from __future__ import annotations

import json
import os
import platform
import sys
from pathlib import Path

from moireid.sandbox.seccomp import ALLOW, EQ, MASKED_EQ, Argument, Filter, refuse

MEANINGS = {"SCMP_CMP_EQ": EQ, "SCMP_CMP_MASKED_EQ": MASKED_EQ}
#: Of calls that a processor has not, the engines drop the rule.
_HERE = {"x86_64": "SCMP_ARCH_X86_64", "aarch64": "SCMP_ARCH_AARCH64"}


def load_profile(path: Path) -> None:
    """Put an engine's profile in force for this process.  Raises: OSError; LookupError for another processor."""
    profile = json.loads(path.read_text(encoding="utf-8"))
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


if __name__ == "__main__":
    load_profile(Path(sys.argv[1]))
    os.execvp(sys.argv[2], sys.argv[2:])
