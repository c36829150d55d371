"""The whole film: every frame rendered, exposed and encoded, with its ground truth; one frame in memory at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.files import AnyPath, as_path, planned, whole_file
from moireid.simulate.analytic.accuracy import Estimate, cheapest, estimate_error
from moireid.simulate.analytic.analytic_renderer import RAYS, AnalyticRenderer
from moireid.simulate.build import flaw_name
from moireid.simulate.cameras import Camera
from moireid.simulate.effects.effect import Effect, begun, timing_of
from moireid.simulate.flaw_table import IN_MITSUBA
from moireid.simulate.forgeries.rear_layer import ShownViews, shown_in
from moireid.simulate.motion import Motion
from moireid.simulate.recording.encode import FilmWriter, kept_frames, recipe_for
from moireid.simulate.recording.sensor import Sensor
from moireid.simulate.scene import Instant, Scene
from moireid.simulate.settings.painting import Painter
from moireid.simulate.settings.places import setting_named
from moireid.simulate.shots import Edit, Render, Shots, take_of
from moireid.simulate.truth import TRUTH_COLUMNS, Stages, Truth

__all__ = ["TRUTH_COLUMNS", "FilmReport", "film", "truth_path"]

Array = NDArray[np.float64]
#: What a film shows, of scene, motion, camera centres (T, 3) and frames a second.
Show = Callable[[Scene, Motion, Array, float], ShownViews]


@dataclass(frozen=True)
class FilmReport:
    """What was filmed.

    Attributes
    ----------
    video : str or Path
        The film.
    truth : Path
        Its ground truth, CSV.
    frames : int
        Frames in the file; a recipe may drop some.
    label : str
        "genuine", or "forged:KIND".
    size : (int, int)
        Width and height in the file, px.
    camera : Camera
        That filmed it.
    stages_s : dict of str to float
        Seconds by stage of the work.
    left_out : tuple of str
        What no frame shows.
    """

    video: Path
    truth: Path
    frames: int
    label: str
    size: tuple[int, int]
    camera: Camera
    stages_s: dict[str, float]
    left_out: tuple[str, ...]
    _estimated: Callable[[], Estimate] = field(repr=False, compare=False)

    @cached_property
    def estimate(self) -> Estimate:
        """The renderer's setting, and the phase error that it is expected to make, rad; made when it is asked for."""
        return self._estimated()


def truth_path(video: AnyPath) -> Path:
    """The path of a film's ground truth.

    Parameters
    ----------
    video : str or Path
        The film.

    Returns
    -------
    Path
        VIDEO.truth.csv in the same folder; nothing is written.

    Raises
    ------
    SpecError
        For a path that names no file.
    """
    video = as_path(video)
    if not video.name:
        raise SpecError(f"{str(video)!r} is a folder and names no film; give a file name such as film.mp4")
    return video.with_name(video.name + ".truth.csv")


