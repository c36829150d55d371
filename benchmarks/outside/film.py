"""A page, a build, a camera and a trajectory, into an H.264 file, with the trajectory as CSV."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from outside.bend import outline
from outside.build import Build
from outside.camera import Camera
from outside.forge import FLAT, Lie, flat_page, lie_about
from outside.lamps import Lamps, relight
from outside.motion import Course
from outside.page import PAPER, Page
from outside.rivals import KINDS as RIVALS
from outside.rivals import rival_lie, sheared
from outside.sensor import WALL_FAR, expose, falloff, fill_wall, noise_pool, video_curve, wall
from outside.trace import LENS_SAMPLES, NEAR, NEAR_SAMPLES, PAPER_SAMPLES, offsets, trace

#: Poses are computed this often within a frame's time; between them they run straight.
KNOTS = 17
#: Exposure drifts by this share at most, in waves of some seconds.
DRIFT = 0.04
#: White card comes out at this share of the sensor's full scale.
WHITE = 0.8
#: x264 with the tools of a phone's coder, in hardware: one frame back, none ahead, a quick search, CABAC, deblocking.
CODER = {
    "preset": "ultrafast",
    "x264-params": "cabac=1:deblock=0,0:8x8dct=1:subme=1:partitions=i4x4,i8x8",
    "threads": "1",
}


@dataclass(frozen=True)
class Shoot:
    """Length, frame rate, quality of coding, seed, which lie, if any, and lamps besides the room's even light."""

    frames: int = 240
    fps: int = 30
    crf: int = 23
    seed: int = 0
    forge: str | None = None
    lamps: Lamps | None = None


