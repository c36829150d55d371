"""STag squares of set HD11: what four of them look like, and the page through the corners that their detector gives."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Markers

Array = NDArray[np.float64]
Single = NDArray[np.float32]
#: Four words of STag's set HD11 with the corner that its detector names first, clockwise from the top left; and where
#: the dots of a quarter are: radius in units of the marker's half, and angle.
STAG = {
    16482: ("010100001010010111111001110010010100101001011000", 1),
    4662: ("110010111110010110000000110101111100110111000011", 2),
    4913: ("101101100010111101011010010111101101110000110000", 1),
    4101: ("100111100000111101010000110000111010011011011111", 2),
}
STAG_DOTS = (
    (0.1272, 45.0),
    (0.2980, 26.315),
    (0.2980, 63.685),
    (0.4517, 11.492),
    (0.4716, 33.901),
    (0.4716, 56.099),
    (0.4517, 78.508),
    (0.6299, 8.349),
    (0.6296, 24.830),
    (0.6201, 45.0),
    (0.6296, 65.170),
    (0.6299, 81.651),
)


def stag_page(corners: list[Array], ids: list[int], places: Markers) -> Array | None:
    """The page through the corners that STag gives, in its own order of each square."""
    page, image = [], []
    known = list(STAG)
    for quad, identity in zip(corners, ids, strict=True):
        if identity in known:
            index = known.index(identity)
            x, y = places.centers_mm[index]
            square = np.array([[-13.0, -13.0], [13.0, -13.0], [13.0, 13.0], [-13.0, 13.0]])
            page.append(np.add(np.roll(square, -STAG[identity][1], axis=0), (x, y)))
            image.append(np.reshape(quad, (4, 2)))
    if len(page) < 2:
        return None
    found, _ = cv2.findHomography(np.concatenate(page), np.concatenate(image), 0)
    return found


def stag_print(word: str, side: float, across: Array, down: Array) -> Single:
    """Brightness of a STag at offsets from its middle."""
    x, y = np.meshgrid(across / side, down / side)
    picture = ((x**2 + y**2 < 0.4**2) | (np.maximum(np.abs(x), np.abs(y)) > 0.5)).astype(np.float32)
    for index, bit in enumerate(word):
        radius, degrees = STAG_DOTS[index % 12]
        angle = math.radians(degrees + 90 * (index // 12))
        apart = (x - 0.5 * radius * math.cos(angle)) ** 2 + (y + 0.5 * radius * math.sin(angle)) ** 2
        picture[(bit == "1") & (apart < 0.045**2)] = 0.0
    return picture
