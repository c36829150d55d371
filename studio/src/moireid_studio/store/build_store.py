"""First badges that visitors build here, each in a folder of its own.

A build takes days, so it is kept for longer than the results of jobs:

build.json                 whose it is, what is wished, and the job that read its pictures last: the studio's own word
work/                      all that a job's process may write
work/first-badge/          the folder of `moireid first-badge`, with what the builder sent
work/round.json            what the last round came to
work/record.json           the capture record, where one was asked for

A process that reads a stranger's film may put anything into `work`: what is there is read no further than is meant, and
never through a link (`Build.file`).
"""

from __future__ import annotations

import secrets
import shutil
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

import msgspec

from moireid.bringup.build_folder import STATE, BuildFolder, BuildState, Wish
from moireid.files import read_regular, write_text
from moireid_studio.problems import Refusal
from moireid_studio.store.job import JOB_ID

FOLDER, ROUND, RECORD = "first-badge", "round.json", "record.json"
#: Largest file of a build's process that is read here; an honest one has some ten kB.
MOST_BYTES = 4 << 20
#: Builds of one owner, and how long one is kept after its last change, days.
MOST_BUILDS, KEEP_DAYS = 20, 60
DAY_S = 86_400.0
Model = TypeVar("Model", bound=msgspec.Struct)


class BuildNote(msgspec.Struct, frozen=True):
    """What the studio itself knows of a build; begun: UTC; job: the last one, empty before the first."""

    owner: str
    begun: datetime
    wish: Wish
    job: str = ""


class BuildRound(msgspec.Struct, frozen=True):
    """What a round came to.

    did: names of the steps that were done; next_step: the name of the one that is next, None at the end; refused: why
    its files could not be used, None where they are not there yet.
    """

    did: list[str]
    next_step: str | None
    refused: str | None


@dataclass(frozen=True)
class Build:
    """One build, as it was when it was read; folder: its own."""

    id: str
    folder: Path
    note: BuildNote

    @property
    def work(self) -> Path:
        """Where its process works."""
        return self.folder / "work"

    @property
    def media(self) -> Path:
        """Where the builder's pictures and films are."""
        return self.work / FOLDER

    def file(self, name: str) -> Path | None:
        """A file of `work`; None where there is none, or a link in its place."""
        path = self.work / name
        return path if path.is_file() and path.resolve() == self.work.resolve() / name else None

    def sent(self, name: str) -> bool:
        """Whether the builder has sent a picture or film of that well-known name."""
        return any(path.stem == name for path in self.media.glob(f"{name}.*"))

    def round(self) -> BuildRound | None:
        """What the last round came to; None before the first."""
        return self._read(ROUND, BuildRound)

    def state(self) -> BuildFolder:
        """The folder with what was read of its pictures; wishes are the studio's own word."""
        found = self._read(f"{FOLDER}/{STATE}", BuildState)
        readings = found.readings if found is not None else {}
        # A path of this machine is not for a visitor.
        return BuildFolder(Path(FOLDER), BuildState(1, "first-badge", self.note.wish, {}, readings))

    def _read(self, name: str, model: type[Model]) -> Model | None:
        path = self.file(name)
        with suppress(OSError, msgspec.MsgspecError):
            if path is not None:
                return msgspec.json.decode(read_regular(path, MOST_BYTES), type=model)
        return None


class BuildStore:
    """The builds of one studio's folder; `lock` is held while one changes."""

    def __init__(self, root: Path) -> None:
        self._root, self.lock = root, threading.Lock()

    def begin(self, owner: str, wish: Wish) -> Build:
        """A new build.  Raises: Refusal 409 where the owner has too many, 503 where it cannot be stored."""
        build_id = secrets.token_hex(16)
        build = Build(build_id, self._root / build_id, BuildNote(owner, datetime.now(UTC), wish))
        with self.lock:
            if len(self.of(owner)) >= MOST_BUILDS:
                raise Refusal(409, "builds", f"You have {MOST_BUILDS} builds; delete one that you need no more.")
            try:
                build.media.mkdir(mode=0o700, parents=True)
                self.save(build)
            except OSError as error:
                text = f"The build cannot be stored ({error.strerror}); try again later."
                raise Refusal(503, "disk", text) from error
        return build

    def save(self, build: Build) -> None:
        """Write a build's note, whole or not at all."""
        write_text(build.folder / "build.json", msgspec.json.encode(build.note).decode())

    def find(self, build_id: str, owner: str) -> Build:
        """The build with that id, if it belongs to `owner`.  Raises: Refusal 404 otherwise."""
        build = self._build(build_id) if JOB_ID.fullmatch(build_id) else None
        if build is None or build.note.owner != owner:
            raise Refusal(404, "no_build", "There is no such build, or it was removed.")
        return build

    def of(self, owner: str) -> list[Build]:
        """An owner's builds, the newest first."""
        there = [self._build(folder.name) for folder in self._folders()]
        mine = [build for build in there if build is not None and build.note.owner == owner]
        return sorted(mine, key=lambda build: build.note.begun, reverse=True)

    def remove(self, build: Build) -> None:
        """Remove a build with all its films."""
        shutil.rmtree(build.folder, ignore_errors=True)

    def remove_old(self) -> None:
        """Remove builds that have not changed for `KEEP_DAYS`, and what is left of others."""
        with self.lock:
            for folder in self._folders():
                note = folder / "build.json"
                if not note.exists() or time.time() - note.stat().st_mtime > KEEP_DAYS * DAY_S:
                    shutil.rmtree(folder, ignore_errors=True)

    def stored_bytes(self) -> int:
        """Bytes of all builds."""
        return sum(path.lstat().st_size for path in self._root.rglob("*") if path.is_file())

    def _folders(self) -> list[Path]:
        there = self._root.iterdir() if self._root.is_dir() else ()
        return [entry for entry in there if JOB_ID.fullmatch(entry.name)]

    def _build(self, build_id: str) -> Build | None:
        folder = self._root / build_id
        try:
            return Build(build_id, folder, msgspec.json.decode((folder / "build.json").read_bytes(), type=BuildNote))
        except (OSError, msgspec.MsgspecError):
            return None
