"""Work beside the rendering, and the seconds of each stage."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor


class Aside:
    """Encodes a frame while the next one is rendered; never more than one waits, so that memory stays flat."""

    def __init__(self) -> None:
        self._worker, self._last = ThreadPoolExecutor(1), Future[None]()
        self._last.set_result(None)

    def __enter__(self) -> Aside:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Wait for the frame that is being encoded, whatever became of it."""
        self._worker.shutdown()

    def run(self, work: Callable[[], None]) -> None:
        """Begin some work when the work before is done.  Raises: what that raised."""
        self._last.result()
        self._last = self._worker.submit(work)

    def finish(self) -> None:
        """Wait for the last of it.  Raises: what that raised."""
        self._last.result()


class Stages:
    """Seconds by stage; encoding is done beside the rest, and what is waited for it counts."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("estimate", "set up", "render", "sensor", "encode"), 0.0)
        self.least: dict[str, float] = {}
        self._clock = 0.0

    def begin(self) -> None:
        """Start the clock."""
        self._clock = time.perf_counter()

    def end(self, stage: str) -> None:
        """Count the time since the last call to a stage."""
        now = time.perf_counter()
        self.seconds[stage] += now - self._clock
        self.least[stage] = min(now - self._clock, self.least.get(stage, math.inf))
        self._clock = now
