"""Are holes known in the versions that a lock file names?  `make audit`, and a step of `.ci/run`.

    python .ci/audit.py LOCK [--osv-url URL]

pip-audit asks the databases, one after the other, until one has answered for every package.  It ends in success too
where a database knows none of the packages, which looks like good news and is none; so its answer is read here.

Exit code 0: none is known; 1: some are; 2: wrong usage; 3: some packages could not be checked.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

CLEAN, KNOWN, UNCHECKED = 0, 1, 3


@dataclass
class Answer:
    """What one database said: holes as `package version: ids`, and what it did not answer for."""

    holes: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    checked: int = 0
    fault: str | None = None

    @property
    def whole(self) -> bool:
        return self.fault is None and self.checked > 0 and not self.unchecked


def ask(lock: Path, service: list[str]) -> Answer:
    """One database's answer; without one, `fault` is the last line of what pip-audit said."""
    command = [sys.executable, "-m", "pip_audit", "-r", str(lock), "--require-hashes", "--disable-pip"]
    told = subprocess.run(
        [*command, "-f", "json", "--progress-spinner", "off", *service], capture_output=True, text=True, check=False
    )
    try:
        packages = json.loads(told.stdout)["dependencies"]
    except (json.JSONDecodeError, KeyError):
        return Answer(fault=(told.stderr.strip().splitlines() or ["no answer"])[-1])
    answer = Answer()
    for package in packages:
        if "skip_reason" in package:
            answer.unchecked.append(package["name"])
            continue
        answer.checked += 1
        if package["vulns"]:
            ids = ", ".join(f"{hole['id']} (mended in {told_versions(hole)})" for hole in package["vulns"])
            answer.holes.append(f"{package['name']} {package['version']}: {ids}")
    return answer


def told_versions(hole: dict[str, list[str]]) -> str:
    """The versions without the hole, in words."""
    return " or ".join(hole.get("fix_versions", [])) or "no version yet"


def main() -> int:
    parser = argparse.ArgumentParser(description="Are holes known in the versions that a lock file names?")
    parser.add_argument("lock", type=Path)
    parser.add_argument("--osv-url", default="https://api.osv.dev/v1/query", help="another server of the OSV database")
    options = parser.parse_args()
    if not options.lock.is_file():
        parser.error(f"there is no file {options.lock}")
    databases = {"OSV": ["-s", "osv", "--osv-url", options.osv_url], "PyPI": ["-s", "pypi"]}
    for name, service in databases.items():
        answer = ask(options.lock, service)
        for hole in answer.holes:
            print(f"known hole ({name}): {hole}")
        if answer.holes:
            return KNOWN
        if answer.whole:
            print(f"{name} knows no hole in any of the {answer.checked} packages of {options.lock.name}")
            return CLEAN
        why = answer.fault or f"it does not know {len(answer.unchecked)} of {answer.checked + len(answer.unchecked)}"
        print(f"{name} did not answer for all packages: {why}")
    print(f"NOT CHECKED: whether holes are known in {options.lock.name}; run `make audit` where a database is reached")
    return UNCHECKED


if __name__ == "__main__":
    sys.exit(main())
