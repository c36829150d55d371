"""Cameras of this machine: pictures that this process takes itself."""

from __future__ import annotations

import time
from collections.abc import Iterator

import cv2

from moireid.errors import MediaError
from moireid_studio.watch.order import Shot

#: What a camera is asked for: 720p, at its own rate.
WIDTH, HEIGHT = 1280, 720
#: Pictures that may fail in a row before a camera is taken for gone.
MOST_FAILED = 30


def shots_of(number: int) -> Iterator[Shot]:
    """Pictures of a camera.

    Convention: the times are those of the camera where it gives any, else those of our clock.
    Raises: MediaError where it cannot be opened.
    """
    # Its own messages would appear among ours.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    camera = cv2.VideoCapture(number)
    try:
        if not camera.isOpened():
            raise MediaError(
                f"camera {number} cannot be opened; cameras are counted from 0, and one that another program uses, or "
                "that this user may not open, is not given"
            )
        camera.set(cv2.CAP_PROP_FRAME_WIDTH, WIDTH)
        camera.set(cv2.CAP_PROP_FRAME_HEIGHT, HEIGHT)
        failed = 0
        while failed < MOST_FAILED:
            read, picture = camera.read()
            now_s = time.monotonic()
            if not read or picture is None:
                failed += 1
                time.sleep(0.02)
                continue
            failed = 0
            yield shot(picture, taken_s(camera.get(cv2.CAP_PROP_POS_MSEC), now_s), now_s)
    finally:
        camera.release()


def taken_s(driver_ms: float, now_s: float) -> float:
    """When a camera took a picture, by its driver where that gives a time, else when it came, s."""
    return driver_ms / 1000 if driver_ms > 0 else now_s


def shot(picture: cv2.typing.MatLike, claimed_s: float, arrival_s: float) -> Shot:
    """A camera's picture, as the judge takes it."""
    grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    return Shot(grey.tobytes(), (grey.shape[0], grey.shape[1]), claimed_s, arrival_s)
