"""The badge by Mitsuba 3: the scene of the analytic renderer as geometry, for a second opinion, and its own error.

The lens sheet is a mesh of cylinder lenses in smooth segments (`mitsuba.sheet`), refracting by Mitsuba's own
dielectric; the printed lines under it are strips of the page, exact to float32, that shine with the radiance of ink and
paper; the rest of the page is a picture behind them.  Nothing here shares a line of optics with `analytic` or
`lenticule`.  What they have in common is the description (`Scene`, `Instant`) and the markers' picture.

The red channel carries the radiance, and green the share of rays that came through: page and paper emit 1 in it.  Red
over green is the mean over the refracted rays.  So reflected light does not show in the picture, nor the random choice
by which Mitsuba reflects a ray.  One difference stays: rays are weighted by the light that passes.

Left out: light from a direction and its glare, colour, the shutter (the first pose is taken), the sheet's hidden face,
rays that leave the lens through its neighbour's flank, those that are reflected within, mount and background.  Lights,
forgeries and hidden parts are refused.

`estimate_mitsuba` estimates the error on one frame before a film is made, and `cheapest_mitsuba` finds the cheapest
setting that meets a wish.  Two renders of one frame with independent seeds differ by the square root of two times the
rays' noise.  A third one with twice the segments in each lens differs from their mean by that noise and by the
segments' error.  That error falls with the square of their number, so three quarters of it show.  The estimate combines
both.

Not included: an error that finer segments share, such as Mitsuba's offset of rays (`page_depth_mm`), 0.001 rad; and the
difference to the independent tracer of `moireid bench simulate`, 0.004 rad at tangents of 0.3, because Mitsuba weights
rays by the light that the lens lets pass.

Convention: board frame of `motion`, mm, origin at the board's centre; the lens apex plane is z = -g, the page z = 0.
Source: Mitsuba 3.9.1, plugins `dielectric`, `area`, `direct`, `perspective`; `docs/explanation/physics.md`.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from moireid.simulate.analytic.accuracy import Estimate, compare, first_within
from moireid.simulate.analytic.analytic_renderer import BoardRadiance, Crop, board_box
from moireid.simulate.mitsuba.scene_parts import clear, mesh, pinhole, rest_of_page, shining
from moireid.simulate.mitsuba.sheet import (
    front_strips,
    mask_strips,
    page_strips,
    sheet_room,
    wall_strips,
)
from moireid.simulate.mitsuba.variant import loaded_mitsuba
from moireid.simulate.mitsuba.view import coverage, film_box
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Instant, Scene

Array = NDArray[np.float64]
#: Radiance of the blackest ink.
DARKEST = 1e-6
#: Seeds of neighbouring frames differ by this prime, so that films with neighbouring seeds never share a frame's rays.
SEED_STEP = 7919


class MitsubaRenderer:
    """Renders frames of one scene; geometry and materials are made once, only the camera is new in each frame.

    `MitsubaRenderer(scene, *, samples=64, segments=16, seed=0)`, then `.render(instant, *, crop=None)`.

    Parameters: samples: rays a pixel, in strata, some counts rounded up; segments: of each cylinder lens; seed: of the
        rays, each frame has others.
    Convention: radiance is linear, on the scale of `scene.ink` to `scene.paper`, 0 outside the board.
    Raises: MissingExtraError without mitsuba.
    Source: module docstring.
    """

    def __init__(self, scene: Scene, *, samples: int = 64, segments: int = 16, seed: int = 0) -> None:
        # Where every page is black, Mitsuba has no lamp to choose, and paints NaN.
        scene = replace(scene, ink=max(scene.ink, DARKEST), paper=max(scene.paper, DARKEST))
        self.scene, self.samples, self._seed = scene, samples, seed
        self._film: tuple[int, int] | None = None
        with loaded_mitsuba() as mi:
            described = {"type": "scene", "page": rest_of_page(mi, scene)}
            for number in range(len(scene.badge.gratings)):
                # In Mitsuba a lamp belongs to one surface, so each grating has its own.
                surfaces = _shining_page(mi, scene)
                for part, made in grating_parts(mi, scene, number, segments, surfaces).items():
                    described[f"grating{number}_{part}"] = made
            self._world = mi.load_dict(described)
            # Rays pass one refraction and end at what shines there; the page shines by itself, so no lamp is sampled.
            self._integrator = mi.load_dict({"type": "direct", "emitter_samples": 0, "bsdf_samples": 1})

    def render(self, instant: Instant, *, crop: Crop | None = None) -> BoardRadiance | None:
        """Render one frame of the pixels that see the board; None where no pixel does.

        Parameters: crop: (left, top, right, bottom) px to render, None for the board's own.
        Convention: that of the class; pixel centres are whole numbers.
        Returns: a picture to be compared pixel by pixel with `AnalyticRenderer.render`.
        Source: module docstring.
        """
        view = instant.first
        seen = board_box(self.scene, view)
        if seen is None:
            return None
        box = crop or seen
        picture = self._trace(view, box)
        share = coverage(self.scene, view, box)
        through = picture[..., 1]
        # A pixel that sees the board, but through which no ray came (a sheet's open edge), counts as paper.
        radiance = np.full(through.shape, self.scene.paper)
        np.divide(picture[..., 0], through, out=radiance, where=through > 0)
        return BoardRadiance(
            np.where(share > 0, radiance, 0.0).astype(np.float32), share.astype(np.float32), box[0], box[1]
        )

    def _trace(self, view: Poses, box: Crop) -> Array:
        """What Mitsuba's camera sees in the box, (height, width, 3)."""
        self._film = film_box(box, self._film)
        seed = self._seed
        self._seed = (seed + SEED_STEP) % 2**31
        with loaded_mitsuba() as mi:
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


