"""Shapes in millimetres on a picture, in colour and with transparency.

Convention: board frame of `motion`, mm; colours are red, green, blue as "#rrggbb"; pictures are (rows, columns, 4) of
blue, green, red and opacity, 0 to 255.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Rect

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
#: Binary places of a pixel in coordinates for OpenCV.
FINE = 4


@dataclass(frozen=True)
class Layer:
    """A flat picture parallel to the badge: its depth and its upper left corner, mm; endless: its rim goes on."""

    picture: Picture
    depth_mm: float
    corner_mm: tuple[float, float]
    px_per_mm: float
    endless: bool = False


class Canvas:
    """A rectangle of a layer to draw on, transparent at first, or of one colour."""

    def __init__(self, rect_mm: Rect, px_per_mm: float, ground: str | None = None) -> None:
        self.rect_mm, self.px_per_mm = rect_mm, px_per_mm
        size = [round((rect_mm[2 + k] - rect_mm[k]) * px_per_mm) for k in (1, 0)]
        self.picture = np.zeros((*size, 4), np.uint8)
        if ground:
            self.picture[:] = _bgra(ground)

    def polygon(self, points_mm: Sequence[tuple[float, float]], colour: str, soft_mm: float = 0.0) -> None:
        """Fill a polygon; soft_mm: deviation of its blurred rim."""
        self._paint(np.array(points_mm, float), colour, soft_mm)

    def curve(self, points_mm: Sequence[tuple[float, float]], colour: str, soft_mm: float = 0.0) -> None:
        """Fill a closed smooth curve by its points (Chaikin's corner cutting)."""
        points = np.array(points_mm, float)
        for _ in range(4):
            after = np.roll(points, -1, axis=0)
            points = np.stack([0.75 * points + 0.25 * after, 0.25 * points + 0.75 * after], axis=1).reshape(-1, 2)
        self._paint(points, colour, soft_mm)

    def ellipse(
        self, middle_mm: tuple[float, float], half_mm: tuple[float, float], colour: str, soft_mm: float = 0.0
    ) -> None:
        """Fill an upright ellipse."""
        turn = np.linspace(0, 2 * np.pi, 73)[:-1, None]
        self._paint(np.array(middle_mm) + np.array(half_mm) * np.hstack([np.cos(turn), np.sin(turn)]), colour, soft_mm)

    def rect(self, rect_mm: Rect, colour: str, round_mm: float = 0.0, soft_mm: float = 0.0) -> None:
        """Fill a rectangle, its corners rounded."""
        x0, y0, x1, y1 = rect_mm
        r = min(round_mm, (x1 - x0) / 2, (y1 - y0) / 2)
        turn = np.linspace(0, np.pi / 2, 9)
        points = [
            np.column_stack([x + r * np.cos(turn + k * np.pi / 2), y + r * np.sin(turn + k * np.pi / 2)])
            for k, (x, y) in enumerate([(x1 - r, y1 - r), (x0 + r, y1 - r), (x0 + r, y0 + r), (x1 - r, y0 + r)])
        ]
        self._paint(np.concatenate(points), colour, soft_mm)

    def shade(self, factor: Array) -> None:
        """Multiply the colours by a factor that is broadcast to (rows, columns)."""
        even = np.broadcast_to(factor.astype(np.float32), self.picture.shape[:2])
        for k in range(3):
            self.picture[..., k] = cv2.multiply(self.picture[..., k], np.ascontiguousarray(even), dtype=cv2.CV_8U)

    def grain(self, seed: int, size_mm: tuple[float, float], strength: float) -> None:
        """Uneven brightness, as of cloth, wood or plaster: grains of a size, of standard deviation `strength`."""
        noise = np.random.default_rng(seed).standard_normal(self.picture.shape[:2], np.float32)
        # Coarse grains are blurred at a smaller size.
        wide, high = (max(size * self.px_per_mm, 0.3) for size in size_mm)
        coarse = max(1, int(min(wide, high) / 2))
        size = self.picture.shape[1::-1]
        noise = noise[: -(-size[1] // coarse), : -(-size[0] // coarse)]
        noise = cv2.resize(cv2.GaussianBlur(noise, (0, 0), wide / coarse, sigmaY=high / coarse), size)
        self.shade(1 + strength * noise / noise.std())

    def blur(self, by_mm: float) -> None:
        """Put the whole picture out of focus."""
        self.picture = np.asarray(cv2.GaussianBlur(self.picture, (0, 0), by_mm * self.px_per_mm), np.uint8)

    def across(self) -> Array:
        """Places of the columns, 0 to 1."""
        return (np.arange(self.picture.shape[1]) + 0.5) / self.picture.shape[1]

    def down(self) -> Array:
        """Places of the rows, (rows, 1), 0 to 1."""
        return ((np.arange(self.picture.shape[0]) + 0.5) / self.picture.shape[0])[:, None]

    def layer(self, depth_mm: float, *, endless: bool = False) -> Layer:
        """The finished layer."""
        return Layer(self.picture, depth_mm, self.rect_mm[:2], self.px_per_mm, endless)

    def _paint(self, outline_mm: Array, colour: str, soft_mm: float) -> None:
        """Lay a colour over what is within an outline (N, 2), mm."""
        points = (outline_mm - self.rect_mm[:2]) * self.px_per_mm - 0.5
        soft_px = soft_mm * self.px_per_mm
        room = math.ceil(3 * soft_px) + 2
        last = np.array(self.picture.shape[1::-1])
        low = np.clip(np.floor(points.min(axis=0)) - room, 0, last).astype(int)
        high = np.clip(np.ceil(points.max(axis=0)) + room, 0, last).astype(int)
        if np.any(high <= low):
            return
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), np.uint8)
        cv2.fillPoly(mask, [np.rint((points - low) * (1 << FINE)).astype(np.int32)], 255, cv2.LINE_AA, FINE)
        if soft_px:
            mask = np.asarray(cv2.GaussianBlur(mask, (0, 0), soft_px), np.uint8)
        bgra = _bgra(colour)
        share = mask.astype(np.float32)[..., None] * (bgra[3] / np.float32(255 * 255))
        part = self.picture[low[1] : high[1], low[0] : high[0]]
        under = part[..., 3:] / np.float32(255) * (1 - share)
        opacity = share + under
        part[..., :3] = np.rint((share * bgra[:3] + part[..., :3] * under) / np.maximum(opacity, np.float32(1e-6)))
        part[..., 3:] = np.rint(255 * opacity)


def _bgra(colour: str) -> NDArray[np.float32]:
    """Blue, green, red, opacity of #rrggbb or #rrggbbaa."""
    parts = [int(colour[k : k + 2], 16) for k in range(1, len(colour), 2)]
    return np.array([*parts[2::-1], parts[3] if len(parts) > 3 else 255], np.float32)
