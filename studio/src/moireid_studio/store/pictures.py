"""Pictures in an archive: as they are kept for their visitor, and as they go with an order to the process that prints.

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
class Picture:
    """A picture: the name of its file, which is shown and compared and nothing else, and its bytes."""

    name: str
    data: bytes

    @property
    def suffix(self) -> str:
        """The suffix of a file with these bytes; empty where it is none of ours."""
        return next((suffix for begin, suffix in SUFFIXES.items() if self.data.startswith(begin)), "")


def pack(packed: zipfile.ZipFile, pictures: Mapping[str, Picture]) -> None:
    """Put pictures into an archive, with a list of their keys and names."""
    packed.writestr("pictures.json", json.dumps([[key, one.name] for key, one in pictures.items()]))
    for number, one in enumerate(pictures.values()):
        packed.writestr(f"pictures/{number}", one.data)


def unpacked(packed: zipfile.ZipFile) -> dict[str, Picture]:
    """The pictures of an archive that we have made, by key."""
    told = json.loads(packed.read("pictures.json"))
    return {key: Picture(name, packed.read(f"pictures/{number}")) for number, (key, name) in enumerate(told)}


def written(pictures: Mapping[str, Picture], folder: Path) -> dict[str, Path]:
    """Write pictures into a new folder; returns their files by key."""
    folder.mkdir()
    files = {}
    for number, (key, one) in enumerate(pictures.items()):
        files[key] = folder / f"{number}{one.suffix}"
        files[key].write_bytes(one.data)
    return files
