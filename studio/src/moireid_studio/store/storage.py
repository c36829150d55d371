"""Films that wait, and what is made of them: in the studio's own folder, or in any storage that fsspec knows.

A storage serves several studios and their workers.  A film is there whole before its job may be taken, and work is done
in a folder on the worker's own machine.  What a process left in that folder is not trusted: a link is not followed.

Pictures are packed in archives: to be kept for their visitor, or with an order for the process that prints.  A picture
has a key: what it is for, or the name by which a list calls it.  In the archive and in folders it bears a number, so
that nothing that a visitor wrote becomes a path.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from moireid.errors import MissingExtraError, SpecError
from moireid.extras import missing_extra

Got = TypeVar("Got")
#: Tries of each step of a storage, and the wait before the second, s; each further wait is twice as long.
TRIES, WAIT_S = 3, 0.5
JOB_ID = re.compile("[0-9a-f]{32}")


class StorageError(Exception):
    """A storage that fails; later it may not."""


class Folder:
    """The studio's own folder: films are judged where they came.

    `sent`: a film has come whole to the folder for films that come, from now on others may take it.  `at_work`: a
    context with a folder of this machine, in which the film is.  `keep`: keep these files of such a folder.  `file`: a
    context with a kept file, as one of this machine.  `drop`, `remove`: remove a film, or all of a job.  `ids`: the
    jobs that have files there.  Raises: StorageError where it cannot be reached; FileNotFoundError.
    """

    def __init__(self, root: Path) -> None:
        self._root = root

    def sent(self, job_id: str, name: str) -> None:
        """Nothing is to be done: it is there."""

    @contextmanager
    def at_work(self, job_id: str, name: str) -> Iterator[Path]:
        """The job's own folder."""
        folder = self._root / job_id
        if not (folder / name).is_file():
            raise StorageError("the film is gone")
        yield folder

    def keep(self, job_id: str, folder: Path, names: list[str]) -> None:
        """Nothing is to be done: they are there."""

    @contextmanager
    def file(self, job_id: str, name: str) -> Iterator[Path]:
        """Its own path."""
        yield self._root / job_id / name

    def drop(self, job_id: str, name: str) -> None:
        """Remove the film; a process may have put a folder in its place."""
        film = self._root / job_id / name
        try:
            film.unlink(missing_ok=True)
        except OSError:
            shutil.rmtree(film, ignore_errors=True)

    def remove(self, job_id: str) -> None:
        """Remove the job's folder."""
        shutil.rmtree(self._root / job_id, ignore_errors=True)

    def ids(self) -> list[str]:
        """The folders of jobs; others may be a user's own."""
        there = self._root.iterdir() if self._root.is_dir() else ()
        return [entry.name for entry in there if JOB_ID.fullmatch(entry.name)]

    def check(self) -> None:
        """Raises: StorageError where nothing can be written."""
        if self._root.is_dir() and not os.access(self._root, os.W_OK):
            raise StorageError("the folder cannot be written to")


