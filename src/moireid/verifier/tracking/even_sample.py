"""An even sample of a film's frames, which is bounded for a film of unknown length."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

#: Most frames kept: all of 8 s at 60 frames a second, every second one of 16 s, and so on.
SAMPLE_FRAMES = 512


@dataclass
class EvenSample:
    """Keeps every `stride`-th item offered; if it is full, it drops every second one and doubles the stride.

    So once it has been full, it always holds more than half of `limit` items, evenly spread over all that were offered.
    """

    limit: int = SAMPLE_FRAMES
    stride: int = 1
    offered: int = 0
    items: list[NDArray[np.float32]] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    def offer(self, item: NDArray[np.float32]) -> None:
        """Offer the next item, which is kept or skipped."""
        if not self.numbers or self.offered - self.numbers[-1] >= self.stride:
            self.items.append(item)
            self.numbers.append(self.offered)
        self.offered += 1
        if len(self.items) > self.limit:
            self.items, self.numbers = self.items[::2], self.numbers[::2]
            self.stride *= 2

    def drop(self, count: int) -> None:
        """Forget the first `count` items offered; the rest are numbered from 0 again."""
        kept = [k for k, number in enumerate(self.numbers) if number >= count]
        self.items = [self.items[k] for k in kept]
        self.numbers = [self.numbers[k] - count for k in kept]
        self.offered -= count

    @property
    def places(self) -> NDArray[np.int64]:
        """Numbers of the items that are kept, (K,)."""
        return np.array(self.numbers, np.int64)
