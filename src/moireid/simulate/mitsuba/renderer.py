"""The badge by Mitsuba 3: the scene of the analytic renderer as geometry, for a second opinion.

The lens sheet is a mesh of cylinder lenses in smooth segments (`mitsuba.sheet`), refracting by Mitsuba's own
dielectric; the printed lines under it are strips of the page (`page.py`), exact to float32, that shine with the
radiance of ink and paper; the rest of the page is a picture behind them.  Nothing here shares a line of optics with
`analytic` or `lenticule`.  What they have in common is the description (`Scene`, `Instant`) and the markers' picture.

With a light in the scene (`Scene.light`) the page is matt and path-traced instead; see `lit.py`.  Without one, the red
channel carries the radiance, and green the share of rays that came through: page and paper emit 1 in it.  Red over
green is the mean over the refracted rays.  So reflected light does not show in the picture, nor the random choice by
which Mitsuba reflects a ray.  One difference stays: rays are weighted by the light that passes.

Left out: without a light, glare and direction; in any case colour and the rolling shutter; and unless `scene.need` asks
for bounces, the sheet's hidden face, rays that leave the lens through its neighbour's flank, and those that are
reflected within.  Mount and background are left out too.  Forgeries and hidden parts are refused.

Convention: board frame of `motion`, mm, origin at the board's centre; the lens apex plane is z = -g, the page z = 0.
Source: Mitsuba 3.9.1, plugins `dielectric`, `area`, `direct`, `perspective`; `docs/explanation/physics.md`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.errors import SpecError
from moireid.simulate.analytic.renderer import Rendered
from moireid.simulate.mitsuba.lit import BOUNCES, LIT_INTEGRATOR, lamps, lit_page
from moireid.simulate.mitsuba.page import hidden_face, page_strips, sheet_room, wall_strips
from moireid.simulate.mitsuba.parts import clear, mesh, pinhole, rest_of_page, shining
from moireid.simulate.mitsuba.sheet import front_strips, mask_strips, turned_for
from moireid.simulate.mitsuba.variant import mitsuba_with
from moireid.simulate.mitsuba.view import Crop, View, board_box, coverage, film_box, middle_view
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Fewer rays than this may all be reflected by the lens, which leaves the pixel without a value.
FEWEST_SAMPLES = 4
#: Radiance of the blackest ink.
DARKEST = 1e-6
#: Seeds of neighbouring frames differ by this prime, so that films with neighbouring seeds never share a frame's rays.
SEED_STEP = 7919


class MitsubaRenderer:
    """Renders frames of one scene; geometry and materials are made once, only the camera is new in each frame.

    `MitsubaRenderer(scene, *, samples=64, segments=16, variant=None, seed=0)`, then `.render(instant, *, crop=None)`.

    Parameters: samples: rays a pixel, in strata, some counts rounded up; segments: of each cylinder lens; variant: of
        Mitsuba, one that ends in `_rgb`, None for the best this machine runs; seed: of the rays, each frame has others.
    Convention: radiance is linear, on the scale of `scene.ink` to `scene.paper`, 0 beside the board.
    Raises: SpecError for too few rays or segments, a part that something covers, or a variant that is none;
        MissingExtraError without mitsuba or trimesh.
    Source: module docstring.
    """

    def __init__(
        self, scene: Scene, *, samples: int = 64, segments: int = 16, variant: str | None = None, seed: int = 0
    ) -> None:
        if samples < FEWEST_SAMPLES or segments < 1 or not 0 <= seed < 2**31:
            raise SpecError(
                f"samples={samples}, segments={segments}, seed={seed} make no picture; give {FEWEST_SAMPLES} samples "
                "or more, 1 segment or more, and a seed of 0 to 2147483647"
            )
        if scene.hidden_mm is not None:
            raise SpecError("the mitsuba renderer covers no part of the board; use the analytic one")
        # Where every page is black, Mitsuba has no lamp to choose, and paints NaN.
        scene = replace(scene, ink=max(scene.ink, DARKEST), paper=max(scene.paper, DARKEST))
        self.scene, self.samples, self._variant, self._seed = scene, samples, variant, seed
        self._film: tuple[int, int] | None = None
        with mitsuba_with(variant) as mi:
            described = {"type": "scene", "page": rest_of_page(mi, scene, 1.0 if scene.light is None else 0.0)}
            for number in range(len(scene.badge.gratings)):
                # In Mitsuba a lamp belongs to one surface, so each grating has its own.
                surfaces = _shining_page(mi, scene) if scene.light is None else lit_page(mi, scene)
                # A face between glass and glass, with one refractive index on both sides: it bends no ray.
                surfaces |= {"within": clear(mi, 1.0)} if scene.need.bounces else {}
                for part, made in _grating_meshes(mi, scene, number, segments, surfaces).items():
                    described[f"grating{number}_{part}"] = made
            if scene.light is not None:
                described |= lamps(mi, scene.lens, scene.light)
            self._world = mi.load_dict(described)
            # Rays pass one refraction and end at what shines there; the page shines by itself, so no lamp is sampled.
            own_light = {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}
            followed: dict[str, Any] = own_light if scene.light is None else LIT_INTEGRATOR
            if scene.need.bounces:
                followed = LIT_INTEGRATOR | {"max_depth": 4 + BOUNCES}
            self._integrator = mi.load_dict(followed)

    def render(self, instant: Instant, *, crop: Crop | None = None) -> Rendered | None:
        """Render one frame of the pixels that see the board; None where no pixel does.

        Parameters: crop: (left, top, right, bottom) px to render, None for the board's own.
        Convention: that of the class; pixel centres are whole numbers.
        Returns: Rendered, to be compared pixel by pixel with `AnalyticRenderer.render`.
        Raises: SpecError for a forgery, or a crop beyond the picture.
        Source: module docstring.
        """
        width, height = self.scene.camera.width, self.scene.camera.height
        if crop and not (0 <= crop[0] < crop[2] <= width and 0 <= crop[1] < crop[3] <= height):
            raise SpecError(
                f"crop={crop} must be left < right, top < bottom within the picture's {width} x {height} px"
            )
        view = middle_view(instant)
        seen = board_box(self.scene, view)
        if seen is None:
            return None
        box = crop or seen
        picture = self._trace(view, box)
        share = coverage(self.scene, view, box)
        mirrored = picture[..., 1] if self.scene.need.glare else 0.0
        radiance = self._of_shining_page(picture) if self.scene.light is None else picture[..., 0] + mirrored
        return Rendered(np.where(share > 0, radiance, 0.0).astype(np.float32), share.astype(np.float32), box[0], box[1])

    def _of_shining_page(self, picture: Array) -> Array:
        """Radiance as the mean over the rays that came through, (height, width)."""
        through = picture[..., 1]
        # A pixel that sees the board, but through which no ray came (a sheet's open edge), counts as paper.
        paper = np.full(through.shape, self.scene.paper)
        np.divide(picture[..., 0], through, out=paper, where=through > 0)
        return paper

    def _trace(self, view: View, box: Crop) -> Array:
        """What Mitsuba's camera sees in the box, (height, width, 3)."""
        self._film = film_box(box, self._film)
        seed = self._seed
        self._seed = (seed + SEED_STEP) % 2**31
        with mitsuba_with(self._variant) as mi:
            sensor = pinhole(mi, self.scene, view, box, self._film, self.samples)
            picture = mi.render(self._world, sensor=sensor, integrator=self._integrator, seed=seed, spp=self.samples)
            return np.array(picture, np.float64)[: box[3] - box[1], : box[2] - box[0]]


