"""Camera, light and passes of a photograph, with the noise that is left in it.

The picture is the mean of passes with independent rays.  Passes of even and of odd number give two pictures; half of
their difference is a sample of the mean's own noise.  Its root mean square over the picture, on a scale where
white paper is 1, is the error; it falls with the square root of the number of rays.

Left out: the air between sheet and page, dust, the grain of paper, dispersion, and everything behind the cloth.

Convention: board frame of `motion`, mm; the camera looks at the badge from its side.
Source: Mitsuba 3.9.1, plugins `path`, `thinlens`, `rectangle`, `constant`; IEC 61966-2-1 for sRGB.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.files import AnyPath, whole_file
from moireid.simulate.mitsuba.variant import mitsuba_with
from moireid.simulate.photograph.worn_badge import RIM_MM, badge_surfaces, worn_surfaces
from moireid.simulate.scene import Scene

Array = NDArray[np.float64]
#: Rays a pixel in one pass, and the fewest passes of which noise can be estimated.
PASS_RAYS, FEWEST_PASSES = 16, 2
#: Faces that a ray may meet: through a lens to the page and out again, and through a second lens.
MOST_FACES = 14
#: Share of the picture's height that the badge takes, and its height above the picture's middle as a share of its own.
SHARE, RAISED = 0.60, 0.20
#: Radius of the camera's opening, mm: a portrait lens of 50 mm at f/4.
OPENING_MM = 6.0
#: The soft light: half of its side, its distance, mm, and where it is.
LAMP_HALF_MM, LAMP_MM, LAMP_DIRECTION = 600.0, 1500.0, (-0.70, -0.58, -0.42)
LAMP, ROOM = (5.6, 5.4, 5.0), (0.30, 0.32, 0.36)


@dataclass(frozen=True)
class View:
    """Where the photograph is taken from.

    Parameters
    ----------
    distance_m : float
        From camera to badge.
    aside_deg, above_deg : float
        How far the camera is to the right of the badge's axis, and above it; negative: to the left, below.
    """

    distance_m: float = 0.8
    aside_deg: float = 14.0
    above_deg: float = 6.0

    @property
    def camera_mm(self) -> Array:
        """The camera's place (3,)."""
        aside, above = math.radians(self.aside_deg), math.radians(self.above_deg)
        way = [math.sin(aside) * math.cos(above), -math.sin(above), -math.cos(aside) * math.cos(above)]
        return 1000 * self.distance_m * np.array(way)


@dataclass(frozen=True)
class Photograph:
    """A photograph and what it took.

    Parameters
    ----------
    picture : array (rows, columns, 3) of uint8
        Red, green, blue, coded as sRGB.
    error : float
        Root mean square of the noise; white paper is 1.
    rays : int
        Of each pixel.
    seconds : float
        Of rendering.
    """

    picture: NDArray[np.uint8]
    error: float
    rays: int
    seconds: float

    def save(self, path: AnyPath) -> None:
        """Write it as PNG, in place of a file of that name."""
        from PIL import Image

        with whole_file(path) as part:
            Image.fromarray(self.picture).save(part, format="PNG", optimize=True)


def photograph(
    scene: Scene,
    view: View,
    size: tuple[int, int],
    *,
    rays: int = 256,
    error: float | None = None,
    seed: int = 0,
    variant: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Photograph:
    """Take a photograph of a badge that is worn.

    Parameters
    ----------
    scene : Scene
        Badge, build and print in colour; its camera and light are not used.
    view : View
        From where.
    size : (int, int)
        Width and height, px.
    rays : int
        At most, of each pixel.
    error : float, optional
        End as soon as the noise is at most this.
    seed : int
        Of the rays and of the folds of the cloth.
    variant : str, optional
        Of Mitsuba; None for the best that this machine runs.
    progress : callable, optional
        Called with the rays made and the rays in all.

    Raises
    ------
    SpecError
        For fewer rays than two passes have.
    MissingExtraError
        Without Mitsuba.
    """
    if rays < FEWEST_PASSES * PASS_RAYS:
        raise SpecError(f"rays={rays} are too few; give {FEWEST_PASSES * PASS_RAYS} or more")
    clock = time.perf_counter()
    sums, noise, made = np.zeros((2, size[1], size[0], 3)), math.inf, 0
    with mitsuba_with(variant) as mi:
        described = {"type": "scene", **badge_surfaces(mi, scene), **worn_surfaces(mi, scene, seed), **_lights(mi)}
        world = mi.load_dict(described)
        sensor = mi.load_dict(_sensor(mi, scene, view, size))
        followed = mi.load_dict({"type": "path", "max_depth": MOST_FACES, "rr_depth": 8})
        for number in range(rays // PASS_RAYS):
            made = number + 1
            picture = mi.render(world, sensor=sensor, integrator=followed, seed=seed + number, spp=PASS_RAYS)
            sums[number % 2] += np.nan_to_num(np.array(picture, float))
            if progress:
                progress(made * PASS_RAYS, rays // PASS_RAYS * PASS_RAYS)
            if made % 2 == 0:
                noise = float(np.sqrt(np.mean(((sums[0] - sums[1]) / made) ** 2)))
                if error is not None and noise <= error:
                    break
    mean = sums.sum(axis=0) / made
    return Photograph(_coded(mean), noise, made * PASS_RAYS, time.perf_counter() - clock)


def _coded(light: Array) -> NDArray[np.uint8]:
    """Linear light as bytes; brightest parts are compressed rather than cut."""
    soft = np.where(light > 0.8, 0.8 + 0.2 * np.tanh((light - 0.8) / 0.4), light)
    coded = np.where(soft <= 0.0031308, 12.92 * soft, 1.055 * np.maximum(soft, 1e-9) ** (1 / 2.4) - 0.055)
    return np.asarray(np.rint(255 * np.clip(coded, 0, 1)), np.uint8)


def _lights(mi: Any) -> dict[str, Any]:
    """A large soft lamp above on the left, and a bright room."""
    way = np.array(LAMP_DIRECTION) / np.linalg.norm(LAMP_DIRECTION)
    facing = mi.ScalarTransform4f().look_at(origin=list(LAMP_MM * way), target=[0.0, 0.0, 0.0], up=[0.0, -1.0, 0.0])
    size = mi.ScalarTransform4f().scale([LAMP_HALF_MM, LAMP_HALF_MM, 1.0])
    return {
        "lamp": {
            "type": "rectangle",
            "to_world": facing @ size,
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": list(LAMP)}},
        },
        "room": {"type": "constant", "radiance": {"type": "rgb", "value": list(ROOM)}},
    }


def _sensor(mi: Any, scene: Scene, view: View, size: tuple[int, int]) -> dict[str, Any]:
    """The camera, focused on the badge, which is a little below the picture's middle."""
    high = 2 * (scene.board_half_mm[1] + RIM_MM)
    target = [0.0, -RAISED * high, 0.0]
    distance = 1000 * view.distance_m
    return {
        "type": "thinlens",
        "fov_axis": "y",
        "fov": math.degrees(2 * math.atan(high / SHARE / 2 / distance)),
        "aperture_radius": OPENING_MM,
        "focus_distance": distance,
        "near_clip": 10.0,
        "far_clip": 10 * distance,
        "to_world": mi.ScalarTransform4f().look_at(origin=view.camera_mm.tolist(), target=target, up=[0.0, -1.0, 0.0]),
        "sampler": {"type": "independent", "sample_count": PASS_RAYS},
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "rfilter": {"type": "gaussian"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
    }