class Remote:
    """A storage by its fsspec address, such as s3://bucket/films, with the methods of `Folder`; scratch: a folder of
    this machine for work.
    """

    def __init__(self, address: str, scratch: Path) -> None:
        """Raises: SpecError where the address cannot be used; MissingExtraError."""
        self._scratch = scratch
        try:
            from fsspec.core import url_to_fs
        except ImportError as error:
            raise missing_extra("a storage by its address", "fsspec", "cluster", "moireid-studio") from error
        advice = "give one such as s3://bucket/films, or file:///folder"
        try:
            # A listing that is kept would hide what others have put there.
            self._system, root = url_to_fs(address, use_listings_cache=False)
            self._root = str(root).rstrip("/")
        except ImportError as error:
            raise MissingExtraError(f"storage {address} needs a package that is not installed ({error})") from error
        # Each protocol's package has errors of its own without a common base.
        except Exception as error:
            raise SpecError(f"storage {address!r} cannot be used ({type(error).__name__}); {advice}") from error

    def sent(self, job_id: str, name: str) -> None:
        """Put the film there, and remove it here."""
        self._put(self._scratch / job_id / name, job_id)
        shutil.rmtree(self._scratch / job_id, ignore_errors=True)

    @contextmanager
    def at_work(self, job_id: str, name: str) -> Iterator[Path]:
        """A new folder with a copy of the film."""
        self._scratch.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f"{job_id}-", dir=self._scratch, ignore_cleanup_errors=True) as made:
            self._tried(lambda: self._system.get_file(self._at(job_id, name), f"{made}/{name}"))
            yield Path(made)

    def keep(self, job_id: str, folder: Path, names: list[str]) -> None:
        """Copy these files there."""
        for name in names:
            path = folder / name
            if path.is_file() and not path.is_symlink():
                self._put(path, job_id)

    @contextmanager
    def file(self, job_id: str, name: str) -> Iterator[Path]:
        """A copy of the file."""
        self._scratch.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="kept-", dir=self._scratch, ignore_cleanup_errors=True) as made:
            copy = Path(made) / "file"
            self._tried(lambda: self._system.get_file(self._at(job_id, name), str(copy)))
            yield copy

    def drop(self, job_id: str, name: str) -> None:
        """Remove the film there."""
        with suppress(FileNotFoundError):
            self._tried(lambda: self._system.rm_file(self._at(job_id, name)))

    def remove(self, job_id: str) -> None:
        """Remove the job's folder there, and here."""
        shutil.rmtree(self._scratch / job_id, ignore_errors=True)
        with suppress(FileNotFoundError):
            self._tried(lambda: self._system.rm(f"{self._root}/{job_id}", recursive=True))

    def ids(self) -> list[str]:
        """The folders of jobs there."""
        try:
            names = self._tried(lambda: self._system.ls(self._root, detail=False))
        except FileNotFoundError:
            return []
        ends = [str(name).rstrip("/").rpartition("/")[2] for name in names]
        return [end for end in ends if JOB_ID.fullmatch(end)]

    def check(self) -> None:
        """Raises: StorageError where it cannot be asked."""
        self._tried(lambda: self._system.exists(self._root), tries=1)

    def _at(self, job_id: str, name: str) -> str:
        return f"{self._root}/{job_id}/{name}"

    def _put(self, path: Path, job_id: str) -> None:
        """Put a file there, whole: it gets its name once it is there, or is put at once where the storage does so."""
        there = self._at(job_id, path.name)
        self._tried(lambda: self._system.makedirs(f"{self._root}/{job_id}", exist_ok=True))
        self._tried(lambda: self._system.put_file(str(path), there))

    def _tried(self, step: Callable[[], Got], tries: int = TRIES) -> Got:
        """What a step returns.  Raises: FileNotFoundError; StorageError after so many tries."""
        for number in range(tries):
            try:
                return step()
            except FileNotFoundError:
                raise
            # Any error of a protocol's package may be temporary.
            except Exception as error:
                if number + 1 == tries:
                    raise StorageError(f"the storage fails ({type(error).__name__})") from error
            time.sleep(WAIT_S * 2**number)
        raise StorageError("the storage was not asked")


#: Where the films of jobs are, and what is kept of them, each job by its id.
Storage = Folder | Remote


def storage_of(address: str | None, folder: Path) -> Storage:
    """The storage at an address; without one, the folder of this studio.  Raises: SpecError, MissingExtraError."""
    return Folder(folder) if address is None else Remote(address, folder)


#: What the pictures of our own process begin with, and the suffix of each kind.
SUFFIXES = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}


@dataclass(frozen=True)
class StoredPicture:
    """A picture: the name of its file, which is shown and compared and nothing else, and its bytes."""

    name: str
    data: bytes

    @property
    def suffix(self) -> str:
        """The suffix of a file with these bytes; empty where it is none of ours."""
        return next((suffix for begin, suffix in SUFFIXES.items() if self.data.startswith(begin)), "")


def unpacked(packed: zipfile.ZipFile) -> dict[str, StoredPicture]:
    """The pictures of an archive that we have made, by key."""
    listed = json.loads(packed.read("pictures.json"))
    return {key: StoredPicture(name, packed.read(f"pictures/{number}")) for number, (key, name) in enumerate(listed)}


def written(pictures: Mapping[str, StoredPicture], folder: Path) -> dict[str, Path]:
    """Write pictures into a new folder; returns their files by key."""
    folder.mkdir()
    files = {}
    for number, (key, one) in enumerate(pictures.items()):
        files[key] = folder / f"{number}{one.suffix}"
        files[key].write_bytes(one.data)
    return files
