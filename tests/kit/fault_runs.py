"""File calls of an operation fail, one in each run: `python -m kit.fault_runs FOLDER MOST [NAME…]`.

An operation is first run whole, and its calls are counted.  Then it is run from the same state with a call that fails,
in a process of its own, forked from this one: by an error, a short write, a full disk from there on, a kill after it,
half a write and a kill.  At least MOST such points (0: all) are drawn with a fixed seed, and so that each kind of call
fails in each way.  Afterwards the state is looked at by another process: it must be that of before or that of after,
that of after if the operation said that it was done, and it must be possible to go on.
Source: the tests of SQLite for I/O errors and crashes, https://sqlite.org/testing.html, sections 3.2 and 3.3.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from kit.registries import badge_of, url_of
from moireid.badge import Badge
from moireid.errors import MoireIdError
from moireid.files import write_text
from moireid.idcodes import specimen_of
from moireid.registry import Registry, import_registry, open_registry
from moireid.registry.bundle.held import Bundle
from moireid.registry.checkpoints.checkpoint import read_checkpoint
from moireid.registry.transfer import checked_copy

KINDS = {"error": 1, "short write": 2, "full disk": 3, "kill": 4, "torn write": 5}
SOURCE = Path(__file__).with_name("faults.c")
#: Exit codes of an operation's process: done, refused in a sentence; anything else but a kill is wrong.
DONE, REFUSED, WRONG = 0, 3, 4
FILES = ("out.sqlite3", "bundle", "checkpoint")
#: A way to fail, the number of a call, and the name of that call.
Point = tuple[str, int, str]


def at_home(folder: Path) -> str:
    """Keep everything that is written below one folder; returns the registry's URL."""
    for name, place in (("MOIREID_KEYS", "keys"), ("MOIREID_SEEN", "memory/seen.sqlite3"), ("TMPDIR", "tmp")):
        os.environ[name] = str(folder / place)
    (folder / "tmp").mkdir(parents=True, exist_ok=True)
    tempfile.tempdir = None
    return url_of(folder / "people.sqlite3")


def with_registry(act: Callable[[Registry, Path], object], *, create: bool = False) -> Callable[[Path], None]:
    def operation(folder: Path) -> None:
        with open_registry(at_home(folder), create=create) as registry:
            act(registry, folder)

    return operation


def people(first: Badge, count: int) -> list[Badge]:
    return [replace(first, id=f"{number:06x}", name=f"Person {number}") for number in range(1, count + 1)]


def imported(folder: Path) -> None:
    import_registry(folder / "in.sqlite3", at_home(folder))


def exported(registry: Registry, folder: Path) -> None:
    registry.export(folder / "out.sqlite3", overwrite=True)


def pointed(registry: Registry, folder: Path) -> None:
    write_text(folder / "checkpoint", registry.checkpoint()[0].note)


def published(registry: Registry, folder: Path) -> None:
    registry.publish(folder / "bundle", specimen_of, days=1, overwrite=True)


OPERATIONS: dict[str, Callable[[Path], None]] = {
    "init": with_registry(lambda registry, folder: registry.count(), create=True),
    "enroll": with_registry(lambda registry, folder: registry.enroll(badge_of("Di"))),
    "enroll_many": with_registry(lambda registry, folder: registry.enroll_many(people(badge_of("Di"), 40))),
    "revoke": with_registry(lambda registry, folder: registry.revoke("Ada", "lost")),
    "erase": with_registry(lambda registry, folder: registry.erase("Ada")),
    "import": imported,
    "export": with_registry(exported),
    "checkpoint": with_registry(pointed),
    "publish": with_registry(published),
}


def prepare(folder: Path, name: str) -> None:
    """The state in which an operation begins."""
    url = at_home(folder)
    if name == "init":
        return
    with open_registry(url, create=True) as registry:
        for one in ("Ada", "Bo"):
            registry.enroll(badge_of(one))
        for write in (exported, pointed, published):
            write(registry, folder)
        shutil.copy(folder / "people.sqlite3", folder / "tmp" / "early")
        if name == "import":
            registry.enroll_many(people(badge_of("Cy"), 5))
            registry.revoke("Ada", "lost")
            registry.export(folder / "in.sqlite3")
        else:
            registry.enroll(badge_of("Cy"))
    if name == "import":
        shutil.copy(folder / "tmp" / "early", folder / "people.sqlite3")
        (folder / "memory" / "seen.sqlite3").unlink()


def state_of(folder: Path) -> tuple[Any, ...]:
    """What a user finds: the registry's records and the files; raises where something does not hold."""
    url = at_home(folder)
    found: list[Any] = []
    path = folder / "people.sqlite3"
    if path.exists() and path.stat().st_size > 0:
        with open_registry(url, create=True) as registry:
            seen = registry.audit()
            assert seen.sound, seen.findings
            registry.standing()
            assert registry.key_path.exists(), "its private key is gone"
            found.append((seen.entries, [(one.name, one.revoked_at is not None) for one in registry.records()]))
            if (folder / "checkpoint").exists():
                assert registry.audit(since=[read_checkpoint(folder / "checkpoint")]).sound
    for name in FILES:
        path = folder / name
        found.append(hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else None)
    if (folder / "bundle").exists():
        # It may be older than the registry, which only a person who saw that one notices.
        os.environ["MOIREID_SEEN"] = str(folder / "tmp" / "another person's")
        with Bundle(folder / "bundle") as bundle:
            bundle.claimed("Bo")
    if (folder / "out.sqlite3").exists():
        with checked_copy(folder / "out.sqlite3"):
            pass
    return tuple(found)


def go_on(folder: Path) -> None:
    """The next thing that a user does must work."""
    with open_registry(at_home(folder), create=True) as registry:
        registry.enroll(badge_of("Flo"))
        assert registry.audit().sound