class Tracer:
    """Frames of one badge by one camera on one trajectory."""

    def __init__(self, page: Page, build: Build, camera: Camera, course: Course, shoot: Shoot) -> None:
        """Draw what stays the same through the film."""
        rng = np.random.default_rng([shoot.seed, 77])
        self.lie: Lie | None = None
        seconds = shoot.frames / shoot.fps
        distance_mm = abs(float(course.views(np.zeros(1))[0][0, 2]))
        if shoot.forge in FLAT:
            page, build = flat_page(str(shoot.forge), page, build, distance_mm, distance_mm / camera.focal_px)
        elif shoot.forge in RIVALS:
            self.lie = rival_lie(str(shoot.forge), course, seconds, rng)
        elif shoot.forge:
            self.lie = lie_about(shoot.forge, course, seconds, shoot.fps, rng)
        self.page, self.build, self.camera, self.course, self.shoot = page, build, camera, course, shoot
        self.fine = np.ascontiguousarray(page.fine.T)
        self.rays = camera.rays()
        self.shade = falloff(camera, self.rays)
        self.wall, self.pool, self.curve = wall(rng), noise_pool(rng), video_curve()
        # A pixel's own square is a twelfth of a square in variance, in addition to the optics' blur.
        blur = float(np.hypot(camera.blur_px, 12**-0.5))
        count = NEAR_SAMPLES if distance_mm / camera.focal_px < NEAR * page.lens.pitch_mm else LENS_SAMPLES
        self.sets = offsets(count, blur, rng), offsets(PAPER_SAMPLES, blur, rng)
        self.light = np.zeros(self.rays.shape[:2], np.float32)
        self.drift = rng.uniform(0.1, 0.3), rng.uniform(0, 6.28), rng.uniform(0, DRIFT), rng.integers(1 << 30)
        self.size = (
            page.px_per_mm[0] / build.scale[0],
            page.px_per_mm[1] / build.scale[1],
            page.size_mm[0] * build.scale[0] / 2,
            page.size_mm[1] * build.scale[1] / 2,
        )

    def frame(self, number: int) -> NDArray[np.float32]:
        """Light of one frame, white card lit in full at the picture's middle being about `page.PAPER`."""
        start, camera = number / self.shoot.fps, self.camera
        # A row's exposure lies about its moment; the first row's moment is the frame's time.
        times = start - camera.exposure_s / 2 + np.linspace(0, camera.readout_s + camera.exposure_s, KNOTS)
        times = np.maximum(times, 0.0) if start == 0 else times
        places, turns = self.course.views(times)
        span = camera.readout_s + camera.exposure_s or 1.0
        knots = (KNOTS - 1) / span
        box = self._box(places, turns)
        self._fill(start)
        figures = camera.focal_px, camera.exposure_s * knots, camera.readout_s * knots
        eyes, lie, patches = places, np.zeros((1, 4)), np.zeros((1, 1), bool)
        if self.lie:
            eyes = self.lie.eye(times)
            lie = np.vstack([np.ones((1, 4)), self.lie.warp(start)])
            patches = self.lie.true_at
        lens, sheets, bend, lamps = self.page.lens, self.build.sheets, self.page.bend.figures, self.shoot.lamps
        trace(
            self.light, box, self.rays, figures, places, turns, sheets, lens.figures, self.fine,
            self.page.coarse, self.size, self.sets, eyes, lie, patches, self.shoot.seed * 1009 + number, bend,
            self.page.air_mm,
        )  # fmt: skip
        if lamps:
            seen = self.course.in_badge(np.array([lamps.side_mm, lamps.glare_mm]), np.array([start]))
            relight(self.light, box, self.rays, figures, places, turns, (sheets, self.size, bend), lamps, seen)
        return self.light

    def luma(self, number: int, out: NDArray[np.uint8]) -> None:
        """Bytes of one frame, into the first rows of `out`."""
        light = self.frame(number)
        hz, phase, size, place = self.drift
        exposure = WHITE / PAPER * (1 + size * np.sin(6.28 * hz * number / self.shoot.fps + phase))
        start = int((place + number * 7919 * 331) % len(self.pool))
        camera = self.camera
        expose(
            light, self.shade, exposure, camera.white_electrons, camera.read_share, self.pool, start, self.curve, out
        )
        if self.shoot.forge == "sheared":
            rows = camera.size_px[1]
            out[:rows] = sheared(out[:rows], np.random.default_rng([self.shoot.seed, number]))

    def _box(self, places: NDArray[np.float64], turns: NDArray[np.float64]) -> tuple[int, int, int, int]:
        """Pixels in which the badge can be during this frame."""
        x, y = self.size[2], self.size[3]
        corners = outline(x, y, self.page.bend)
        seen = np.einsum("kji,kcj->kci", turns, corners[None] - places[:, None])
        px = self.camera.project(seen).reshape(-1, 2)
        low, high = np.floor(px.min(axis=0)).astype(int) - 4, np.ceil(px.max(axis=0)).astype(int) + 4
        low, high = np.maximum(low, 0), np.minimum(high, self.camera.size_px)
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    def _fill(self, t: float) -> None:
        """The wall behind, which is fixed in the world."""
        pitch, yaw, roll, x, y, _ = self.course.gaze(t)
        far = abs(float(self.course.gaze(0.0)[5])) * WALL_FAR
        f = self.camera.focal_px
        shift_x, shift_y = f * (np.tan(yaw) + x / far), f * (y / far - np.tan(pitch))
        c, s = float(np.cos(roll)), float(np.sin(roll))
        cx, cy = self.camera.center_px
        fill_wall(self.light, self.wall, c, s, shift_x - c * cx + s * cy, shift_y - s * cx - c * cy)


def film(page: Page, build: Build, camera: Camera, course: Course, path: Path, shoot: Shoot) -> NDArray[np.float64]:
    """Write the film, and its trajectory as CSV.  Returns: the camera's place in the badge's frame, (T, 3), mm."""
    import av

    tracer = Tracer(page, build, camera, course, shoot)
    width, height = camera.size_px
    picture = np.full((height * 3 // 2, width), 128, np.uint8)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(shoot.fps), options=CODER | {"crf": str(shoot.crf)})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for number in range(shoot.frames):
            tracer.luma(number, picture)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="yuv420p")))
        container.mux(stream.encode())
    times = np.arange(shoot.frames) / shoot.fps
    places, turns = course.views(times)
    with path.with_suffix(".course.csv").open("w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["t_s", "camera_x_mm", "camera_y_mm", "camera_z_mm", *(f"r{i}{j}" for i in "123" for j in "123")])
        rows.writerows(np.column_stack([times, places, turns.reshape(-1, 9)]).round(6).tolist())
    return places
