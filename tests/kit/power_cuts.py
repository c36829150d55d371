"""What a power cut leaves of files, after some calls of an operation: `python -m kit.power_cuts FOLDER MOST [NAME…]`.

An operation runs once, and faults.c writes down each change of a file: writes, new lengths, names, and what was synced.
After `MOST` of them or more, drawn as by `fault_runs` (0: after each), and after the last one, the power is cut, and of
what was not synced some is lost, in a way of `SURVIVALS`.  What is left
is looked at as by `fault_runs`: the registry is that of before or of after, that of after once the operation has said
that it is done; each file is whole.

Assumed of the disk: what fsync has confirmed stays; a name is kept once its folder is synced, and may be before; writes
may be lost singly and in any order, but a write that is kept is kept whole.  SQLite states what it assumes beyond that
in https://sqlite.org/atomiccommit.html: a half-written journal is recognised by its checksum.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from kit.fault_runs import DONE, OPERATIONS, checked_point, forked, preloaded, prepare, report, sampled, state_of

#: Which names, and which bytes, are left of those that were not synced.
SURVIVALS = (("kept", "kept"), ("now", "kept"), ("kept", "now"), ("now", "torn"))
#: What these write is one file, whose name a power cut may take back to the file of before even when all is done.
OF_FILES = ("export", "checkpoint", "publish")


class Content:
    """The bytes of a file: those on the disk, and the changes since the last sync."""

    def __init__(self, kept: bytes = b"") -> None:
        self.kept, self.changes = kept, list[tuple[int | None, bytes | int]]()

    def left(self, way: str) -> bytes:
        """The bytes after a power cut: those that were kept, those of now, or every other change of those since."""
        found = bytearray(self.kept)
        for number, (place, change) in enumerate(self.changes if way != "kept" else []):
            if way == "torn" and number % 2:
                continue
            if isinstance(change, int):
                found = found[:change].ljust(change, b"\0")
            else:
                assert place is not None
                found = found.ljust(place, b"\0")
                found[place : place + len(change)] = change
        return bytes(found)

    def sync(self) -> None:
        self.kept, self.changes = self.left("now"), []


class Disk:
    """The files of a folder, as a disk with a cache has them; a name without content is a folder's."""

    def __init__(self, folder: Path) -> None:
        self._folder = str(folder)
        found = {str(path): None if path.is_dir() else Content(path.read_bytes()) for path in folder.rglob("*")}
        self._names: dict[str, dict[str, Content | None]] = {"kept": dict(found), "now": found}
        self._open = {os.stat(path).st_ino: content for path, content in found.items() if content is not None}

    def change(self, what: str, inode: int, one: int, two: int, content: bytes) -> None:
        """One line of the trace."""
        names, file = self._names["now"], self._open.get(inode)
        path = "" if what in "WT" else content.decode()
        if what == "O":
            if one:
                self._open[inode] = names[path] = Content()
            if two and (opened := self._open.get(inode)) is not None:
                opened.changes.append((None, 0))
        elif what == "W" and file is not None:
            file.changes.append((one, content))
        elif what == "T" and file is not None:
            file.changes.append((None, one))
        elif what == "R":
            old, _, new = path.partition("\n")
            names[new] = names.pop(old)
        elif what == "U":
            names.pop(path)
        elif what == "M":
            names[path] = None
        elif what == "S" and file is not None:
            file.sync()
        elif what == "S":
            kept = {name: held for name, held in self._names["kept"].items() if os.path.dirname(name) != path}
            self._names["kept"] = kept | {name: held for name, held in names.items() if os.path.dirname(name) == path}

    def left(self, names: str, content: str) -> dict[str, bytes | None]:
        """The files after a power cut, and None for each folder; what is in a folder that was lost is lost."""
        found = self._names[names]

        def is_there(path: str) -> bool:
            return path == self._folder or (path in found and is_there(os.path.dirname(path)))

        return {path: held and held.left(content) for path, held in found.items() if is_there(path)}


def traced(name: str, folder: Path, trace: Path) -> list[tuple[str, int, int, int, bytes]]:
    """The changes of files by an operation, in order."""

    def work() -> None:
        shim = ctypes.CDLL(None)
        shim.fault_record(str(trace).encode())
        shim.fault_arm(0, -1, str(folder).encode())
        OPERATIONS[name](folder)

    code, said = forked(work)
    assert code == DONE, said
    found = []
    with trace.open("rb") as stream:
        while line := stream.readline():
            what, *numbers, size = line.split()
            inode, one, two = map(int, numbers)
            found.append((what.decode(), inode, one, two, stream.read(int(size))))
    return found


def points(name: str, place: Path, most: int, covered: set[tuple[str, str]]) -> Iterator[str | None]:
    """Cut the power after some changes; for each point None, or what does not hold."""
    start, folder = place / "start", place / "now"
    prepare(start, name)
    shutil.copytree(start, folder)
    disk = Disk(folder)
    changes = traced(name, folder, place / "trace")
    code, new = forked(lambda: state_of(folder))
    assert code == DONE, new
    restore(folder, disk.left("kept", "kept"))
    old = forked(lambda: state_of(folder))[1]
    known: dict[str, str | None] = {}
    ways = [" names, ".join(way) for way in SURVIVALS]
    every = [(way, number, change[0]) for number, change in enumerate(changes, 1) for way in ways]
    drawn = {*sampled(name, every, most, covered), *every[-len(ways) :]}
    for number, change in enumerate(changes, 1):
        disk.change(*change)
        is_done = number == len(changes) and name not in OF_FILES
        for way in SURVIVALS:
            if (" names, ".join(way), number, change[0]) not in drawn:
                continue
            left = disk.left(*way)
            key = f"{is_done}{hashlib.sha256(repr(sorted(left.items())).encode()).hexdigest()}"
            if key not in known:
                restore(folder, left)
                ended: tuple[int, Any] = (DONE, "done") if is_done else (-9, "the power was cut")
                where = f"{name}, {' names, '.join(way)} bytes after change {number} of {len(changes)}: "
                known[key] = checked_point(where, folder, ended, old, new)
            yield known[key]


def restore(folder: Path, left: dict[str, bytes | None]) -> None:
    """Make a folder hold these files."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for path, content in sorted(left.items()):
        if content is None:
            Path(path).mkdir(mode=0o700)
        else:
            Path(path).write_bytes(content)
            Path(path).chmod(0o600)


def main(place: str, most: str, *names: str) -> None:
    """Write the number of points, and each that does not hold."""
    found, covered = {}, set[tuple[str, str]]()
    for name in names or OPERATIONS:
        with tempfile.TemporaryDirectory(dir=place) as own:
            found[name] = list(points(name, Path(own), int(most), covered))
        sys.stderr.write(f"{name}: {len(found[name])} points\n")
    report(found, covered)


if __name__ == "__main__":
    preloaded("kit.power_cuts", main)