def film(
    scene: Scene,
    motion: Motion,
    video: AnyPath,
    *,
    frames: int,
    fps: float,
    forge: str | None = None,
    show: Show | None = None,
    edit: Edit | None = None,
    setting: str | None = None,
    effects: Sequence[Effect] = (),
    seed: int = 0,
    crf: int | None = None,
    recipe: str | None = None,
    backend: str = "analytic",
    error_rad: float | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilmReport:
    """Film a scene to a video file and write its ground truth; both files are complete, or neither is kept.

    Parameters
    ----------
    scene : Scene
        Badge, build, camera and light.
    motion : Motion
        The camera's trajectory, as `motion_named` gives one.
    video : Path
        The file to write; its truth is written to `truth_path(video)`.
    frames : int
        How many frames, 2 to a million.
    fps : float
        How many a second, 1 to 1000.
    forge : str, optional
        A kind of `forgeries.trajectories.KINDS`; None for a true film.
    show, edit : Show, Edit, optional
        A forgery of the caller's own, in place of `forge`; and what is done to each finished picture.
    setting : str, optional
        Where the badge is, of `settings.places`, in colour; None for clouds behind it, in grey.
    effects : sequence of Effect
        What the world does to the film, one after the other, of `effects.table`.
    seed : int
        Of all that chance decides.
    crf : int, optional
        Quality of H.264, 0 (best) to 51; None for the usual one.
    recipe : str, optional
        What a service makes of a film, of `recording.encode`; it sets the quality.
    backend : {"analytic", "mitsuba"}
        "mitsuba" is the slow reference, whose shutter is open for an instant.
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
    Convention: times are those of the middle row; `moireid.simulate.truth` lists the truth's columns.
    Source: `analytic`, `recording`, and the encoders of PyAV.
    """
    video = as_path(video)
    if not (2 <= frames <= 1_000_000 and 1 <= fps <= 1000):
        raise SpecError(f"{frames} frames at {fps:g} per second is no film; give 2 or more frames at 1 to 1000 fps")
    for effect in effects:
        scene = effect.scene(scene) if effect.scene else scene
    way = recipe_for(recipe, crf)
    for effect in effects:
        way = effect.recipe(way) if effect.recipe else way
    timing = timing_of(effects, frames, fps, seed)
    _check_backend(scene, backend, forge)
    if backend == "mitsuba":
        scene = replace(scene, camera=replace(scene.camera, shutter_s=0.0, exposure_s=0.0))
    planned([video, truth_path(video)], overwrite=overwrite)
    poses = motion(np.arange(timing.count) / timing.fps)
    places = poses.camera_mm
    if places[:, 2].max() > -2 * scene.lens.thickness_mm:
        # Behind the badge the truth's phase and parallax would be those of a camera before it, and on it nan.
        raise SpecError("the camera touches the badge or comes behind it; give a greater distance or another motion")
    shown = (
        show(scene, motion, places, timing.fps) if show else shown_in(forge, scene, motion, places, timing.fps, seed)
    )
    kept = kept_frames(way, frames, seed)
    camera, label = scene.camera, f"forged:{forge}" if forge else "genuine"
    stages = Stages()
    stages.begin()
    instants = _some_instants(motion, timing.count / timing.fps)
    estimate = None
    if error_rad is not None or backend == "mitsuba":
        # The renderer's setting depends on it.
        estimate = _estimate(scene, instants, backend, error_rad, seed)
    render, sensor = _renderer(scene, seed, estimate), Sensor(camera, seed)
    painter = Painter(setting_named(setting, scene, seed), scene.camera) if setting else None
    steps, behind = begun(effects, take_of(scene, poses, timing.fps, seed))
    longest_s = 1 / min(fps, timing.fps)
    shots = Shots(scene, motion, shown, timing.fps, longest_s, render, sensor, steps, edit, stages, painter)
    stages.end("set up")
    with whole_file(truth_path(video)) as truth_file, whole_file(video) as video_file:
        with (
            truth_file.open("w", encoding="utf-8", newline="") as stream,
            FilmWriter(video_file, video.name, behind.size, fps, way) as writer,
            # A second thread encodes while the next frame is rendered; no more than one frame waits for it.
            ThreadPoolExecutor(1) as encoder,
        ):
            truth, written = Truth(stream, scene, label), None
            for row, frame in enumerate(kept.tolist()):
                picture, number, shot = shots.mixed(timing.parts[frame])
                stages.begin()
                if written:
                    written.result()
                chroma = shot.chroma if len(timing.parts[frame]) == 1 else None
                written = encoder.submit(writer.write, picture, frame, chroma)
                stages.end("encode")
                place, sight = shown.camera_mm[number], shown.sight_mm[number]
                truth.add(row, frame / fps, shot.pose, place, sight, shot.field)
                if progress:
                    progress(row + 1, len(kept))
            stages.begin()
            if written:
                written.result()
        stages.end("encode")
    return FilmReport(
        video,
        truth_path(video),
        len(kept),
        label,
        writer.size,
        camera,
        stages.seconds,
        tuple(_left_out(scene, backend, painted=bool(setting), colour=bool(shot.chroma and writer.keeps_colour))),
        lambda: estimate or estimate_error(scene, instants),
    )


def _left_out(scene: Scene, backend: str, *, painted: bool, colour: bool) -> Iterator[str]:
    """What no frame shows; `moireid bench simulate` measures what each would change, and cost.

    Parameters: painted, colour: whether a setting is painted around the badge, and whether the file is in colour.
    """
    mitsuba, lit = backend == "mitsuba", scene.light is not None
    unseen = {
        "lens detail below a segment" if mitsuba else "lens detail between a pixel's rays": True,
        "colour": not (painted and colour),
        "the printed name and the mount": not painted,
        "light between page and lenses": lit,
        "Fresnel losses, glare and direction of the light": not lit,
        "bounces within the sheet, and its hidden face": True,
        "rolling shutter and exposure": mitsuba,
    }
    return (what for what, missing in unseen.items() if missing)


def _check_backend(scene: Scene, backend: str, forge: str | None) -> None:
    """Refuse what a backend cannot show, before any work.  Raises: SpecError."""
    if backend not in ("analytic", "mitsuba"):
        raise SpecError(f"backend {backend!r} is not known; choose analytic or mitsuba")
    if backend == "analytic":
        return
    if scene.hidden_mm is not None:
        raise SpecError("the mitsuba backend covers no part of the board; use the analytic one")
    if scene.light is not None:
        raise SpecError(
            "the mitsuba backend has a page that shines evenly; leave the light out, or use the analytic one"
        )
    if forge is not None:
        raise SpecError(f"the mitsuba backend films true badges alone, not {forge}; use the analytic one")
    strange = [name for name in map(flaw_name, scene.build.differences) if name not in IN_MITSUBA]
    if strange:
        raise SpecError(f"the mitsuba backend builds no {', '.join(strange)}; leave that out, or use the analytic one")
    if any(scene.camera.distortion) or scene.camera.principal_px is not None:
        raise SpecError("the mitsuba backend knows no lens distortion; choose another camera, or the analytic backend")


def _some_instants(motion: Motion, length_s: float) -> list[Instant]:
    """The first, the middle and the last frame, each at one instant."""
    poses = motion(np.array([0.0, 0.5, 1.0]) * length_s)
    return [Instant(poses.one(k), poses.one(k), poses.camera_mm[k]) for k in range(3)]


def _estimate(scene: Scene, instants: list[Instant], backend: str, error_rad: float | None, seed: int) -> Estimate:
    """The setting that meets a wish, and its error; Mitsuba, which is slow, is asked for the middle frame alone.

    Raises: SpecError where the wish is not met.
    """
    if backend == "mitsuba":
        from moireid.simulate.mitsuba.mitsuba_renderer import cheapest_mitsuba, estimate_mitsuba

        if error_rad is None:
            return estimate_mitsuba(scene, instants[1], seed=seed)
        return cheapest_mitsuba(scene, instants[1], error_rad, seed=seed)
    return estimate_error(scene, instants) if error_rad is None else cheapest(scene, instants, error_rad)


def _renderer(scene: Scene, seed: int, estimate: Estimate | None) -> Render:
    """What renders one frame of the scene, by the setting of an estimate."""
    if estimate is None or estimate.segments is None:
        return AnalyticRenderer(scene, rays=estimate.rays if estimate else RAYS).render
    from moireid.simulate.mitsuba.mitsuba_renderer import MitsubaRenderer

    return MitsubaRenderer(scene, samples=estimate.rays[0], segments=estimate.segments, seed=seed).render