def forked(work: Callable[[], Any]) -> tuple[int, Any]:
    """What a process of its own gives: how it ended (negative: by a signal), and what it sent."""
    inlet, outlet = os.pipe()
    child = os.fork()
    if child == 0:
        code = WRONG
        try:
            answer, code = work(), DONE
        except (MoireIdError, OSError) as error:
            answer, code = str(error), REFUSED
        except BaseException:  # noqa: BLE001
            answer = traceback.format_exc()[-1500:]
        os.write(outlet, json.dumps(answer).encode()[:60000])
        os._exit(code)
    os.close(outlet)
    with os.fdopen(inlet, "rb") as stream:
        said = stream.read()
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return code, json.loads(said) if said else None


def failing(name: str, folder: Path, kind: int, at: int) -> tuple[int, Any]:
    """An operation in which call number `at` fails; what it sends is its calls: the name of each, and 1 if it reads."""

    def work() -> list[list[str]]:
        shim = ctypes.CDLL(None)
        shim.fault_calls.restype = ctypes.c_char_p
        shim.fault_arm(kind, at, str(folder).encode())
        try:
            OPERATIONS[name](folder)
        finally:
            calls = [line.split() for line in shim.fault_calls().decode().replace("64 ", " ").splitlines()]
            shim.fault_arm(0, -1, b"/nowhere")
        return calls

    return forked(work)


def sampled(name: str, points: list[Point], most: int, covered: set[tuple[str, str]]) -> list[Point]:
    """At least `most` of these points, 0 for all: drawn with a fixed seed, and each pair of a way to fail and a call
    that is not covered yet; covered: pairs, to which those that are drawn are added.
    """
    drawn = random.Random(name).sample(points, len(points))
    new = {(kind, call): (kind, at, call) for kind, at, call in drawn if (kind, call) not in covered}
    covered.update(new)
    rest = [point for point in drawn if point not in new.values()]
    return [*new.values(), *rest[: max(most - len(new), 0) if most else None]]


def points(name: str, place: Path, most: int, covered: set[tuple[str, str]]) -> Iterator[str | None]:
    """Fail an operation at some calls, as `sampled`; for each point None, or what does not hold."""
    start, folder = place / "start", place / "now"
    prepare(start, name)

    def fresh() -> None:
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(start, folder)

    fresh()
    code, old = forked(lambda: state_of(folder))
    assert code == DONE, old
    fresh()
    code, calls = failing(name, folder, KINDS["error"], -1)
    assert code == DONE, calls
    new = forked(lambda: state_of(folder))[1]
    changes = [call for call, reads in calls if reads == "0"]
    every = [("error", at, call) for at, (call, _) in enumerate(calls, 1)]
    every += [(kind, at, call) for kind in [*KINDS][1:] for at, call in enumerate(changes, 1)]
    for kind, at, call in sampled(name, every, most, covered):
        fresh()
        ended = failing(name, folder, KINDS[kind], at)
        yield checked_point(f"{name}, {kind} at call {at}, {call}: ", folder, ended, old, new)


def checked_point(where: str, folder: Path, ended: tuple[int, Any], old: list[Any], new: list[Any]) -> str | None:
    """None, or what does not hold after a failure.

    Parameters: where: names the point; ended: how the operation ended, and what it said; old, new: the two states.
    """
    code, found = forked(lambda: state_of(folder))
    if ended[0] not in (DONE, REFUSED, -9):
        return f"{where}it ended with {ended[0]}: {ended[1]}"
    if code != DONE:
        return f"{where}{found}"
    if not is_one_of(found, old, new, done=ended[0] == DONE):
        return f"{where}it ended with {ended}, and the state is {found}, not {old} nor {new}"
    code, said = forked(lambda: go_on(folder))
    return None if code == DONE else f"{where}one cannot go on: {said}"


def is_one_of(found: list[Any], old: list[Any], new: list[Any], *, done: bool) -> bool:
    """Whether a state is that of before or after; files that are signed anew are another each time, and whole."""

    def same(one: Any, other: Any, before: Any) -> bool:
        return bool(
            one == other or (isinstance(one, str) and isinstance(other, str) and other != before and one != before)
        )

    is_new = len(found) == len(new) and all(map(same, found, new, old if len(old) == len(new) else new))
    return is_new or (found == old and not done)


def main(place: str, most: str, *names: str) -> None:
    """Write the number of points, each that does not hold, and the pairs of a way to fail and a call."""
    found, covered = {}, set[tuple[str, str]]()
    for name in names or OPERATIONS:
        with tempfile.TemporaryDirectory(dir=place) as own:
            found[name] = list(points(name, Path(own), int(most), covered))
        sys.stderr.write(f"{name}: {len(found[name])} points\n")
    wrong = [one for points in found.values() for one in points if one is not None]
    document = {"points": sum(map(len, found.values())), "wrong": wrong, "covered": sorted(covered)}
    sys.stdout.write(json.dumps(document) + "\n")


def preloaded() -> None:
    """Run again with faults.c loaded, which is compiled here, so that the command is one."""
    with tempfile.TemporaryDirectory() as built:
        shim = Path(built) / "faults.so"
        options = ("-shared", "-fPIC", "-O1", "-fno-sanitize=undefined", "-o", shim)
        subprocess.run([sys.executable, "-m", "ziglang", "cc", *options, SOURCE], check=True)
        again = [sys.executable, "-m", "kit.fault_runs", *sys.argv[1:]]
        sys.exit(subprocess.run(again, env=os.environ | {"LD_PRELOAD": str(shim)}, check=False).returncode)


if __name__ == "__main__":
    if "LD_PRELOAD" in os.environ:
        main(*sys.argv[1:])
    else:
        preloaded()
