"""The wish for a film, in names and numbers only, so that it can be saved and sent to another machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from moireid.badge import Badge
from moireid.simulate.cameras import camera_named, format_named
from moireid.simulate.effects.table import CAMERAS as EFFECT_CAMERAS
from moireid.simulate.effects.table import effect_named
from moireid.simulate.filming import FilmReport, film
from moireid.simulate.light import light_named
from moireid.simulate.motion import motion_named
from moireid.simulate.named_sheets import sheet_named
from moireid.simulate.scene import Build, Need, Scene


@dataclass(frozen=True)
class Wish:
    """One film; each field is an option of `moireid simulate`; None where other fields or defaults decide.

    fps: None for that of the format, or 60; motion: a name, or the path of a CSV file; leave_out: fields of
    `scene.Need` that are not needed;
    effects: NAME or NAME:STRENGTH, as `effects.table.effect_named` takes them, after that of the camera.
    """

    motion: str = "handheld"
    distance_m: float = 1.4
    frames: int = 300
    fps: float | None = None
    backend: str = "analytic"
    error_rad: float | None = None
    forge: str | None = None
    sheet: str | None = None
    camera: str = "phone"
    format: str | None = None
    mirror: bool = False
    blur_px: float | None = None
    light: str | None = None
    codec: str = "h264"
    crf: int | None = None
    recipe: str | None = None
    leave_out: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    seed: int = 0

    @property
    def rate_fps(self) -> float:
        """Frames a second."""
        return self.fps or (format_named(self.format).fps if self.format else 60.0)


def scene_of(badge: Badge, wish: Wish) -> Scene:
    """What is filmed: a typical build of the badge before the camera.  Raises: SpecError where a name is not known."""
    name = "phone" if wish.camera in EFFECT_CAMERAS else wish.camera
    camera = camera_named(name, mirror=wish.mirror, focus_blur_px=wish.blur_px)
    build = Build.typical(wish.seed)
    return Scene(
        badge,
        build if wish.sheet is None else sheet_named(wish.sheet, build),
        format_named(wish.format).of(camera) if wish.format else camera,
        light=light_named(wish.light) if wish.light else None,
        need=Need(**dict.fromkeys(wish.leave_out, False)),
    )


def filmed(
    scene: Scene,
    wish: Wish,
    video: Path,
    *,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> FilmReport:
    """Film the scene as wished; as `filming.film`, with its errors."""
    named = [EFFECT_CAMERAS[wish.camera]] if wish.camera in EFFECT_CAMERAS else []
    course = motion_named(wish.motion, distance_mm=1000.0 * wish.distance_m, seed=wish.seed)
    return film(
        scene,
        course,
        video,
        frames=wish.frames,
        fps=wish.rate_fps,
        forge=wish.forge,
        effects=[effect_named(name) for name in (*named, *wish.effects)],
        seed=wish.seed,
        codec=wish.codec,
        crf=wish.crf,
        recipe=wish.recipe,
        backend=wish.backend,
        error_rad=wish.error_rad,
        overwrite=overwrite,
        progress=progress,
    )