def grating_parts(
    mi: Any, scene: Scene, number: int, segments: int, surfaces: dict[str, dict[str, Any]]
) -> dict[str, Any]:
    """The page's lines under one grating, the sheet over it, and its sides; each part has a surface of its own."""
    grating = scene.badge.gratings[number]
    lens, room, frame = scene.lens, sheet_room(scene, grating), scene.badge.frame_of(grating)
    # A reflection changes a twist's sign.
    build = replace(scene.build, twist_rad=frame.handed * scene.build.twist_rad)
    parts = {name: (strips, name) for name, strips in page_strips(scene, grating).items()}
    if lens.kind == "lenticular":
        parts["lenses"] = (front_strips(lens, build, room, segments), "glass")
    else:
        of_mask = {"bars": "bars", "openings": "glass"}
        parts |= {name: (strips, of_mask[name]) for name, strips in mask_strips(lens, build, room).items()}
    parts["walls"] = (wall_strips(scene, room), "walls")
    return {name: mesh(mi, frame, strips, surfaces[surface]) for name, (strips, surface) in parts.items()}


#: Rays in a pixel and segments in a lens: the usual setting, and the others from cheap to dear.
USUAL = (64, 16)
LADDER = ((16, 4), (16, 16), USUAL, (256, 16), (256, 32), (1024, 32))


def estimate_mitsuba(scene: Scene, instant: Instant, setting: tuple[int, int] = USUAL, *, seed: int = 0) -> Estimate:
    """Estimate the error of a setting (rays, segments) on one frame.

    Convention: module docstring.  Source: the same.
    Raises: SpecError like `MitsubaRenderer`.
    """
    samples, segments = setting
    renderer = MitsubaRenderer(scene, samples=samples, segments=segments, seed=seed)
    one = renderer.render(instant)
    if one is None:
        return Estimate((samples, 1), None, 0.0, segments)
    other = renderer.render(instant)
    finer = MitsubaRenderer(scene, samples=samples, segments=2 * segments, seed=(seed + 1) % 2**31)
    fine = finer.render(instant)
    assert other is not None and fine is not None
    mean = replace(one, radiance=(one.radiance + other.radiance) / np.float32(2))
    noise, beyond = compare(scene, instant, one, other), compare(scene, instant, fine, mean)
    phase = None
    if noise.phase_rad is not None and beyond.phase_rad is not None:
        phase = _both(noise.phase_rad, beyond.phase_rad)
    return Estimate((samples, 1), phase, _both(noise.image, beyond.image), segments)


def cheapest_mitsuba(scene: Scene, instant: Instant, error_rad: float, *, seed: int = 0) -> Estimate:
    """The cheapest setting whose estimated phase error is at most `error_rad`.

    Convention: a frame without fringes has no phase error, and gets the cheapest setting.
    Source: `estimate_mitsuba` up the `LADDER`.
    Raises: SpecError where even the dearest setting has a larger error.
    """
    return first_within(
        (estimate_mitsuba(scene, instant, setting, seed=seed) for setting in LADDER),
        error_rad,
        f"is not met by the mitsuba backend even with {LADDER[-1][0]} rays a pixel",
        "use the analytic backend",
    )


def _both(noise: float, beyond: float) -> float:
    """Error of one picture, from the difference of two, and of a third with finer segments from their mean."""
    square = noise**2 / 2
    return math.sqrt(square + max(beyond**2 - 1.5 * square, 0.0) * 16 / 9)
