"""A file that is opened once for several readers, so that all of them read the same file."""

from __future__ import annotations

import hashlib
import os
import threading
import weakref
from pathlib import Path

from moireid.errors import MediaError


class OpenedFile:
    """An open file.  It stays the same file even if another file takes over its path.

    It is closed when it is no longer referenced.
    Raises: OSError where it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream = path.open("rb", buffering=0)
        weakref.finalize(self, self._stream.close)
        self._lock = threading.Lock()
        self._state = self._stated()

    @property
    def size(self) -> int:
        """Size in bytes when it was opened."""
        return self._state[0]

    def read_at(self, place: int, count: int) -> bytes:
        """Up to `count` bytes from `place` on; b"" at the end."""
        with self._lock:
            self._stream.seek(place)
            return self._stream.read(count) or b""

    def reading(self) -> Reading:
        """A reader with its own position, at the beginning."""
        return Reading(self)

    def sha256(self) -> str:
        """Hex SHA-256 of the file.

        Raises: MediaError where it cannot be read, or was written to since it was opened.
        """
        reading = self.reading()
        digest = hashlib.sha256()
        try:
            while piece := reading.read(1 << 20):
                digest.update(piece)
        except OSError as error:
            raise MediaError(f"{self.path} cannot be read any more ({error}); copy it to this machine first") from error
        if self._stated() != self._state:
            raise MediaError(f"{self.path} changed while it was read; give a film that nobody writes to any more")
        return digest.hexdigest()

    def _stated(self) -> tuple[int, int]:
        """Size and time of the last change; renaming the file leaves both alone."""
        found = os.fstat(self._stream.fileno())
        return found.st_size, found.st_mtime_ns


class Reading:
    """A reader of an opened file with what libraries expect: read, seek, tell and a name."""

    def __init__(self, opened: OpenedFile) -> None:
        self._opened, self._place = opened, 0
        #: FFmpeg also uses the suffix of the name if the content does not settle the format.
        self.name = str(opened.path.absolute())

    def read(self, count: int) -> bytes:
        """The next bytes, up to `count`."""
        piece = self._opened.read_at(self._place, count)
        self._place += len(piece)
        return piece

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move to a position, counted from the beginning, from here or from the end."""
        origin = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._opened.size}[whence]
        self._place = origin + offset
        return self._place

    def tell(self) -> int:
        """The current position."""
        return self._place
