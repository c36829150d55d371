"""From radiance to 8-bit pictures: background, exposure, noise, encoding."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic import Rendered
from moireid.simulate.scene import Camera

#: Exposure drifts by this share over some seconds, as automatic exposure does.
EXPOSURE_DRIFT = 0.06
#: Share of the noise's variance that does not depend on the light (read noise).
READ_SHARE = 0.3
#: Standard deviation of lens and demosaicing blur, px.
BLUR_PX = 0.5


class Sensor:
    """Turns rendered boards into pictures; the random parts come from one seed."""

    def __init__(self, camera: Camera, seed: int) -> None:
        self._camera = camera
        self._rng = np.random.default_rng(seed)
        self._phase = self._rng.uniform(0, 2 * np.pi)
        height, width = camera.height, camera.width
        # Coarse and fine clouds, twice the picture's size, so that turning the camera shows other parts of them.
        clouds = [
            cv2.resize(
                self._rng.random(size).astype(np.float32), (2 * width, 2 * height), interpolation=cv2.INTER_CUBIC
            )
            for size in ((9, 16), (36, 64), (135, 240))
        ]
        self._world = 0.12 + 0.25 * (0.5 * clouds[0] + 0.3 * clouds[1] + 0.2 * clouds[2])
        # One field of noise, read from a random place each frame: drawing two million numbers a frame takes longer
        # than rendering the badge.
        self._noise = self._rng.standard_normal((height + 256, width + 256)).astype(np.float32)

    def expose(self, board: Rendered | None, rotation: NDArray[np.float64], time_s: float) -> NDArray[np.uint8]:
        """One picture (height, width) uint8.

        Convention: rotation board -> camera; the background is at infinity and turns with it.
        """
        camera = self._camera
        shift = np.array([[1, 0, camera.width / 2], [0, 1, camera.height / 2], [0, 0, 1.0]])
        to_world = shift @ camera.matrix @ rotation.T @ np.linalg.inv(camera.matrix)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        scene = cv2.warpPerspective(
            self._world, to_world, (camera.width, camera.height), flags=flags, borderMode=cv2.BORDER_REFLECT
        )
        if board is not None:
            rows = slice(board.top, board.top + board.radiance.shape[0])
            columns = slice(board.left, board.left + board.radiance.shape[1])
            behind = scene[rows, columns]
            scene[rows, columns] = behind + board.coverage * (board.radiance - behind)
            grown = (
                slice(max(board.top - 4, 0), rows.stop + 4), slice(max(board.left - 4, 0), columns.stop + 4)
            )  # fmt: skip
            scene[grown] = cv2.GaussianBlur(scene[grown], (0, 0), BLUR_PX)
        drift = 1 + EXPOSURE_DRIFT * np.sin(2 * np.pi * 0.17 * time_s + self._phase)
        # The square root stands for a camera's transfer curve; noise is added after it, where it is about even.
        picture = np.sqrt(np.clip(scene * np.float32(drift), 0.0, 1.0))
        place = self._rng.integers(0, 256, 2)
        field = self._noise[place[0] : place[0] + camera.height, place[1] : place[1] + camera.width]
        spread = camera.noise_counts * np.sqrt(READ_SHARE + (1 - READ_SHARE) * picture)
        return np.asarray(np.clip(picture * 255 + field * spread + 0.5, 0, 255).astype(np.uint8))
