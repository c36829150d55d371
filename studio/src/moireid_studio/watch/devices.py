"""Cameras of this machine, and its screen: pictures that this process takes itself."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator

import cv2

from moireid.errors import MediaError, SpecError
from moireid_studio.watch.order import Shot
from moireid_studio.watch.readers import small_enough
from moireid_studio.watch.source import SCREEN, Source

#: What a camera is asked for: 720p, at its own rate.
WIDTH, HEIGHT = 1280, 720
#: Pictures of the screen a second, and how many may fail in a row before a camera is taken for gone.
SCREEN_FPS, MOST_FAILED = 30, 30


def shots_of(source: Source) -> Iterator[Shot]:
    """Pictures of a camera or of the screen.

    Convention: the times are those of the device where it gives any, else those of our clock.
    Raises: MediaError where it cannot be opened, or gives no picture; SpecError where this system has no such thing.
    """
    return _camera(int(source.text)) if source.kind == "camera" else _screen(source.text)


def _camera(number: int) -> Iterator[Shot]:
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


def _screen(text: str) -> Iterator[Shot]:
    """The screen, or one window by its number, as the X server shows it."""
    import av

    named = SCREEN.fullmatch(text)
    assert named is not None
    display = _display()
    options = {"framerate": str(SCREEN_FPS), "draw_mouse": "0"}
    if named["window"]:
        options["window_id"] = named["window"]
    try:
        with av.open(display, format="x11grab", options=options) as container:
            for decoded in container.decode(video=0):
                luma = small_enough(decoded).whole
                # The library stamps each picture with the time of day at which it was taken.
                claimed_s = float(decoded.time if decoded.time is not None else time.time())
                yield Shot(luma.tobytes(), (luma.shape[0], luma.shape[1]), claimed_s, time.monotonic())
    except (av.error.FFmpegError, OSError, ValueError) as error:
        what = f"window {named['window']}" if named["window"] else "the screen"
        words = str(getattr(error, "strerror", None) or error)[:160]
        raise MediaError(
            f"{what} cannot be read ({words}); it must be shown whole, and `xwininfo` shows a window's number"
        ) from error


def _display() -> str:
    """The X server's name.  Raises: SpecError where there is none, or it does not show the screen."""
    instead = "open a camera, a file or an address, or use the studio's page"
    if sys.platform != "linux":
        raise SpecError(f"the screen is read by X11, which this system does not have; {instead}")
    if os.environ.get("WAYLAND_DISPLAY"):
        raise SpecError(f"this desktop is Wayland, which shows no program the screen unasked; {instead}")
    if not (display := os.environ.get("DISPLAY")):
        raise SpecError(f"there is no screen here, as DISPLAY is not set; {instead}")
    return display
