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
    """What became of one film.

    gain, correlation, window_correlation (mean over 30 frames): as measured; film_s, verify_s: seconds of its making
    and judging; tan_u: the views' ends.
    """

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
    correlation: float | None = None
    window_correlation: float | None = None


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
    lines += _spread("true", [row for row in rows if not row.forge])
    for row in sorted(rows, key=lambda row: (row.format, row.number)):
        if not (row.verdict == "reject" if row.forge else row.verdict == "accept" and row.read):
            lines.append(_told(row))
    return "\n".join(lines)


def _spread(name: str, own: list[Row]) -> list[str]:
    """How films of one kind lie: correlations, and the gain's distance from 1."""
    found = [row for row in own if None not in (row.correlation, row.window_correlation, row.gain)]
    if not found:
        return []
    whole, windows = (np.array([getattr(row, key) for row in found]) for key in ("correlation", "window_correlation"))
    off = np.array([row.gain or 0.0 for row in found]) - 1
    return [
        f"{name}: |rho| {whole.mean():.4f} ± {whole.std():.4f}, least {whole.min():.4f}; over 30 frames "
        f"{windows.mean():.3f} ± {windows.std():.3f}; gain off by {np.sqrt(np.mean(off**2)):.4f} (root mean square)"
    ]


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
