"""What an editor or an everyday mishap does to a finished picture of the badge, in picture pixels.

Convention: an edit takes the frame's number, its picture (height, width) uint8 and the homography page mm -> px of the
middle row, and gives the picture back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge, Rect

Array = NDArray[np.float64]
Luma = NDArray[np.uint8]
Edit = Callable[[int, Luma, Array], Luma]


def covered(polygon_mm: Callable[[int], Array | None], shade: float = 118.0, seed: int = 0) -> Edit:
    """Something opaque before the badge, a hand say.  polygon_mm: outline (N, 2) page mm of each frame, or None."""
    grain = np.random.default_rng(seed).normal(0, 1, (270, 480)).astype(np.float32)
    skin = shade + 25 * cv2.resize(cv2.GaussianBlur(grain, (0, 0), 6), (1920, 1080)) * 6

    def edit(frame: int, luma: Luma, homography: Array) -> Luma:
        outline = polygon_mm(frame)
        if outline is None:
            return luma
        places = cv2.perspectiveTransform(outline.reshape(-1, 1, 2).astype(float), homography)
        mask = np.zeros(luma.shape, np.float32)
        cv2.fillPoly(mask, [np.round(places * 16).astype(np.int32)], 1.0, cv2.LINE_AA, 4)
        mask = cv2.GaussianBlur(mask, (0, 0), 1.0)
        covered = luma * (1 - mask) + mask * skin[: luma.shape[0], : luma.shape[1]]
        return np.asarray(np.clip(covered, 0, 255), np.uint8)

    return edit


def hand_over(badge: Badge, share: float, *, start: int, frames: int) -> Edit:
    """A hand that comes from the right over `share` of the gratings, for so many frames."""
    x0, y0, x1, y1 = field_of(badge)

    def outline(frame: int) -> Array | None:
        if not start <= frame < start + frames:
            return None
        # It comes and goes within a fifth of its time.
        ease = min(1.0, 5 * (frame - start + 1) / frames, 5 * (start + frames - frame) / frames)
        left = x1 - share * ease * (x1 - x0)
        top, bottom = y0 + 0.04 * (y1 - y0), y1 - 0.04 * (y1 - y0)
        return np.array([[left + 4, top], [left, (top + bottom) / 2], [left + 5, bottom], [x1, bottom], [x1, top]])

    return covered(outline)


def fingers_on(badge: Badge, share: float, seed: int) -> Edit:
    """Two fingers that hold the badge by its lower edge all the time and shift a little."""
    x0, y0, x1, y1 = field_of(badge)
    rng = np.random.default_rng(seed)
    middle, high = rng.uniform(0.3, 0.7), share / 0.3

    def outline(frame: int) -> Array | None:
        x = x0 + (middle + 0.02 * np.sin(frame / 17)) * (x1 - x0)
        half, top = 0.15 * (x1 - x0), y1 - high * (y1 - y0)
        return np.array([[x - half, y1], [x - 0.8 * half, top], [x + 0.8 * half, top + 3], [x + half, y1]])

    return covered(outline, seed=seed)


def caption(text: str, at: tuple[float, float], height_px: int) -> Edit:
    """A subtitle over the picture, at a fixed place: white letters on a dark bar, at shares of width and height."""

    def edit(frame: int, luma: Luma, homography: Array) -> Luma:
        out = luma.copy()
        rows, columns = luma.shape
        y, x = round(at[1] * rows), round(at[0] * columns)
        scale = height_px / 30
        (width, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 2)
        cv2.rectangle(out, (x - width // 2 - 8, y - height_px), (x + width // 2 + 8, y + height_px // 3), 22, -1)
        cv2.putText(out, text, (x - width // 2, y), cv2.FONT_HERSHEY_SIMPLEX, scale, 235, 2, cv2.LINE_AA)
        return out

    return edit


def caption_on(badge: Badge, rect: Rect, text: str = "Live from the conference") -> Edit:
    """A caption that follows the badge: opaque letters over a part of the page."""
    x0, y0, x1, y1 = rect

    def edit(frame: int, luma: Luma, homography: Array) -> Luma:
        art = np.full((round(6 * (y1 - y0)), round(6 * (x1 - x0))), 22, np.uint8)
        cv2.putText(art, text, (6, art.shape[0] - 12), cv2.FONT_HERSHEY_SIMPLEX, art.shape[0] / 48, 235, 2, cv2.LINE_AA)
        place = homography @ np.array([[1 / 6, 0, x0], [0, 1 / 6, y0], [0, 0, 1]])
        size = luma.shape[1], luma.shape[0]
        cover = cv2.warpPerspective(np.full_like(art, 255), place, size)
        return np.where(cover > 127, cv2.warpPerspective(art, place, size), luma).astype(np.uint8)

    return edit


@dataclass(frozen=True)
class ShiftedMarkers:
    """Markers moved aside by `shift_px`, two each way, in some frames: their poses look misregistered there."""

    badge: Badge
    shift_px: float
    within: Callable[[int], bool]

    def __call__(self, frame: int, luma: Luma, homography: Array) -> Luma:
        """The picture with two markers moved apart."""
        if not self.within(frame):
            return luma
        out = luma.copy()
        # With a part of the white around it, and no fringes.
        reach = 0.65 * self.badge.squares.size_mm
        for number, (x, y) in enumerate(self.badge.squares.centers_mm):
            square = np.array(
                [[[x + a * reach, y + b * reach]] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], float
            )
            left, top, width, height = cv2.boundingRect(
                np.round(cv2.perspectiveTransform(square, homography)).astype(np.int32)
            )
            # A marker at the picture's edge is moved as far as it is seen; a negative index would count from the end.
            seen = slice(max(top, 0), max(top + height, 0)), slice(max(left, 0), max(left + width, 0))
            part = luma[seen]
            if not part.size:
                continue
            moved = np.array([[1, 0, self.shift_px if number in (0, 2) else -self.shift_px], [0, 1, 0]], float)
            out[seen] = cv2.warpAffine(part, moved, (part.shape[1], part.shape[0]), borderMode=cv2.BORDER_REPLICATE)
        return out


def field_of(badge: Badge) -> Rect:
    """The rectangle around all gratings, page mm."""
    rects = np.array([grating.rect_mm for grating in badge.gratings])
    return (*rects[:, :2].min(axis=0).tolist(), *rects[:, 2:].max(axis=0).tolist())
