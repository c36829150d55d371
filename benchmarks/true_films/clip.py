"""A film as pictures of the board: straightened by the markers' homographies, each with the view that it shows."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.badge import Badge
from moireid.simulate.filming import film
from moireid.simulate.forgeries.rear_layer import SquaredUp
from moireid.simulate.motion import Motion
from moireid.simulate.scene import Camera, Scene

Array = NDArray[np.float64]
Picture = NDArray[np.float32]
#: Fineness of the board's pictures; a camera of 1450 px focal length sees 1.5 px to the mm at 1 m.
PX_PER_MM = 3.0
#: A public clip is of this quality, and filmed so.
CLIP_CAMERA, CRF, FPS = Camera(shutter_s=0.0), 20, 30


@dataclass(frozen=True)
class Clip:
    """pictures (N, rows, columns): of the board, 0 to 255; views (N, 3)."""

    pictures: NDArray[np.uint8]
    views: Array

    def picture(self, number: int) -> Picture:
        """One of them, in coded brightness, 0 to 1."""
        return self.pictures[number].astype(np.float32) / np.float32(255)


def views_of(motion: Motion, times_s: Array) -> Array:
    """The views (T, 3) of a trajectory."""
    camera_mm = motion(times_s).camera_mm
    away = np.abs(camera_mm[:, 2:])
    return np.column_stack([camera_mm[:, :2] / away, away])


def board_to_page(badge: Badge) -> Array:
    """Places in a picture of the board, px, to places on the page, mm, (3, 3)."""
    left, top, right, _ = badge.outline_mm
    step = (right - left) / round((right - left) * PX_PER_MM)
    return np.array([[step, 0, left + step / 2], [0, step, top + step / 2], [0, 0, 1.0]])


def board_size(badge: Badge) -> tuple[int, int]:
    """Columns and rows of a picture of the board."""
    left, top, right, bottom = badge.outline_mm
    return round((right - left) * PX_PER_MM), round((bottom - top) * PX_PER_MM)


def filmed_clip(scene: Scene, motion: Motion, frames: int, seed: int) -> Clip:
    """A true film of the scene, by `CLIP_CAMERA`, through the coder, as pictures of the board."""
    places: list[Array] = []

    def kept(frame: int, luma: NDArray[np.uint8], homography: Array) -> NDArray[np.uint8]:
        places.append(homography)
        return luma

    badge, pictures = scene.badge, []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        of_clip = replace(scene, camera=CLIP_CAMERA)
        film(of_clip, motion, path, frames=frames, fps=FPS, edit=kept, seed=seed, crf=CRF)
        for luma, homography in zip(_lumas(path), places, strict=True):
            whole = homography @ board_to_page(badge)
            flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
            pictures.append(cv2.warpPerspective(luma, whole, board_size(badge), flags=flags))
    return Clip(np.array(pictures), views_of(motion, np.arange(frames) / FPS))


def _lumas(path: Path) -> Iterator[NDArray[np.uint8]]:
    """Brightness of each frame of a film, 0 to 255."""
    with av.open(str(path)) as container:
        for frame in container.decode(video=0):
            luma = frame.to_ndarray()[: frame.height].astype(np.float32)
            yield np.clip(np.rint((luma - 16) * 255 / 219), 0, 255).astype(np.uint8)


def print_of(scene: Scene, distance_mm: float) -> Picture:
    """The board as a camera right before it sees it, in coded brightness."""
    return np.asarray(np.sqrt(SquaredUp(scene, PX_PER_MM).picture(np.array([0.0, 0.0, -distance_mm]))), np.float32)
