"""The whole film: every frame rendered, exposed and encoded; the truth beside it.  One frame in memory at a time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.files import planned, whole_file
from moireid.simulate.analytic.estimate import Estimate, cheapest, estimate_error
from moireid.simulate.analytic.renderer import AnalyticRenderer, Rendered
from moireid.simulate.forgeries.shown import Shown, shown_in
from moireid.simulate.left_out import LeftOut, left_out
from moireid.simulate.motion import Motion, Poses
from moireid.simulate.recording.encode import FilmWriter, kept_frames, recipe_for
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.recording.shutter import averaged, opened
from moireid.simulate.scene import Instant, Scene
from moireid.simulate.truth import TRUTH_COLUMNS, Truth

__all__ = ["TRUTH_COLUMNS", "FilmReport", "film", "truth_path"]

Array = NDArray[np.float64]
Render = Callable[[Instant], Rendered | None]
#: What a film shows, of scene, motion, camera centres (T, 3) and frames a second.
Show = Callable[[Scene, Motion, Array, float], Shown]
#: A finished picture changed: frame, picture (height, width), homography page mm -> px of the middle row.
Edit = Callable[[int, NDArray[np.uint8], Array], NDArray[np.uint8]]


@dataclass(frozen=True)
class FilmReport:
    """What was filmed.

    Attributes
    ----------
    video : Path
        The film.
    truth : Path
        Its ground truth, CSV.
    frames : int
        Frames in the file; a recipe may drop some.
    label : str
        "genuine", or "forged:KIND".
    size : (int, int)
        Width and height in the file, px.
    stages_s : dict of str to float
        Seconds by stage of the work.
    left_out : tuple of LeftOut
        What no frame shows, and the seconds a frame that this saves.
    estimate : Estimate
        The renderer's setting, and the phase error that it is expected to make, rad.
    """

    video: Path
    truth: Path
    frames: int
    label: str
    size: tuple[int, int]
    stages_s: dict[str, float]
    left_out: tuple[LeftOut, ...]
    estimate: Estimate


def truth_path(video: Path) -> Path:
    """Tell where the ground truth of a film lies.

    Parameters
    ----------
    video : Path
        The film.

    Returns
    -------
    Path
        VIDEO.truth.csv beside it; nothing is made.

    Raises
    ------
    SpecError
        For a path that names no file.
    """
    if not video.name:
        raise SpecError(f"{str(video)!r} is a folder and names no film; give a file name such as film.mp4")
    return video.with_name(video.name + ".truth.csv")


def film(
    scene: Scene,
    motion: Motion,
    video: Path,
    *,
    frames: int,
    fps: float,
    forge: str | None = None,
    show: Show | None = None,
    edit: Edit | None = None,
    seed: int = 0,
    codec: str = "h264",
    crf: int | None = None,
    recipe: str | None = None,
    backend: str = "analytic",
    error_rad: float | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilmReport:
    """Film a scene to a video file with its truth beside it, both whole or not at all.

    Parameters
    ----------
    scene : Scene
        Badge, build, camera and light.
    motion : Motion
        The camera's course, as `motion_named` gives one.
    video : Path
        The file to write; its truth is written to `truth_path(video)`.
    frames : int
        How many frames, 2 to a million.
    fps : float
        How many a second, 1 to 1000.
    forge : str, optional
        A kind of `forgeries.courses.KINDS`; None for a true film.
    show, edit : Show, Edit, optional
        A forgery of the caller's own, in place of `forge`; and what is done to each finished picture.
    seed : int
        Of all that chance decides.
    codec : str
        Of `recording.encode`, such as "h264".
    crf : int, optional
        The codec's quality, on its own scale; None for its usual one.
    recipe : str, optional
        What a service makes of a film, of `recording.encode`; it sets codec and quality.
    backend : {"analytic", "mitsuba"}
        "mitsuba" is the slow reference, which knows no rolling shutter.
    error_rad : float, optional
        Phase error that the renderer must meet, by the cheapest setting that does, rad.
    overwrite : bool
        Whether older files may be replaced.
    progress : callable, optional
        Called with frames done and in all.

    Returns
    -------
    FilmReport
        The files, and what the work took.

    Raises
    ------
    SpecError
        Where nothing would be filmed, or a file is in the way.
    MediaError
        Where the file cannot be written.

    Notes
    -----
    Convention: times are those of the middle row; `moireid.simulate.truth` tells the truth's columns.
    Source: `analytic`, `recording`, and the encoders of PyAV.
    """
    if not (2 <= frames <= 1_000_000 and 1 <= fps <= 1000):
        raise SpecError(f"{frames} frames at {fps:g} per second is no film; give 2 or more frames at 1 to 1000 fps")
    way = recipe_for(recipe, codec, crf)
    _check_backend(scene, backend, forge)
    planned([video, truth_path(video)], overwrite=overwrite)
    places = motion(np.arange(frames) / fps).camera_mm
    if places[:, 2].max() > -2 * scene.badge.lens.thickness_mm:
        # Behind the badge the truth's phase and parallax would be those of a camera before it, and on it nan.
        raise SpecError("the camera touches the badge or comes behind it; give a greater distance or another motion")
    shown = show(scene, motion, places, fps) if show else shown_in(forge, scene, motion, places, fps, seed)
    kept = kept_frames(way, frames, seed)
    camera, label = scene.camera, f"forged:{forge}" if forge else "genuine"
    stages = _Stages()
    stages.begin()
    instants = _some_instants(motion, frames / fps)
    estimate = _estimate(scene, instants, backend, error_rad, seed)
    stages.end("estimate")
    render, sensor = _renderer(scene, backend, seed, estimate), Sensor(camera, seed, need=scene.need)
    shutter = camera if scene.need.shutter else replace(camera, shutter_s=0.0, exposure_s=0.0)
    stages.end("set up")
    with whole_file(truth_path(video)) as truth_file, whole_file(video) as video_file:
        with (
            truth_file.open("w", encoding="utf-8", newline="") as stream,
            FilmWriter(video_file, video.name, (camera.width, camera.height), fps, way) as writer,
            _Aside() as aside,
        ):
            truth = Truth(stream, scene.badge, label)
            for row, frame in enumerate(kept.tolist()):
                stages.begin()
                middle, opening = opened(motion, shutter, scene.board_half_mm, frame / fps, fps)
                board, field = _seen(render, opening, shown, frame)
                stages.end("render")
                picture = sensor.expose(board, middle.rotation[0], frame / fps)
                if edit:
                    picture = edit(frame, picture, page_homography(scene, middle))
                stages.end("sensor")
                aside.run(partial(writer.write, picture, frame))
                stages.end("encode")
                truth.add(row, frame / fps, middle, shown.camera_mm[frame], shown.sight_mm[frame], field)
                if progress:
                    progress(row + 1, len(kept))
            stages.begin()
            aside.finish()
        stages.end("encode")
    exposed = opened(motion, camera, scene.board_half_mm, frames / fps / 2, fps)[1]
    unseen = left_out(scene, backend, estimate, instants[1], instants=len(exposed), sensor_s=stages.least["sensor"])
    return FilmReport(video, truth_path(video), len(kept), label, writer.size, stages.seconds, unseen, estimate)


def page_homography(scene: Scene, pose: Poses) -> Array:
    """Page mm -> px of one pose, (3, 3), by the camera without distortion."""
    centre, scale = scene.board_centre_mm, scene.build.print_scale
    board = np.array([[scale, 0, -scale * centre[0]], [0, scale, -scale * centre[1]], [0, 0, 1.0]])
    rotation = pose.rotation[0]
    seen = np.column_stack([rotation[:, 0], rotation[:, 1], -rotation @ pose.camera_mm[0]])
    return np.asarray(scene.camera.matrix @ seen @ board)


def _seen(render: Render, opening: list[Poses], shown: Shown, frame: int) -> tuple[Rendered | None, Array | None]:
    """What one frame sees of the board, gathered over its exposure, and the forged field."""
    field, picture = shown.field(frame), shown.picture(frame)
    parts = []
    for poses in opening:
        # True fringes move with the camera while it is open; forged ones stand still for a frame.
        place = poses.camera_mm[1] if shown.camera_mm is shown.sight_mm else shown.camera_mm[frame]
        parts.append(render(Instant(_one(poses, 0), _one(poses, 2), place, field, picture)))
    return averaged(parts), field


def _check_backend(scene: Scene, backend: str, forge: str | None) -> None:
    """Refuse what a backend cannot show, before any work.  Raises: SpecError."""
    if backend not in ("analytic", "mitsuba"):
        raise SpecError(f"backend {backend!r} is not known; choose analytic or mitsuba")
    if backend == "analytic":
        return
    if scene.hidden_mm is not None:
        raise SpecError("the mitsuba backend covers no part of the board; use the analytic one")
    if forge is not None:
        raise SpecError(f"the mitsuba backend films true badges alone, not {forge}; use the analytic one")
    if any(scene.camera.distortion) or scene.camera.principal_px is not None:
        raise SpecError("the mitsuba backend knows no lens distortion; choose another camera, or the analytic backend")


def _some_instants(motion: Motion, length_s: float) -> list[Instant]:
    """The first, the middle and the last frame, each at one instant."""
    poses = motion(np.array([0.0, 0.5, 1.0]) * length_s)
    return [Instant(_one(poses, k), _one(poses, k), poses.camera_mm[k]) for k in range(3)]


def _estimate(scene: Scene, instants: list[Instant], backend: str, error_rad: float | None, seed: int) -> Estimate:
    """The renderer's setting and its error; Mitsuba, which is slow, is asked for the middle frame alone.

    Raises: SpecError where the wish is not met.
    """
    if backend == "mitsuba":
        from moireid.simulate.mitsuba.estimate import cheapest_mitsuba, estimate_mitsuba

        if error_rad is None:
            return estimate_mitsuba(scene, instants[1], seed=seed)
        return cheapest_mitsuba(scene, instants[1], error_rad, seed=seed)
    return estimate_error(scene, instants) if error_rad is None else cheapest(scene, instants, error_rad)


def _renderer(scene: Scene, backend: str, seed: int, estimate: Estimate) -> Render:
    """What renders one frame of the scene."""
    if estimate.segments is None:
        return AnalyticRenderer(scene, rays=estimate.rays).render
    from moireid.simulate.mitsuba.renderer import MitsubaRenderer

    return MitsubaRenderer(scene, samples=estimate.rays[0], segments=estimate.segments, seed=seed).render


class _Aside:
    """Encodes a frame while the next one is rendered; never more than one waits, so that memory stays flat."""

    def __init__(self) -> None:
        self._worker, self._last = ThreadPoolExecutor(1), Future[None]()
        self._last.set_result(None)

    def __enter__(self) -> _Aside:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Wait for the frame that is being encoded, whatever became of it."""
        self._worker.shutdown()

    def run(self, work: Callable[[], None]) -> None:
        """Begin some work when the work before is done.  Raises: what that raised."""
        self._last.result()
        self._last = self._worker.submit(work)

    def finish(self) -> None:
        """Wait for the last of it.  Raises: what that raised."""
        self._last.result()


class _Stages:
    """Seconds by stage; encoding is done beside the rest, and what is waited for it counts."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("estimate", "set up", "render", "sensor", "encode"), 0.0)
        self.least: dict[str, float] = {}
        self._clock = 0.0

    def begin(self) -> None:
        """Start the clock."""
        self._clock = time.perf_counter()

    def end(self, stage: str) -> None:
        """Count the time since the last call to a stage."""
        now = time.perf_counter()
        self.seconds[stage] += now - self._clock
        self.least[stage] = min(now - self._clock, self.least.get(stage, math.inf))
        self._clock = now


def _one(poses: Poses, k: int) -> Poses:
    return Poses(poses.camera_mm[k : k + 1], poses.rotation[k : k + 1])
