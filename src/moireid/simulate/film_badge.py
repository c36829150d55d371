"""A film of a badge by names: `mo.simulate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from moireid.arguments import checked
from moireid.badge import Badge, load_badge
from moireid.errors import SpecError
from moireid.files import AnyPath, as_path
from moireid.simulate.build import build_named, flawed
from moireid.simulate.cameras import camera_named
from moireid.simulate.effects.table import effect_named
from moireid.simulate.filming import FilmReport, film
from moireid.simulate.flaw_table import read_flaw
from moireid.simulate.light import light_named
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Scene
from moireid.simulate.settings.wearing import load_print


@checked(
    distance_m=(0.1, 100),
    frames=(2, 1_000_000),
    fps=(1, 1000),
    error_rad=(1e-6, 1),
    seed=(0, 2**31 - 1),
)
def simulate(
    badge: Badge | AnyPath,
    video: AnyPath,
    *,
    motion: AnyPath = "handheld",
    distance_m: float = 1.4,
    frames: int = 300,
    fps: float = 60.0,
    forge: str | None = None,
    build: str = "typical",
    flaws: Sequence[str] = (),
    scene: str | None = None,
    camera: str = "phone",
    light: str | None = None,
    effects: Sequence[str] = (),
    recipe: str | None = None,
    backend: str = "analytic",
    error_rad: float | None = None,
    seed: int = 0,
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
    fps : float
        Frames a second.
    forge : str, optional
        The kind of forgery, such as "frozen"; None for a true film.
    build : str
        How well the badge is built: "ideal", "typical", "usual" or "poor".
    flaws : sequence of str
        NAME=VALUE, each in place of one quantity of the build.
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
    wished = dict(read_flaw(text) for text in flaws)
    if light and wished.get("glare"):
        raise SpecError(f"light {light} and the lamp of flaw glare are two lights; leave one of them out")
    seen = Scene(
        badge if isinstance(badge, Badge) else load_badge(badge),
        flawed(build_named(build, seed), wished),
        camera_named(camera),
        light=light_named(light) if light else None,
        print_picture=load_print(as_path(badge)) if scene and not isinstance(badge, Badge) else None,
    )
    return film(
        seen,
        motion_named(str(as_path(motion)), distance_mm=1000.0 * distance_m, seed=seed),
        video,
        frames=frames,
        fps=fps,
        forge=forge,
        setting=scene,
        effects=[effect_named(name) for name in effects],
        seed=seed,
        recipe=recipe,
        backend=backend,
        error_rad=error_rad,
        overwrite=overwrite,
        progress=progress,
    )
