"""A film of a badge by the names of the command's options: `mo.simulate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from moireid.badge import Badge, load_badge
from moireid.files import AnyPath, as_path
from moireid.simulate.filming import FilmOptions, FilmReport, filmed, scene_of
from moireid.simulate.settings.wearing import load_print


def simulate(
    badge: Badge | AnyPath,
    video: AnyPath,
    *,
    motion: AnyPath = FilmOptions.motion,
    distance_m: float = FilmOptions.distance_m,
    frames: int = FilmOptions.frames,
    fps: float | None = FilmOptions.fps,
    forge: str | None = FilmOptions.forge,
    build: str = FilmOptions.build,
    flaws: Sequence[str] = FilmOptions.flaws,
    sheet: str | None = FilmOptions.sheet,
    scene: str | None = FilmOptions.scene,
    camera: str = FilmOptions.camera,
    light: str | None = FilmOptions.light,
    effects: Sequence[str] = FilmOptions.effects,
    recipe: str | None = FilmOptions.recipe,
    backend: str = FilmOptions.backend,
    error_rad: float | None = FilmOptions.error_rad,
    seed: int = FilmOptions.seed,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilmReport:
    """Film a badge, true or forged, as ``moireid simulate`` does; the truth of each frame is written next to the film.

    Parameters
    ----------
    badge : Badge or str or Path
        The badge, or its badge.json.  In a scene the badge of a file is in colour, by the preview.png next to it.
    video : str or Path
        The film to write.
    motion : str or Path
        A name such as "handheld", "sway", "linear" or "static", or a CSV file.
    distance_m : float
        Mean distance of the camera, m.
    frames : int
        How many frames.
    fps : float, optional
        Frames a second; None for 60.
    forge : str, optional
        The kind of forgery, such as "frozen"; None for a true film.
    build : str
        How well the badge is built: "ideal", "typical", "usual" or "poor".
    flaws : sequence of str
        NAME=VALUE, each in place of one quantity of the build.
    sheet : str, optional
        The kind of sheet, such as "thin".
    scene : str, optional
        Where the badge is: "desk", "worn", "lectern" or "call"; None for clouds behind it, in grey.
    camera : str
        The camera's name, such as "phone".
    light : str, optional
        Such as "window"; None for the plain light.
    effects : sequence of str
        What phones, calls and editors do to the film: NAME or NAME:STRENGTH.
    recipe : str, optional
        What a service makes of the film.
    backend : {"analytic", "mitsuba"}
        The renderer.
    error_rad : float, optional
        Phase error that the renderer must meet, rad.
    seed : int
        Of all that chance decides.
    overwrite : bool
        Whether older files may be replaced.
    progress : callable, optional
        Called with frames done and in all.

    Returns
    -------
    FilmReport
        The film, its truth, and what the work took.

    Raises
    ------
    SpecError
        For a name that is not known, or where a file is in the way.
    MediaError
        Where a file cannot be read or written.
    MissingExtraError
        Without numba, or Mitsuba for that backend.

    Notes
    -----
    Convention: as `moireid.simulate.film`, which also films what has no name.
    Source: `moireid.simulate.filming`.
    """
    wish = FilmOptions(
        motion=str(as_path(motion)),
        distance_m=distance_m,
        frames=frames,
        fps=fps,
        backend=backend,
        error_rad=error_rad,
        forge=forge,
        build=build,
        flaws=tuple(flaws),
        sheet=sheet,
        scene=scene,
        camera=camera,
        light=light,
        recipe=recipe,
        effects=tuple(effects),
        seed=seed,
    )
    own = badge if isinstance(badge, Badge) else load_badge(badge)
    shown = load_print(as_path(badge)) if wish.scene and not isinstance(badge, Badge) else None
    return filmed(scene_of(own, wish, shown), wish, video, overwrite=overwrite, progress=progress)
