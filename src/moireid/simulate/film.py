"""The whole film: every frame rendered, exposed and encoded; the truth beside it.  One frame in memory at a time."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.errors import MediaError, SpecError
from moireid.files import planned, whole_file, write_text
from moireid.lenticule import view_law
from moireid.simulate.analytic import AnalyticRenderer, Rendered
from moireid.simulate.forge import false_camera
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.scene import Instant, Scene
from moireid.simulate.sensor import Sensor

Array = NDArray[np.float64]
TRUTH_COLUMNS = (
    "frame", "time_s", "camera_x_mm", "camera_y_mm", "camera_z_mm", "r11", "r12", "r13", "r21", "r22", "r23",
    "r31", "r32", "r33", "parallax_x", "parallax_y", "phase_rad", "label",
)  # fmt: skip


@dataclass(frozen=True)
class FilmReport:
    """What was filmed: files, frames, label, seconds by stage, and what was left out."""

    video: Path
    truth: Path
    frames: int
    label: str
    stages_s: dict[str, float]
    left_out: tuple[str, ...]


def truth_path(video: Path) -> Path:
    """Where the truth of a film lies: VIDEO.truth.csv.  Raises: SpecError for a path that names no file."""
    if not video.name:
        raise SpecError(f"{str(video)!r} is a folder and names no film; give a file name such as film.mp4")
    return video.with_name(video.name + ".truth.csv")


def film(
    scene: Scene, motion: Motion, video: Path, *, frames: int, fps: float, forge: str | None = None, seed: int = 0,
    crf: int = 23, backend: str = "analytic", overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilmReport:  # fmt: skip
    """Film a scene to an H.264 file with its truth beside it, both whole or not at all.

    Parameters: frames, fps: length and rate; forge: a kind of `forge.KINDS`, None for a true film; crf: quality of
        x264; backend: "analytic", or "mitsuba", the slow reference, which knows no rolling shutter; progress: called
        with frames done and in all.
    Convention: times are those of the middle row; the truth's poses are board -> camera, board frame of `motion`.
    Returns: FilmReport.
    Raises: SpecError where nothing would be filmed; MediaError where the file cannot be written.
    Source: `analytic`, `sensor`, and x264 by PyAV.
    """
    if not (2 <= frames <= 1_000_000 and 1 <= fps <= 1000):
        raise SpecError(f"{frames} frames at {fps:g} per second is no film; give 2 or more frames at 1 to 1000 fps")
    planned([video, truth_path(video)], overwrite=overwrite)
    times = np.arange(frames) / fps
    half_shutter = scene.camera.shutter_s / 2
    first, middle, last = motion(times - half_shutter), motion(times), motion(times + half_shutter)
    shown = false_camera(forge, middle.camera_mm, fps, seed) if forge else middle.camera_mm
    if forge and backend == "mitsuba":
        raise SpecError(f"real lenses cannot show the forgery {forge!r}, so mitsuba cannot; use the analytic backend")
    render, sensor = _renderer(scene, backend, seed), Sensor(scene.camera, seed)
    stages = dict.fromkeys(("render", "sensor", "encode"), 0.0)
    label = f"forged:{forge}" if forge else "genuine"
    with whole_file(video) as temporary:
        writer = _Writer(temporary, video.name, scene, fps, crf)
        for k in range(frames):
            begun = time.perf_counter()
            board = render(Instant(_one(first, k), _one(last, k), shown[k]))
            rendered = time.perf_counter()
            picture = sensor.expose(board, middle.rotation[k], float(times[k]))
            exposed = time.perf_counter()
            writer.write(picture)
            done = time.perf_counter()
            for stage, seconds in (
                ("render", rendered - begun),
                ("sensor", exposed - rendered),
                ("encode", done - exposed),
            ):
                stages[stage] += seconds
            if progress:
                progress(k + 1, frames)
        writer.close()
    write_text(truth_path(video), truth_csv(scene, times, middle, shown, label))
    return FilmReport(video, truth_path(video), frames, label, stages, _left_out(scene, backend))


def _left_out(scene: Scene, backend: str) -> tuple[str, ...]:
    """What no frame of such a film shows."""
    light = ("Fresnel losses and glare", "direction of the light") if scene.light is None else (
        "light between page and lenses", "the light's course, where the badge turns")  # fmt: skip
    shutter = ("rolling shutter",) if backend == "mitsuba" else ()
    return ("colour", *light, *shutter, "the mount", "the printed name")


def _renderer(scene: Scene, backend: str, seed: int) -> Callable[[Instant], Rendered | None]:
    """What renders one frame of the scene."""
    if backend == "analytic":
        return AnalyticRenderer(scene).render
    if backend != "mitsuba":
        raise SpecError(f"backend {backend!r} is not known; choose analytic or mitsuba")
    from moireid.simulate.mitsuba_renderer import MitsubaRenderer

    return MitsubaRenderer(scene, seed=seed).render


def truth_csv(scene: Scene, times_s: Array, poses: Poses, shown_mm: Array, label: str) -> str:
    """The truth of a film as CSV: pose, parallax coordinate and shown fringe phase of each frame.

    Convention: parallax u = Cx / |Cz|, positive where the camera is at +x; phase by `lenticule.ViewLaw` at the
    board's centre on the page's plane, for the first grating's pitch.
    """
    badge = scene.badge
    pitch = badge.gratings[0].pitch_mm
    law = view_law(badge.lens, pitch)
    axis = 0 if badge.gratings[0].axis == "x" else 1
    distance = np.abs(shown_mm[:, 2])
    tangent = -shown_mm[:, axis] / distance
    lines = 1 / pitch - 1 / badge.lens.pitch_mm
    across = -shown_mm[:, 1 - axis] / distance
    phase = law.phase_rad(tangent, across) - 2 * np.pi * lines * badge.lens.thickness_mm * tangent
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(TRUTH_COLUMNS)
    for k, clock in enumerate(times_s):
        camera = poses.camera_mm[k]
        figures = [
            *camera,
            *poses.rotation[k].ravel(),
            camera[0] / abs(camera[2]),
            camera[1] / abs(camera[2]),
            phase[k],
        ]
        writer.writerow([k, f"{clock:.6f}", *(f"{value:.6f}" for value in figures), label])
    return out.getvalue()


def _one(poses: Poses, k: int) -> Poses:
    return Poses(poses.camera_mm[k : k + 1], poses.rotation[k : k + 1])


class _Writer:
    """An H.264 file, frame by frame."""

    def __init__(self, path: Path, name: str, scene: Scene, fps: float, crf: int) -> None:
        import av

        try:
            self._container = av.open(str(path), "w")
            rate = Fraction(fps).limit_denominator(1001)
            self._stream = self._container.add_stream("libx264", rate=rate)
        except (av.error.FFmpegError, ValueError) as error:
            raise MediaError(f"film {name} cannot be written as H.264 ({error}); name it .mp4 or .mkv") from error
        self._stream.width, self._stream.height = scene.camera.width, scene.camera.height
        self._stream.pix_fmt = "yuv420p"
        self._stream.options = {"crf": str(crf), "preset": "veryfast"}
        self._grey = np.full((scene.camera.height // 2, scene.camera.width), 128, np.uint8)

    def write(self, picture: NDArray[np.uint8]) -> None:
        """Encode one grey picture."""
        import av

        # Video luma runs from 16 to 235; a player stretches it back.
        luma = np.rint(16 + picture * np.float32(219 / 255)).astype(np.uint8)
        planes = np.vstack([luma, self._grey])
        for packet in self._stream.encode(av.VideoFrame.from_ndarray(planes, format="yuv420p")):
            self._container.mux(packet)

    def close(self) -> None:
        """Flush the encoder and finish the file."""
        for packet in self._stream.encode():
            self._container.mux(packet)
        self._container.close()
