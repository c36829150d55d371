"""What the tracker asks of a search for pages, whatever they are found by."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from moireid.verifier.picture import Box, Picture

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
#: Homographies of the pages in a picture, and of those in its mirror image, in px of that image.
EitherWay = tuple[list[Array], list[Array]]


class PageFinder(Protocol):
    """Finds the pages of one layout; `MarkerFinder` says what each method does."""

    work_ns: float

    def pages_near(self, luma: Picture | Grey, page: Array, *, faint: bool = False) -> list[Array]: ...
    def either_way(self, luma: Picture | Grey, *, faint: bool = False) -> EitherWay: ...
    def enlarged(self, luma: Picture | Grey, box: Box) -> EitherWay: ...
    def around(self, page: Array, shape: tuple[int, ...]) -> Box | None: ...
    def closely(self, luma: Picture | Grey, page: Array) -> EitherWay: ...
    def near(self, luma: Picture | Grey, page: Array, *, faint: bool = False) -> EitherWay: ...
    def again(self, luma: Picture | Grey, page: Array) -> list[Array]: ...
    def glance(self, luma: Picture | Grey) -> list[Array]: ...
    def quick(self, luma: Picture | Grey) -> EitherWay: ...
