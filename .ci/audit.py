"""Are holes known in the versions that a lock file names?  `make audit`, and a step of `.ci/run`.

    python .ci/audit.py LOCK [--parts LIST]... [--osv-url URL]

pip-audit asks the databases, one after the other, until one has answered for every package.  It ends in success too
where a database knows none of the packages, which looks like good news and is none; so its answer is read here.

What wheels carry inside is no package of the lock.  FFmpeg and three.js, of the lists of parts, are asked for in OSV,
by the tag of the version and by the package of npm; as an unknown project gives the same answer as one without a hole,
an old version that has some is asked for first.  Of other libraries in wheels only files are known, so they are named
as not checked.

Exit code 0: none is known; 1: some are; 2: wrong usage; 3: some packages could not be checked.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import urllib.request
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
            ids = ", ".join(f"{hole['id']} (fixed in {fixed_versions(hole)})" for hole in package["vulns"])
            answer.holes.append(f"{package['name']} {package['version']}: {ids}")
    return answer


FFMPEG_FILES = tuple(f"lib{name}-" for name in ("avcodec", "avdevice", "avfilter", "avformat", "avutil"))
FFMPEG_FILES += ("libswresample-", "libswscale-")


@dataclass(frozen=True)
class Project:
    """A project as OSV knows it: its name, ecosystem and form of a version there, and a version that has holes."""

    words: str
    name: str
    ecosystem: str
    version: str
    old: str


PROJECTS = {
    "ffmpeg": Project("FFmpeg", "https://github.com/FFmpeg/FFmpeg.git", "GIT", "n{}", "4.0"),
    "three": Project("three.js", "three", "npm", "{}", "0.120.0"),
}


def carried(parts: Path) -> tuple[dict[tuple[str, str], list[str]], list[str]]:
    """Of a list of parts: what carries each version of `PROJECTS`, and all other libraries inside of packages."""
    found: dict[tuple[str, str], list[str]] = {}
    files = []
    listed = json.loads(parts.read_text(encoding="utf-8"))
    for part in [*listed["components"], *filter(None, [listed.get("metadata", {}).get("component")])]:
        for inside in part.get("components", ()):
            if inside["name"] in PROJECTS:
                found.setdefault((inside["name"], inside["version"]), []).append(part["name"])
            elif not inside["name"].startswith(FFMPEG_FILES):
                files.append(f"{part['name']}: {inside['name']}")
    return found, files


def ask_project(project: Project, version: str, url: str) -> list[str]:
    """The ids of holes that OSV knows in a version.  Raises: OSError, ValueError where it gives no answer."""
    package = {"name": project.name, "ecosystem": project.ecosystem}
    asked = {"package": package, "version": project.version.format(version)}
    request = urllib.request.Request(url, json.dumps(asked).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=30) as answer:
        return [str(hole["id"]) for hole in json.load(answer).get("vulns", [])]


def check_carried(parts: Path, url: str) -> int:
    """Print what is known of what a list's packages carry inside; the exit code."""
    found, files = carried(parts)
    if files:
        shown = f"{len(files)} other libraries inside of wheels, such as {files[0]}"
        print(f"NOT CHECKED: {shown}: databases know packages; {parts.name} lists the files")
    codes = {CLEAN}
    for (name, version), inside in found.items():
        project, where = PROJECTS[name], f"inside of {' and '.join(inside)}"
        try:
            if not ask_project(project, project.old, url):
                raise ValueError("it knows no hole in an old one either")
            holes = ask_project(project, version, url)
        except (OSError, ValueError, KeyError) as error:
            print(f"NOT CHECKED: {project.words} {version} ({where}): OSV did not answer for it: {error}")
            codes.add(UNCHECKED)
            continue
        words = f"{project.words} {version} ({where})"
        print(f"known hole (OSV): {words}: {', '.join(holes)}" if holes else f"OSV knows no hole in {words}")
        codes.add(KNOWN if holes else CLEAN)
    return KNOWN if KNOWN in codes else max(codes)


def fixed_versions(hole: dict[str, list[str]]) -> str:
    """The versions without the hole, in words."""
    return " or ".join(hole.get("fix_versions", [])) or "no version yet"


def main() -> int:
    parser = argparse.ArgumentParser(description="Are holes known in the versions that a lock file names?")
    parser.add_argument("lock", type=Path)
    parser.add_argument("--osv-url", default="https://api.osv.dev/v1/query", help="another server of the OSV database")
    parser.add_argument(
        "--parts", type=Path, action="append", default=[], help="a list of parts that names what wheels carry inside"
    )
    options = parser.parse_args()
    for path in (options.lock, *options.parts):
        if not path.is_file():
            parser.error(f"there is no file {path}")
    codes = {check_packages(options.lock, options.osv_url)}
    codes |= {check_carried(parts, options.osv_url) for parts in options.parts}
    return KNOWN if KNOWN in codes else max(codes)


def check_packages(lock: Path, url: str) -> int:
    """Print what the databases know of the packages of a lock file; the exit code."""
    databases = {"OSV": ["-s", "osv", "--osv-url", url], "PyPI": ["-s", "pypi"]}
    for name, service in databases.items():
        answer = ask(lock, service)
        for hole in answer.holes:
            print(f"known hole ({name}): {hole}")
        if answer.holes:
            return KNOWN
        if answer.whole:
            print(f"{name} knows no hole in any of the {answer.checked} packages of {lock.name}")
            return CLEAN
        why = answer.fault or f"it does not know {len(answer.unchecked)} of {answer.checked + len(answer.unchecked)}"
        print(f"{name} did not answer for all packages: {why}")
    print(f"NOT CHECKED: whether holes are known in {lock.name}; run `make audit` where a database is reached")
    return UNCHECKED


if __name__ == "__main__":
    sys.exit(main())
