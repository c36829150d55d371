"""The search for pages of one layout in a picture, by its squares or by its frame.

A whole picture is searched until a badge is found, and then only its neighbourhood: a search of the whole picture costs
ten times the rest of the work.  What is small is found only where the picture is enlarged, which costs some six times
as much.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Fiducial
from moireid.verifier.picture import Box, Picture, as_picture
from moireid.verifier.tracking.patches import marker_corners_mm

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
#: Homographies of the pages in a picture, and of those in its mirror image, in px of that image.
EitherWay = tuple[list[Array], list[Array]]
#: Margin of the neighbourhood, as a share of the page's size: the motion between two frames that it allows.
NEIGHBOURHOOD = 0.5


class PicturePart(NamedTuple):
    """A part of a picture of so many columns: its own picture, scaled, and its top left pixel.

    contrast: steps of the picture's values for one count.
    """

    picture: Grey
    width: int
    corner: tuple[int, int] = (0, 0)
    scale: float = 1.0
    contrast: float = 1.0

    def steps(self, counts: float) -> float:
        """A difference in counts, in steps of the picture's values; whole ones, as OpenCV takes them."""
        return counts if self.contrast == 1 else float(max(round(math.floor(counts) * self.contrast), 1))

    def whole_px(self, places: Array) -> Array:
        """Places (N, 2) of the part, in px of the whole picture.

        Source: scaling keeps pixel edges, not centres, in place: x' + 0.5 = scale (x + 0.5).
        """
        return np.asarray((places + 0.5) / self.scale - 0.5 + self.corner)


class PageFinder(ABC):
    """Finds pages by the print of one layout; between pictures it keeps only `work_ns`, the work of all searches.

    Convention: homographies page mm -> image px, (3, 3) with h33 = 1; the centre of the top left pixel is (0, 0).
    """

    #: Shortest side of a part that is searched, px; and most pixels of one that is enlarged around a page.
    least_px: ClassVar[float]
    most_enlarged_px2: ClassVar[float] = math.inf
    #: Shares of decoding that quick and close looks at the whole picture may cost.
    quick_share: ClassVar[float]
    close_share: ClassVar[float] = 0.10

    def __init__(self, fiducial: Fiducial, outline_mm: Array, usual: Any, faint: Any, small: Any) -> None:
        """Parameters: outline_mm (N, 2): of the print; usual, faint, small: how to search it, also faded or small."""
        self._corners_mm, self._outline_mm = marker_corners_mm(fiducial), outline_mm
        self._usual, self._faint, self._small = usual, faint, small
        self.work_ns = 0.0

    def pages(self, luma: Picture | Grey, *, faint: bool = False) -> list[Array]:
        """Homographies of all pages in the picture, the clearest first.

        Parameters: faint: also look for faded print, which takes longer.
        """
        return self.either_way(luma, faint=faint)[0]

    def either_way(self, luma: Picture | Grey, *, faint: bool = False) -> EitherWay:
        """As `pages`, and also the mirrored pages."""
        if not faint:
            return self._found_by(self._usual, self._whole(luma))
        return self._find_in(luma, (0, 0, luma.shape[1], luma.shape[0]), self._faint)

    def enlarged(self, luma: Picture | Grey, box: Box) -> EitherWay:
        """As `either_way`, for small print in a part of the picture."""
        return self._find_in(luma, box, self._small, enlarge=True)

    def around(self, page: Array, shape: tuple[int, ...]) -> Box | None:
        """The neighbourhood of a page if its print is so small that enlarging helps; otherwise None."""
        return self._neighbourhood(shape, page) if self._is_small(page) else None

    def closely(self, luma: Picture | Grey, page: Array) -> EitherWay:
        """As `near`, as small print is searched; for a page that was just lost, or for what may be a page."""
        box = self._neighbourhood(luma.shape, page)
        return self._find_in(luma, box, self._small, enlarge=self._is_small(page), before=page)

    def near(self, luma: Picture | Grey, page: Array, *, faint: bool = False) -> EitherWay:
        """As `either_way`, but only in the neighbourhood of the page in a recent frame."""
        x0, y0, x1, y1 = box = self._neighbourhood(luma.shape, page)
        small = self._is_small(page) and (x1 - x0) * (y1 - y0) < self.most_enlarged_px2
        how = self._small if small else self._usual
        return self._find_in(luma, box, self._faint if faint else how, enlarge=small, before=page)

    def again(self, luma: Picture | Grey, page: Array) -> list[Array]:
        """Pages within some pixels of where one is expected; none of squares, as registration finds these by itself."""
        return []

    @abstractmethod
    def quick(self, luma: Picture | Grey) -> EitherWay:
        """As `either_way`, but only for clear print; faster."""

    @abstractmethod
    def _is_small(self, page: Array) -> bool:
        """Whether the print of a page is so small that enlarging helps."""

    @abstractmethod
    def _found_by(self, how: Any, part: PicturePart, before: Array | None = None) -> EitherWay:
        """Pages in a part of a picture, in px of the picture; before: a page of a recent frame there."""

    def _find_in(
        self, luma: Picture | Grey, box: Box, how: Any, *, enlarge: bool = False, before: Array | None = None
    ) -> EitherWay:
        """Pages in a part of the frame, which is enlarged twofold if `enlarge`."""
        x0, y0, x1, y1 = box
        if x1 - x0 < self.least_px or y1 - y0 < self.least_px:
            return [], []
        crop, scale = as_picture(luma).part(box), 1.0
        if enlarge:
            scale = 2.0
            crop = np.asarray(cv2.resize(crop, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC))
        return self._found_by(how, PicturePart(crop, luma.shape[1], (x0, y0), scale), before)

    def _whole(self, luma: Picture | Grey) -> PicturePart:
        return self._part(luma, (0, 0, luma.shape[1], luma.shape[0]))

    def _part(self, luma: Picture | Grey, box: Box) -> PicturePart:
        """A part of the picture, as it was coded if differences are all that counts; turning a whole one into counts
        costs a fifth of decoding.  Faint print needs the finer counts.
        """
        picture = as_picture(luma)
        if not picture.contrast:
            return PicturePart(picture.part(box), luma.shape[1], box[:2])
        return PicturePart(picture.coded(box), luma.shape[1], box[:2], contrast=picture.contrast)

    def _neighbourhood(self, shape: tuple[int, ...], page: Array, margin: float = NEIGHBOURHOOD) -> Box:
        corners = cv2.perspectiveTransform(self._outline_mm.reshape(-1, 1, 2), page).reshape(-1, 2)
        low, high = corners.min(axis=0), corners.max(axis=0)
        grow = margin * (high - low).max()
        x0, y0 = np.maximum(np.floor(low - grow), 0).astype(int)
        x1, y1 = np.minimum(np.ceil(high + grow), (shape[1], shape[0])).astype(int)
        return int(x0), int(y0), int(x1), int(y1)
