"""Writing files whole or not at all, and reading those of strangers no further than is meant.

A reader never sees half a file: the content goes to a temporary file in the same folder, reaches the disk, and then
gets the final name in one step.  `planned` checks all outputs before any work starts.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from io import BufferedReader, FileIO
from pathlib import Path

from moireid.errors import SpecError

#: Largest file that describes one thing, such as a badge or a camera: a board of two axes has 65 kB.
MOST_SMALL_BYTES = 4_000_000
#: Largest table, such as a motion or a list of people: 10,000 people of 6 kB each, or an hour's poses at 100 Hz.
MOST_TABLE_BYTES = 64_000_000

#: A file or folder, as public functions take one.
AnyPath = str | os.PathLike[str]


#: How files begin that are often handed in for others, and what they are.
_BEGINNINGS = (
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a photo (JPEG)"),
    (b"%PDF", "a PDF"),
    (b"PK\x03\x04", "an archive or a workbook"),
    (b"SQLite format 3", "a database"),
    (b"ID3", "sound (MP3)"),
    (b"OggS", "sound (Ogg)"),
    (b"fLaC", "sound (FLAC)"),
    (b"{", "JSON text"),
)


def kind_of_file(path: AnyPath) -> str | None:
    """What a file is that is not what was asked for, such as "a photo (JPEG)"; None where its beginning is not known.

    Source: the first bytes of the formats; sound in a RIFF file and photos of phones (HEIF) name themselves at byte 8.
    """
    path = as_path(path)
    if path.is_dir():
        return "a folder"
    try:
        with open_regular(path) as file:
            begin = file.read(16)
    except OSError:
        return None
    if begin[8:12] in (b"WAVE", b"heic", b"heix", b"mif1"):
        return "sound (WAV)" if begin[8:12] == b"WAVE" else "a photo (HEIF)"
    return next((what for first, what in _BEGINNINGS if begin.startswith(first)), None)


#: So much of a file is read at once.
READ_BYTES = 1 << 20


def as_path(given: AnyPath) -> Path:
    """The path that a caller gave as text or as a path.  Raises: SpecError for what is neither."""
    if not isinstance(given, (str, os.PathLike)) or not isinstance(named := os.fspath(given), str):
        raise SpecError(f"{given!r:.80} is no path; give a str or a pathlib.Path")
    if not named.strip():
        raise SpecError("the path is empty; name a file, or a folder, such as . for the present one")
    if "\0" in named:
        raise SpecError(f"{named!r:.80} is no path, as it holds the letter 0; give the name of a file")
    return Path(named)


def open_regular(path: AnyPath) -> BufferedReader[FileIO]:
    """A file of a user, open for reading.

    Raises: OSError where it cannot be opened, and for a pipe or device, which would be waited for, or has no end.
    """
    path = as_path(path)
    # Before it is opened too: opening a device may do something.
    _check_regular(path.stat())
    # Another file may have taken its place; one that is a pipe by now is not waited for.
    ways = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    file = BufferedReader(FileIO(os.open(path, ways)))
    try:
        _check_regular(os.fstat(file.fileno()))
    except BaseException:
        file.close()
        raise
    return file


def read_regular(path: AnyPath, most_bytes: int = MOST_SMALL_BYTES) -> bytes:
    """A small file of a user, whole.

    Raises: OSError as `open_regular`, and where it has more than `most_bytes`.
    """
    with open_regular(path) as file:
        # Not in one call: it would take memory for the most that may be there, not for what is.
        parts, left = [], most_bytes + 1
        while left > 0 and (part := file.read(min(left, READ_BYTES))):
            parts.append(part)
            left -= len(part)
        content = b"".join(parts)
    if len(content) > most_bytes:
        most = f"{most_bytes / 1e6:.0f} MB" if most_bytes >= 1e6 else f"{most_bytes / 1e3:.3g} kB"
        raise OSError(errno.EFBIG, f"it is larger than {most}")
    return content


def _check_regular(state: os.stat_result) -> None:
    if stat.S_ISDIR(state.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(state.st_mode):
        raise OSError(errno.EINVAL, "not a regular file")


def planned(
    paths: Iterable[Path], *, overwrite: bool, make_folders: bool = True, kept: Iterable[AnyPath | None] = ()
) -> None:
    """Check that every output can be written, before the work that makes it.

    Parameters: make_folders: create missing folders; otherwise nothing on the disk changes; kept: files that the work
    reads, which no output may replace, by whatever name; None: no file.
    Raises: SpecError if two outputs have one name, if a file exists and `overwrite` is false, if it is one of those
    kept, or if its folder cannot be created or written.
    """
    paths, inputs = list(paths), [as_path(one) for one in kept if one is not None]
    inputs = [one for one in inputs if one.exists()]
    twice = next((path for path, count in Counter(path.absolute() for path in paths).items() if count > 1), None)
    if twice is not None:
        raise SpecError(f"two outputs are given as {twice}; choose a name of its own for each")
    for path in paths:
        if path.is_dir():
            raise SpecError(f"{path} is a folder, but a file of that name is to be written; choose another output")
        if path.exists() and any(path.samefile(one) for one in inputs):
            raise SpecError(f"{path} is a file that is read here, and would be replaced; choose another output")
        if path.exists() and not overwrite:
            raise SpecError(f"{path} exists already; add overwrite=True to replace it, or choose another output")
    for folder in dict.fromkeys(path.parent for path in paths):
        check_folder(folder)
        if not make_folders:
            continue
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SpecError(f"folder {folder} cannot be made ({error.strerror}); choose another output") from error


def check_folder(folder: Path) -> None:
    """Raise SpecError where a folder is not there and cannot be made, or not without one next to the system's own."""
    try:
        above = next(step for step in (folder, *folder.absolute().parents) if step.exists())
    except OSError as error:
        raise SpecError(f"folder {folder} cannot be made ({error.strerror}); choose another output") from error
    if not above.is_dir():
        raise SpecError(f"folder {folder} cannot be made ({above} is a file); choose another output")
    if above != folder and above == Path(above.anchor):
        # A path that is not right; only an administrator could make it, and would not wish to.
        raise SpecError(f"folder {folder} is not there; make it first, or choose another output")
    if not os.access(above, os.W_OK | os.X_OK):
        raise SpecError(f"folder {above} is not writable; choose another output")


