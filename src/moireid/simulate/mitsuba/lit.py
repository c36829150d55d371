"""The badge under a light, for Mitsuba: a matt page, a disc that shines, and an even sky.

Rays are not aimed at the light: a ray goes through a lens to the page, leaves it in any direction, and counts if it
finds the disc or the sky through a lens.  So a disc a few degrees wide needs some thousand rays in each pixel.

The red channel carries light from the page, green light that the lens mirrors; they are added.  In red the sheet
mirrors nothing, inside or outside.  So light from the page to the lens and back is left out, as in `analytic`.  The
lights are brighter in red by the loss of two passages through the surface, so that both channels have one scale.

Convention: `light` for the scale of radiance; the disc stands in the board's frame.
Source: Mitsuba 3.9.1, plugins `path`, `diffuse`, `dielectric`, `disk`, `constant`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from moireid.badge import Lens
from moireid.simulate.light import Light, straight_share
from moireid.simulate.mitsuba.parts import clear, reflecting, shining
from moireid.simulate.scene import Scene

#: In by one lens, off the page, out by a lens, and to the light.
LIT_INTEGRATOR = {"type": "path", "max_depth": 4, "rr_depth": 100}
#: A ray may meet this many more faces where bounces are needed.
BOUNCES = 8


def lit_page(mi: Any, scene: Scene) -> dict[str, dict[str, Any]]:
    """Surfaces of a page under a light: matt under the sheet; beside the sheet it shines by itself, as paper.

    Convention: module docstring.
    Source: the same.
    """
    return {
        "ink": reflecting(mi, scene.ink),
        "paper": reflecting(mi, scene.paper),
        "glass": clear(mi, scene.lens.refractive_index, (0.0, 1.0, 0.0)),
        "bars": shining(mi, scene.ink, 0.0),
        "walls": shining(mi, scene.paper, 0.0),
    }


def lamps(mi: Any, lens: Lens, light: Light) -> dict[str, Any]:
    """The sky, and the disc, which faces the board's centre.

    Convention: module docstring.
    Source: a disc's normal in Mitsuba is its own z.
    """
    n = lens.refractive_index
    # Radiance is multiplied by n squared on the way in and divided by it on the way out: this corrects for that.
    to_page = n**2 / straight_share(n) ** 2
    sky = 1.0 - light.share
    made: dict[str, Any] = {
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [sky * to_page, sky, 0.0]}}
    }
    if light.share > 0:
        upright = [0.0, 1.0, 0.0] if abs(light.place_mm[1]) < 0.9 * np.linalg.norm(light.place_mm) else [1.0, 0.0, 0.0]
        facing = mi.ScalarTransform4f().look_at(origin=list(light.place_mm), target=[0.0, 0.0, 0.0], up=upright)
        size = mi.ScalarTransform4f().scale([light.radius_mm, light.radius_mm, 1.0])
        shines = shining(mi, light.radiance * to_page, light.radiance)
        made["disc"] = {"type": "disk", "to_world": facing @ size, **shines}
    return made
