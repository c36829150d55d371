"""Pictures of a page whose homography is known, drawn from OpenCV's marker bits: no template of ours enters."""

from __future__ import annotations

import cv2
import numpy as np

from moireid.badge import Markers
from moireid.verifier.tracking.patches import marker_corners_mm

MARKERS = Markers("DICT_4X4_50", 26.0, (0, 1, 2, 3), ((18.0, 18.0), (128.0, 22.0), (128.0, 150.0), (18.0, 150.0)))


WIDTH, HEIGHT = 480, 360


FINE = 6


def seen_from(*, px_per_mm=1.45, turn_deg=4.0, tilt=(2.0e-4, -1.3e-4), at=(120.0, 60.0)) -> np.ndarray:
    """A homography page mm -> px: scale, roll, perspective, and where the page's origin lies."""
    c, s = px_per_mm * np.cos(np.radians(turn_deg)), px_per_mm * np.sin(np.radians(turn_deg))
    return np.array([[c, -s, at[0]], [s, c * 1.03, at[1]], [*tilt, 1.0]]) @ np.eye(3)


def draw(homography: np.ndarray, markers: Markers = MARKERS, *, ink=60.0, paper=215.0, shape=(HEIGHT, WIDTH)):
    """The page's markers on white paper, each pixel averaged over its area; float counts."""
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, markers.dictionary))
    modules = known.markerSize + 2
    offset = (np.arange(FINE) + 0.5) / FINE - 0.5
    back = np.linalg.inv(homography)
    total = np.zeros(shape)
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    bits = [np.asarray(cv2.aruco.generateImageMarker(known, i, modules)) > 127 for i in markers.ids]
    for dy in offset:
        for dx in offset:
            w = back[2, 0] * (columns + dx) + back[2, 1] * (rows + dy) + back[2, 2]
            x = (back[0, 0] * (columns + dx) + back[0, 1] * (rows + dy) + back[0, 2]) / w
            y = (back[1, 0] * (columns + dx) + back[1, 1] * (rows + dy) + back[1, 2]) / w
            white = np.ones(shape, bool)
            for pattern, (cx, cy) in zip(bits, markers.centers_mm, strict=True):
                i = np.floor((x - cx) / markers.size_mm * modules + modules / 2).astype(int)
                j = np.floor((y - cy) / markers.size_mm * modules + modules / 2).astype(int)
                inside = (i >= 0) & (j >= 0) & (i < modules) & (j < modules)
                white[inside] = pattern[j[inside], i[inside]]
            total += white
    return ink + (paper - ink) * total / FINE**2


def filmed(picture: np.ndarray, rng: np.random.Generator | None = None, *, noise=0.0, blur=0.7) -> np.ndarray:
    soft = cv2.GaussianBlur(picture, (0, 0), blur)
    if rng is not None:
        soft = soft + noise * rng.standard_normal(soft.shape)
    return np.clip(np.rint(soft), 0, 255).astype(np.uint8)


def corners_px(homography: np.ndarray) -> np.ndarray:
    corners = marker_corners_mm(MARKERS).reshape(-1, 1, 2)
    return cv2.perspectiveTransform(corners, homography).reshape(-1, 2)


def apart_px(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square distance of the sixteen marker corners."""
    return float(np.sqrt(np.mean(np.sum((corners_px(one) - corners_px(other)) ** 2, axis=1))))


def nudged(homography: np.ndarray, dx: float, dy: float, grow: float = 1.0) -> np.ndarray:
    return np.array([[grow, 0, dx], [0, grow, dy], [0, 0, 1.0]]) @ homography


CORNERS = marker_corners_mm(MARKERS)