@contextmanager
def whole_file(path: AnyPath, *, private: bool = False) -> Iterator[Path]:
    """Yield a temporary path next to `path`, with its suffix; on success it is renamed to `path`, otherwise removed.

    The temporary file keeps the suffix, because writers choose their format by it.
    Parameters: private: only the file's owner may read it, from its first byte on.
    """
    path = as_path(path)
    temporary = path.parent / f".{path.stem[:40]}-{secrets.token_hex(8)}{path.suffix}"
    # The system applies the umask here.  Reading the umask would mean changing it, also for files of other threads.
    handle = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600 if private else 0o666)
    try:
        rights = stat.S_IMODE(os.fstat(handle).st_mode)
        os.close(handle)
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        # The writer may have replaced the file.  Otherwise nothing is to be done, and a sealed process may not chmod.
        if stat.S_IMODE(temporary.stat().st_mode) != rights:
            temporary.chmod(rights)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: AnyPath, text: str) -> None:
    """Write `text` as UTF-8 to `path`, whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


@contextmanager
def tidy_folders(folders: Iterable[Path]) -> Iterator[None]:
    """If the work inside fails, remove those of the folders, and of their parents, that it created."""
    absent = {step for folder in folders for step in (folder, *folder.parents) if not step.exists()}
    try:
        yield
    except BaseException:
        for step in sorted(absent, key=lambda one: len(one.parts), reverse=True):
            with suppress(OSError):
                step.rmdir()
        raise


def move_together(moves: Iterable[tuple[Path, Path]], gone: Iterable[Path] = ()) -> None:
    """Give files their final names, and remove others; if one step fails, everything is restored.

    Convention: old files are kept in the temporary folder of the new ones until all is done.
    Raises: OSError of the step that failed.
    """
    steps: list[tuple[Path, Path]] = []

    def move(source: Path, target: Path) -> None:
        source.replace(target)
        steps.append((source, target))

    moves, gone = list(moves), list(gone)
    if not moves:
        return
    kept = Path(tempfile.mkdtemp(prefix="old-", dir=moves[0][0].parent))
    try:
        for number, old in enumerate([target for _, target in moves if target.exists()] + gone):
            move(old, kept / str(number))
        for source, target in moves:
            move(source, target)
    except BaseException:
        for source, target in reversed(steps):
            target.replace(source)
        raise
