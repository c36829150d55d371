"""What became of films: rows that a stopped run leaves, and the tables."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np


@dataclass
class Row:
    """What became of one film; gain and phase of what was measured, seconds of its making and judging."""

    format: str
    number: int
    forge: str | None
    wear: str
    distance_m: float
    motion: str
    crf: int
    verdict: str
    read: bool
    wrong: bool
    gain: float | None
    reasons: list[str] = field(default_factory=list)
    film_s: float = 0.0
    verify_s: float = 0.0
    tan_u: tuple[float, float] = (0.0, 0.0)
    tracked: int = 0
    front: str | None = None


def known(path: Path | None) -> list[Row]:
    """Films judged by an earlier run that was stopped."""
    if path is None or not path.is_file():
        return []
    return [Row(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def add(row: Row, path: Path) -> None:
    """Append a row as a line of JSON."""
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(row)) + "\n")


def table(rows: list[Row], formats: Sequence[str]) -> str:
    """One line a format, for forgeries one a kind too, then each film that was not judged as it ought to be."""
    head = ("films", 6), ("read", 6), ("accepted", 10), ("open", 6), ("rejected", 10), ("worst gain", 12)
    lines = [f"{'':<12}" + "".join(f"{word:>{wide}}" for word, wide in (*head, ("film s", 8), ("verify s", 10)))]
    kinds = sorted({row.forge for row in rows if row.forge})
    for name in (*formats, *kinds):
        own = [row for row in rows if name in (row.format, row.forge)]
        if own:
            lines.append(_line(name, own))
    lines.append(f"wrong identities read: {sum(row.wrong for row in rows)}")
    for row in sorted(rows, key=lambda row: (row.format, row.number)):
        if not (row.verdict == "reject" if row.forge else row.verdict == "accept" and row.read):
            lines.append(_told(row))
    return "\n".join(lines)


def _line(name: str, own: list[Row]) -> str:
    """Counts, the gain furthest from 1, and mean processor seconds of films of one kind."""
    told = Counter(row.verdict for row in own)
    worst = max((row.gain for row in own if row.gain is not None), key=lambda gain: abs(gain - 1), default=float("nan"))
    seconds = np.mean([row.film_s for row in own]), np.mean([row.verify_s for row in own])
    return (
        f"{name:<12}{len(own):>6}{sum(row.read for row in own):>6}{told['accept']:>10}{told['inconclusive']:>6}"
        f"{told['reject']:>10}{worst:>12.3f}{seconds[0]:>8.1f}{seconds[1]:>10.1f}"
    )


def _told(row: Row) -> str:
    """One film with all that makes it again, and why it was judged so."""
    gain = "none" if row.gain is None else f"{row.gain:.3f}"
    identity = "read" if row.read else "WRONG IDENTITY" if row.wrong else "unread"
    why = "; ".join(told for told in row.reasons if "[pass]" not in told)
    return (
        f"  {row.format}{_way(row)} --only {row.number}: {row.forge or 'true'}, {row.distance_m} m, {row.motion}, "
        f"crf {row.crf}, tan u {row.tan_u[0]:.2f} to {row.tan_u[1]:.2f}, {row.tracked} frames, gain {gain}: "
        f"{row.verdict}, {identity}; {row.wear}; {why}"
    )


def _way(row: Row) -> str:
    """Options that ask for films of this row's kind."""
    return " --forgeries" if row.forge else f" --fronts {row.front}" if row.front else ""
