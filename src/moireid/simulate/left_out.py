"""What a film leaves out, and the seconds saved by that in each frame.

Measuring must not slow the film.  So most figures are computed from times that are known anyway (the estimate's and
the sensor's) and from counts of pixels or instants; each figure says how it was found.  `moireid bench simulate`
measures them: it renders with and without each thing, and prints how much the picture and the phase change.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from moireid.simulate.analytic.accuracy import Estimate
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, board_box
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Instant, Need, Scene

__all__ = ["LeftOut", "left_out"]

#: A printed mount shows a rim of about this width around the board.
MOUNT_RIM_MM = 4.0
#: A frame is timed this many times: the least time counts, and the range of all is the noise.
RUNS = 3
NOT_MEASURED = "not known here; moireid bench simulate measures it"


@dataclass(frozen=True)
class LeftOut:
    """One thing that no frame shows.

    what: its name; saved_s: seconds saved in each frame, None where that is not known, 0 where it does not exceed the
    noise; how: these were found; noise_s: how far timings of the same work differ, s, 0 for what was not timed.
    """

    what: str
    saved_s: float | None
    how: str
    noise_s: float = 0.0


def timed(what: str, saved_s: float, noise_s: float, how: str) -> LeftOut:
    """A thing whose seconds are a difference of two timings, which is no saving where it is within their noise."""
    return LeftOut(what, saved_s if saved_s > noise_s else 0.0, how, noise_s)


def left_out(
    scene: Scene, backend: str, estimate: Estimate, instant: Instant, *, exposed: Instant, sensor_s: float
) -> tuple[LeftOut, ...]:
    """All that a film leaves out.

    Parameters: estimate: of the film's setting, with the time of a frame; instant: a true frame of the film; exposed:
        the same with its exposure, as if the shutter were shown; sensor_s: the sensor's time for a frame.
    Convention: a thing that costs nothing saves 0.
    Source: module docstring.
    """
    per_px = estimate.frame_s / max(estimate.pixels, 1)
    half_x, half_y = scene.board_half_mm
    rim = MOUNT_RIM_MM * (half_x + half_y + MOUNT_RIM_MM) / (half_x * half_y)
    by_pixels = "estimated: its pixels, each as dear as one of the badge's"
    found = [
        _off_badge(scene, backend, estimate, instant),
        timed(
            _fineness(estimate),
            estimate.finer_s - estimate.frame_s,
            estimate.noise_s,
            "measured: the estimate's finer frames",
        ),
        LeftOut("colour", 2 * sensor_s, "estimated: two channels more for the sensor"),
        LeftOut("the printed name", 0.0, "its pixels are rendered, as paper"),
        LeftOut("the mount", rim * _board_px(scene, instant) * per_px, by_pixels),
    ]
    if scene.light is None:
        found.append(LeftOut("Fresnel losses, glare and direction of the light", None, NOT_MEASURED))
    else:
        found.append(LeftOut("light between page and lenses", None, NOT_MEASURED))
    found.append(LeftOut("bounces within the sheet, and its hidden face", None, NOT_MEASURED))
    if backend == "mitsuba":
        found.append(LeftOut("rolling shutter", 0.0, "one pose serves all rows"))
    return (*found, *_unneeded(scene, backend, estimate, instant, exposed))


def _unneeded(scene: Scene, backend: str, estimate: Estimate, instant: Instant, exposed: Instant) -> list[LeftOut]:
    """What could be shown, but is not because `Scene.need` does not ask for it."""
    need, found = scene.need, []
    if not need.background:
        works = (_sensor_frame(scene, shown, instant) for shown in (True, False))
        found.append(_apart("background", "measured: the sensor with and without", *works))
    if not need.page:
        whole = replace(scene, need=replace(need, page=True))
        more = max(_board_px(whole, instant) - estimate.pixels, 0) / max(estimate.pixels, 1)
        found.append(LeftOut("page and markers", more * estimate.frame_s, "estimated, at most: their pixels"))
    if not need.shutter:
        what = "rolling shutter and exposure"
        if backend == "mitsuba":
            cost = (len(exposed.first.camera_mm) - 1) * estimate.frame_s
            found.append(LeftOut(what, cost, "estimated: one frame for each instant"))
        else:
            render = AnalyticRenderer(scene, rays=estimate.rays).render
            works = (partial(render, one) for one in (exposed, instant))
            found.append(_apart(what, "measured: a frame with and without", *works))
    if not need.glare and scene.light is not None:
        frames = (
            AnalyticRenderer(replace(scene, need=replace(need, glare=glare)), rays=estimate.rays)
            for glare in (True, False)
        )
        works = (partial(frame.render, instant) for frame in frames)
        found.append(_apart("glare", "measured: a frame with and without", *works))
    return found


def _off_badge(scene: Scene, backend: str, estimate: Estimate, instant: Instant) -> LeftOut:
    """The pixels that no ray is sent through."""
    what, camera = "pixels off the badge", scene.camera
    if backend == "mitsuba":
        outside = camera.width * camera.height - estimate.pixels
        cost = outside * estimate.frame_s / max(estimate.pixels, 1)
        return LeftOut(what, cost, "estimated, at most: their number, each as dear as one of the badge's")
    # One ray for each pixel is enough: the work to find that there is no badge is the same for each ray.
    whole = AnalyticRenderer(scene, rays=(1, 1))
    clocks = [time.perf_counter()]
    for crop in ((0, 0, camera.width, camera.height), None, None):
        whole.render(instant, crop=crop)
        clocks.append(time.perf_counter())
    whole_s, *boxes = (after - before for before, after in itertools.pairwise(clocks))
    rays = estimate.rays[0] * estimate.rays[1]
    how = "measured on one frame with one ray a pixel, times the rays"
    return timed(what, (whole_s - min(boxes)) * rays, abs(boxes[0] - boxes[1]) * rays, how)


def _fineness(estimate: Estimate) -> str:
    """The detail that a setting leaves out, in words."""
    if estimate.segments is not None:
        return f"lens detail below {estimate.segments} segments"
    return f"lens detail between {estimate.rays[0] * estimate.rays[1]} rays of a pixel"


def _board_px(scene: Scene, instant: Instant) -> int:
    """Number of pixels in the box that shows what the scene needs."""
    box = board_box(scene, instant.first, instant.last)
    return 0 if box is None else (box[2] - box[0]) * (box[3] - box[1])


def _sensor_frame(scene: Scene, background: bool, instant: Instant) -> Callable[[], Any]:
    """A function that exposes one frame without a board."""
    sensor = Sensor(scene.camera, 0, need=Need(background=background))
    return lambda: sensor.expose(None, instant.first.rotation[0], 0.0)


def _apart(what: str, how: str, with_it: Callable[[], Any], without: Callable[[], Any]) -> LeftOut:
    """A thing by the seconds of work with it and without."""
    shown, left_out = _seconds(with_it), _seconds(without)
    noise = max(shown) - min(shown) + max(left_out) - min(left_out)
    return timed(what, min(shown) - min(left_out), noise, how)


def _seconds(work: Callable[[], Any]) -> list[float]:
    """The times of some runs, after one that may compile."""
    work()
    took = []
    for _ in range(RUNS):
        clock = time.perf_counter()
        work()
        took.append(time.perf_counter() - clock)
    return took
