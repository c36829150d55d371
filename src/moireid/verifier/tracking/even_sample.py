"""A sample of a film of unknown length that never outgrows its bound."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

#: Frames kept: 8 s at 60 frames a second whole, every second one of 16 s, and so on.
SAMPLE_FRAMES = 512


@dataclass
class EvenSample:
    """Every `stride`-th of the items offered; where there are too many, every second is dropped and the stride doubles.

    So after any number of items more than half of `limit` are held, evenly spread over all that were offered; places
    (K,): which of them.
    """

    limit: int = SAMPLE_FRAMES
    stride: int = 1
    offered: int = 0
    items: list[NDArray[np.float32]] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)

    def offer(self, item: NDArray[np.float32]) -> None:
        """Take the next item in, or pass it over."""
        if not self.numbers or self.offered - self.numbers[-1] >= self.stride:
            self.items.append(item)
            self.numbers.append(self.offered)
        self.offered += 1
        if len(self.items) > self.limit:
            self.items, self.numbers = self.items[::2], self.numbers[::2]
            self.stride *= 2

    def drop(self, count: int) -> None:
        """Forget the first `count` items offered; those that stay count from 0 again."""
        kept = [k for k, number in enumerate(self.numbers) if number >= count]
        self.items = [self.items[k] for k in kept]
        self.numbers = [self.numbers[k] - count for k in kept]
        self.offered -= count

    @property
    def places(self) -> NDArray[np.int64]:
        """Which of the items offered are held, (K,)."""
        return np.array(self.numbers, np.int64)
