"""Files by address: a plain path, file://, memory://, or s3://... where the package of the protocol is installed.

Convention: a plain path and file:// are read in place.  Other files are copied into a temporary folder, as the decoder
    opens no address.  The folder is removed when the film is done.
"""

from __future__ import annotations

import hashlib
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any

from moireid.errors import MediaError, MissingExtraError, MoireIdError, SpecError
from moireid.extras import missing_extra
from moireid.files import MOST_TABLE_BYTES, read_regular

#: Number of tries to fetch a file, and the wait before the second; each further wait is twice as long.
FETCHES, WAIT_S = 3, 0.5
CHUNK = 4 << 20


class FetchError(MediaError):
    """A film could not be fetched; a later try may succeed."""


def is_address(name: str) -> bool:
    """Whether a name is an address and not a plain path."""
    return "://" in name or "::" in name


def joined(base: str, name: str) -> str:
    """The address of a name relative to the folder of the file `base`."""
    if is_address(name) or Path(name).is_absolute():
        return name
    if not is_address(base):
        return str(Path(base).parent / name)
    inner, mark, outer = base.partition("::")
    return f"{inner.rpartition('/')[0]}/{name}{mark}{outer}"


def stamp(address: str) -> str:
    """A digest that changes with the file, made from its metadata, such as size, time or ETag.

    Raises: SpecError if there is no such file or no such protocol; MissingExtraError.
    """
    system, path = _system(address)
    with _as_spec_error(f"there is no film {address!r}", ADVICE):
        info = system.info(path)
    if info.get("type") == "directory":
        raise SpecError(f"there is no film {address!r} (it is a folder); {ADVICE}")
    return hashlib.sha256(str(sorted((name, str(value)) for name, value in info.items())).encode()).hexdigest()


def read_text(address: str) -> str:
    """The text of a small file, UTF-8.  Raises: SpecError where it cannot be read."""
    with _as_spec_error(f"{address} cannot be read", "write where it lies"):
        if is_address(address):
            system, path = _system(address)
            content = system.cat_file(path, end=MOST_TABLE_BYTES + 1)
        else:
            content = read_regular(Path(address), MOST_TABLE_BYTES)
    if len(content) > MOST_TABLE_BYTES:
        raise SpecError(f"{address} is larger than {MOST_TABLE_BYTES // 1_000_000} MB; give a smaller one")
    try:
        return str(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise SpecError(f"{address} is no text in UTF-8 ({error}); save it so") from error


@contextmanager
def fetched(address: str, *, most_mb: float, folder: str | None = None) -> Iterator[Path]:
    """Yield a path on this machine with the content of the file; a copy is removed afterwards.

    Parameters: most_mb: largest file that is copied, in millions of bytes; a file that is read in place has no limit.
        folder: for copies; None: the system's folder for temporary files.
    Raises: FetchError if it could not be fetched in `FETCHES` tries; MediaError if it is too large.
    """
    system, path = _system(address)
    if _is_local(system):
        yield Path(path)
        return
    with tempfile.TemporaryDirectory(prefix="moireid-film-", dir=folder, ignore_cleanup_errors=True) as made:
        suffix = PurePosixPath(path).suffix
        target = Path(made) / f"film{suffix if suffix[1:].isalnum() else ''}"
        for tries in range(FETCHES):
            try:
                _fetch(system, path, target, int(1e6 * most_mb), address)
                break
            except MediaError:
                raise
            # Any error of a protocol's package may be temporary.
            except Exception as error:
                if tries + 1 == FETCHES or isinstance(error, FileNotFoundError):
                    many = f"{tries + 1} times " if tries else ""
                    raise FetchError(f"{address} could {many}not be fetched ({_words(error)}); run again") from error
                time.sleep(WAIT_S * 2**tries)
        yield target


ADVICE = "write its path relative to the manifest, or an address such as s3://bucket/film.mp4"


def _system(address: str) -> tuple[Any, str]:
    """The file system of an address, and the path within it."""
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise missing_extra("a film by its address", "fsspec", "", "moireid-lab") from error
    # Not only for bad addresses: s3fs also needs a region or credentials here.
    with _as_spec_error(f"address {address!r} cannot be used", ADVICE):
        try:
            system, path = url_to_fs(address)
            return system, str(path)
        except ImportError as error:
            raise MissingExtraError(
                f"{address} needs a package that is not installed here ({_words(error)})"
            ) from error


@contextmanager
def _as_spec_error(what: str, advice: str) -> Iterator[None]:
    """Turn any error of a protocol's package into a SpecError; our own errors pass.

    Each package has its own errors without a common base, and none of them is a fault of ours.
    """
    try:
        yield
    except MoireIdError:
        raise
    except Exception as error:
        raise SpecError(f"{what} ({_words(error)}); {advice}") from error


def _is_local(system: Any) -> bool:
    from fsspec.implementations.local import LocalFileSystem

    return isinstance(system, LocalFileSystem)


def _fetch(system: Any, path: str, target: Path, most: int, address: str) -> None:
    """Copy a file; the limit also holds if the file is larger than its storage says."""
    limit = f"more than the {most / 1e6:g} MB allowed; raise --film-limit"
    if (system.info(path).get("size") or 0) > most:
        raise MediaError(f"{address} has {limit}", most_bytes=most)
    taken = 0
    with system.open(path, "rb") as source, target.open("wb") as copy:
        while chunk := source.read(CHUNK):
            taken += len(chunk)
            if taken > most:
                raise MediaError(f"{address} has {limit}", most_bytes=most)
            copy.write(chunk)


def _words(error: Exception) -> str:
    """The message of another package's error, as part of a sentence."""
    message = getattr(error, "strerror", None) or " ".join(str(error).split())[:200] or type(error).__name__
    return "no such file" if isinstance(error, FileNotFoundError) else str(message)
