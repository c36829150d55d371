"""Hours and grams of each printed mount, as a slicer found them for the default figures of a format.

`mount_times.csv` holds the rows of `moireid lab bench mounts`: a common printer (nozzle 0.4 mm,
layers 0.2 mm, PLA), without supports.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

TABLE = Path(__file__).with_name("mount_times.csv")
#: A slicer's words for a time, such as "1d 2h 3m 4s".
SECONDS = {"d": 86400, "h": 3600, "m": 60, "s": 1}


@dataclass(frozen=True)
class MountTime:
    """One mount: hours of printing and grams of plastic."""

    hours: float
    grams: float


def hours_of(words: str) -> float:
    """A slicer's time in hours.  Raises: ValueError for other words."""
    found = re.findall(r"(\d+)([dhms])", words)
    if not found or "".join(f"{number}{unit}" for number, unit in found) != words.replace(" ", ""):
        raise ValueError(f"{words!r} is no time of a slicer")
    return sum(int(number) * SECONDS[unit] for number, unit in found) / 3600


def time_words(hours: float) -> str:
    """Hours as "3 h 35 min", or as days where they are many."""
    if hours >= 48:
        return f"{hours:,.0f} h ({hours / 24:.1f} days)"
    minutes = round(60 * hours)
    return f"{minutes // 60} h {minutes % 60:02d} min"


@cache
def mount_times() -> dict[tuple[str, str], MountTime]:
    """By format and kind of mount; a mount that cannot be made for a format has no entry."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["time"]]
    return {(row["format"], row["mount"]): MountTime(hours_of(row["time"]), float(row["PLA, g"])) for row in rows}
