"""Pictures in archives: kept for their visitor, or with an order for the process that prints.

A picture has a key: what it is for, or the name by which a list calls it.  In the archive and in folders it bears a
number, so that nothing that a visitor wrote becomes a path.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

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
