"""Badges of many people, for registries of a hundred thousand: designing each takes longer than all else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256

from moireid.badge import Badge


class People:
    """Badges of one layout, each with its own id, name and spacings."""

    def __init__(self, first: Badge, count: int) -> None:
        self._first, self._count = first, count

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[Badge]:
        grating = self._first.gratings[0]
        for number in range(self._count):
            digest = sha256(f"person {number}".encode()).digest()
            stretch = [1.0 + 0.01 * byte / 255 for byte in digest]
            cells = tuple(replace(c, pitch_mm=c.pitch_mm * stretch[k % 32]) for k, c in enumerate(grating.cells))
            gratings = (replace(grating, cells=cells),)
            yield replace(self._first, id=digest.hex()[:16], name=f"Person {number}", gratings=gratings)