def _shining_page(mi: Any, scene: Scene) -> dict[str, dict[str, Any]]:
    """Surfaces of a page that shines by itself, so that no lamp and no bounce adds noise."""
    # Leaving the glass divides radiance by n squared, and a part is reflected; straight on, this corrects for both.
    n = scene.lens.refractive_index
    lamp = n**2 / (1.0 - ((n - 1.0) / (n + 1.0)) ** 2)
    return {
        "ink": shining(mi, lamp * scene.ink, lamp),
        "paper": shining(mi, lamp * scene.paper, lamp),
        "glass": clear(mi, n),
        "bars": shining(mi, scene.ink, 1.0),
        "walls": shining(mi, scene.paper, 1.0),
    }


def _grating_meshes(
    mi: Any, scene: Scene, number: int, segments: int, surfaces: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    """The page's lines under one grating, the sheet over it, and its sides; each part has a surface of its own."""
    grating = scene.badge.gratings[number]
    lens, room, frame = scene.lens, sheet_room(scene, grating), scene.badge.frame_of(grating)
    build = turned_for(scene.build, number, frame.handed)
    parts = {name: (strips, name) for name, strips in page_strips(scene, grating).items()}
    if lens.kind == "lenticular":
        parts["lenses"] = (front_strips(lens, build, room, segments), "glass")
    else:
        of_mask = {"bars": "bars", "openings": "glass"}
        parts |= {name: (strips, of_mask[name]) for name, strips in mask_strips(lens, build, room).items()}
    parts["walls"] = (wall_strips(scene, room), "walls")
    if scene.need.bounces:
        parts["back"] = (hidden_face(scene, room), "within")
    return {name: mesh(mi, frame, strips, surfaces[surface]) for name, (strips, surface) in parts.items()}
