"""Why a live check has too few pictures: the machine judges them too slowly, or they come too slowly.

The time that goes into judging is measured, picture by picture; the rest is waiting for pictures.  A machine that needs
longer for one than there is between two at `WANTED_RATE` cannot follow, however fast the connection is.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

#: Pictures a second with which the motion is followed well, and with fewer than which it is not.
WANTED_RATE, POOR_RATE = 24.0, 15.0
#: The time that there is for one picture, ms.
MOST_MS = 1000 / WANTED_RATE
#: So many pictures are needed for a mean.
LEAST_PICTURES = 24


class Load:
    """Time spent on judging, and pictures that came, of one session."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._first_s: float | None = None
        self._last_s = self.judged_s = 0.0
        self.pictures = 0

    @contextmanager
    def judging(self, *, pictures: int = 1) -> Iterator[None]:
        """Count what is done meanwhile as judging so many pictures; 0 for a part of the work on one."""
        begun_s = self._now()
        if self._first_s is None:
            self._first_s = begun_s
        try:
            yield
        finally:
            self._last_s = self._now()
            self.judged_s += self._last_s - begun_s
            self.pictures += pictures

    def to_json(self) -> dict[str, float] | None:
        """Mean time to judge a picture, ms, and pictures that came in a second; None after too few for a mean."""
        lasted_s = self._last_s - (self._first_s or 0.0)
        if self.pictures < LEAST_PICTURES or lasted_s <= 0:
            return None
        rate = self.pictures / lasted_s
        return {"judging_ms": round(1000 * self.judged_s / self.pictures, 1), "pictures_per_s": round(rate, 1)}


def load_advice(load: object) -> str | None:
    """What to do about few pictures, by what was measured; None where enough came, and were judged in time.

    Parameters: load: as `Load.to_json` states it, from a process whose word is checked here.
    """
    if not isinstance(load, Mapping):
        return None
    judging_ms, rate = _figure(load, "judging_ms"), _figure(load, "pictures_per_s")
    if judging_ms > MOST_MS:
        return (
            f"Judging a picture took {judging_ms:.0f} ms, longer than the {MOST_MS:.0f} ms that there are: the "
            "processor of the machine that judges is busy. Close other programs on it, or use a smaller picture."
        )
    if 0 < rate < POOR_RATE:
        return (
            f"Only {rate:.0f} pictures a second came, and each was judged in {judging_ms:.0f} ms: camera or connection "
            "are slow. Use more light, another camera, a faster connection or a smaller picture."
        )
    return None


def _figure(load: Mapping[Any, Any], name: str) -> float:
    value = load.get(name)
    return float(value) if isinstance(value, int | float) and 0 <= value < 1e6 else 0.0
