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

    So after any number of items more than half of `limit` are held, evenly spread over all that were offered.
    """

    limit: int = SAMPLE_FRAMES
    stride: int = 1
    offered: int = 0
    items: list[NDArray[np.float32]] = field(default_factory=list)

    @property
    def due(self) -> bool:
        """Whether the next item will be kept; one that is not due need not even be made."""
        return self.offered % self.stride == 0

    def offer(self, item: NDArray[np.float32]) -> None:
        """Take the next item in, or pass it over."""
        if self.due:
            self.items.append(item)
        self.offered += 1
        if len(self.items) > self.limit:
            self.items = self.items[::2]
            self.stride *= 2

    @property
    def places(self) -> NDArray[np.int64]:
        """Which of the items offered are held, (K,)."""
        return np.arange(len(self.items)) * self.stride
