"""Stiff and extreme scenes for the renderer: right within its own error bar, or refused with a reason.

Each is one frame, rendered in float32 and in float64 and compared with the independent tracer at the same pixels.
Right means: all figures are finite, brightness is within the bar, and so is the phase where fringes can be read.  The
bar is three times the renderer's own estimate (`simulate.analytic.estimate`), but at least the tracer's own error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from moireid.badge import Lens
from moireid.errors import MoireIdError
from moireid.simulate.analytic.accuracy import estimate_error
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer
from moireid.simulate.scene import Build, Camera
from moireid_lab.bench.simulate.scenes import SceneSetting, board
from moireid_lab.bench.simulate.simulate_suite import error_of, truth_of

RAYS = (32, 2)
SHEET = Lens("lenticular", 0.508, 1.0, 1.56)
#: From near, a picture of the whole board that is small enough to trace.
NEAR = Camera(640, 360, 300.0)
TIMES, PHASE_FLOOR_RAD, IMAGE_FLOOR = 3.0, 0.004, 0.01
#: Beyond this many of the tracer's rays that leave a lens by its neighbour, the model itself is in doubt.
MOST_ESCAPED = 0.01


@dataclass(frozen=True)
class StiffScene:
    """One case: how its scene is made, and the view tangents across and along the lenses."""

    name: str
    make: Callable[[], SceneSetting]
    tangent: float = 0.2


def stiff_scenes() -> list[StiffScene]:
    """All cases, by what they strain."""
    return [
        *(StiffScene(f"pitch ratio 1 + {share:g}", partial(_ratio, share)) for share in (0.0, 1e-9, 1e-6, 1e-3)),
        *(StiffScene(f"distance {mm / 1000:g} m", partial(_distance, mm)) for mm in (20.0, 100.0, 3e4, 1e5)),
        *(
            StiffScene(f"view at {degrees:g} degrees", lambda: _distance(400.0), float(np.tan(np.radians(degrees))))
            for degrees in (45, 70, 80)
        ),
        *(StiffScene(f"sheet {mm:g} mm", partial(_sheet, mm, 1.56)) for mm in (0.05, 0.2, 3.0, 10.0)),
        *(StiffScene(f"n = {n:g}", partial(_sheet, 2.0, n)) for n in (1.0, 1.02, 1.3, 2.0)),
        StiffScene("mask in air, n = 1", lambda: SceneSetting("", board(Lens("mask", 0.508, 2.0, 1.0), 0.52))),
        StiffScene("seven lenses in a pixel", lambda: SceneSetting("", board(SHEET, 0.513), distance_mm=5000.0)),
        StiffScene("no light", lambda: _light(0.0)),
        StiffScene("saturation, ten times white", lambda: _light(10.0)),
        StiffScene("lenses spread beyond their diameter", lambda: SceneSetting("", _badge(), Build(lens_scale=1.5))),
    ]


def run_scenes() -> list[dict[str, Any]]:
    """All cases as rows."""
    return [render_case(case) for case in stiff_scenes()]


def render_case(case: StiffScene) -> dict[str, Any]:
    """One row: errors of both tracers, the bar, and the outcome."""
    row: dict[str, Any] = {"scene": case.name, "outcome": "refused", "why": "", "float32_from_float64": None}
    try:
        setting = case.make()
        scene = setting.scene
        truth = truth_of(setting, case.tangent, budget=100_000)
        instant = setting.seen_at(case.tangent)
        pictures = {
            precision: AnalyticRenderer(scene, rays=RAYS, precision=precision).render(instant)
            for precision in ("float32", "float64")
        }
        estimate = estimate_error(scene, [instant], RAYS)
    except MoireIdError as error:
        return row | {"why": str(error)}
    fast, careful = pictures["float32"], pictures["float64"]
    if fast is None or careful is None:
        return row | {"outcome": "right", "why": "the camera sees no board, and no picture is given"}
    finite = bool(np.all(np.isfinite(fast.radiance)) and np.all(np.isfinite(careful.radiance)))
    contrast = max(scene.paper - scene.ink, 1e-12)
    row["float32_from_float64"] = float(np.sqrt(np.mean((fast.radiance - careful.radiance) ** 2)) / contrast)
    if truth is None:
        return row | {
            "outcome": "unheld" if finite else "wrong",
            "why": "too small to hold a strip; finite, and no more is known",
        }
    found = error_of(fast, truth, contrast)
    bar_rad = max(TIMES * (estimate.phase_rad or 0.0), PHASE_FLOOR_RAD)
    bar_image = max(TIMES * estimate.image, IMAGE_FLOOR)
    good = finite and found.image <= bar_image and (found.phase_rad is None or found.phase_rad <= bar_rad)
    why = "" if found.phase_rad is not None else "no fringe to read; brightness alone is held"
    if not good and truth.escaped > MOST_ESCAPED:
        why = (
            f"{100 * truth.escaped:.0f} % of the rays leave their lens by its neighbour, which no renderer here follows"
        )
    return row | {
        "outcome": "right" if good else "wrong",
        "why": why,
        "phase_rad": found.phase_rad,
        "bar_rad": bar_rad,
        "image": found.image,
        "bar_image": bar_image,
        "escaped": truth.escaped,
    }


def _badge() -> Any:
    return board(SHEET, 0.52)


def _ratio(share: float) -> SceneSetting:
    return SceneSetting("", board(SHEET, 0.508 * (1.0 + share)))


def _distance(distance_mm: float) -> SceneSetting:
    """Near: an ordinary camera.  Far: one whose pixels see about as much as an ordinary camera's at 2 m."""
    camera = NEAR if distance_mm < 300 else Camera(focal_px=max(1450.0, 0.7 * distance_mm))
    return SceneSetting("", _badge(), distance_mm=distance_mm, camera=camera)


def _sheet(thickness_mm: float, refractive_index: float) -> SceneSetting:
    """A sheet whose pitch suits its thickness: half of it at most the radius that focuses on the back."""
    radius = thickness_mm * (refractive_index - 1.0) / refractive_index
    pitch = min(0.508, 1.4 * radius) if radius > 0 else 0.508
    lens = Lens("lenticular", pitch, thickness_mm, refractive_index)
    return SceneSetting("", board(lens, pitch * 1.024), distance_mm=600.0 * pitch / 0.508, camera=NEAR)


def _light(paper: float) -> SceneSetting:
    return _Lit("", _badge(), paper=paper)


@dataclass(frozen=True)
class _Lit(SceneSetting):
    """A setting with paper of another radiance; ink is a fourteenth of it, as ever."""

    paper: float = 0.85

    @property
    def scene(self) -> Any:
        """The scene that a renderer takes."""
        from dataclasses import replace

        return replace(super().scene, paper=self.paper, ink=self.paper * 0.07)
