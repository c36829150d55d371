"""An open file that several readers share: it is opened once, so that all of them read the same film."""

from __future__ import annotations

import hashlib
import os
import threading
import weakref
from pathlib import Path

from moireid.errors import MediaError
from moireid.files import open_regular


class OpenedFile:
    """An open file.  It stays the same file even if another file takes over its path.

    It is closed when it is no longer referenced.  Nothing that is written to it later is read.
    Raises: OSError where it cannot be opened, or is no regular file: a pipe or a device may never end.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stream = open_regular(path).detach()
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
            return self._stream.read(max(min(count, self.size - place), 0)) or b""

    def reading(self) -> FileReader:
        """A reader with its own position, at the beginning."""
        return FileReader(self)

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
            raise MediaError(f"{self.path} changed while it was read; give a film that is no longer written to")
        return digest.hexdigest()

    def _stated(self) -> tuple[int, int]:
        """Size and time of the last change; renaming the file leaves both alone."""
        found = os.fstat(self._stream.fileno())
        return found.st_size, found.st_mtime_ns


class FileReader:
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
