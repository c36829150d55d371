"""The reference renderer: its error, and what its films leave out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from moireid.errors import SpecError
from moireid.simulate.filming import FilmReport, film
from moireid.simulate.mitsuba import mitsuba_renderer as mitsuba_estimate
from moireid.simulate.mitsuba.mitsuba_renderer import cheapest_mitsuba
from moireid.simulate.motion import motion_named
from moireid.simulate.scene import Build, Camera, Scene
from moireid_lab.bench.simulate.scenes import eleven

SETTINGS = {setting.name: setting for setting in eleven()}
SMALL = Camera(width=480, height=272, focal_px=363.0, shutter_s=0.012, noise_counts=0.0)
NEAR = replace(SETTINGS["prototype, 1 m"], camera=replace(SMALL, shutter_s=0.0), distance_mm=400.0)


def shoot(badge, path: Path, **options) -> FilmReport:
    scene = Scene(badge, Build(), SMALL)
    course = motion_named("sway", distance_mm=600.0, seed=3)
    return film(scene, course, path, frames=3, fps=25.0, seed=3, crf=1, **options)


def test_mitsuba_refuses_an_error_that_it_cannot_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: the dearest setting taken in silence."""
    monkeypatch.setattr(mitsuba_estimate, "LADDER", ((16, 4),))
    with pytest.raises(SpecError, match=r"estimated 0\.\d+ rad\); give a larger error_rad="):
        cheapest_mitsuba(NEAR.scene, NEAR.seen_at(0.3), 1e-9)


def test_a_film_by_mitsuba_tells_its_error(prototype, tmp_path: Path) -> None:
    """Catches: a reference without an error bar; an estimate of another setting than is filmed."""
    report = shoot(prototype, tmp_path / "a.mp4", backend="mitsuba", error_rad=0.1)
    assert 0 < report.estimate.phase_rad <= 0.1
    assert {"rolling shutter and exposure", "lens detail below a segment"} <= set(report.left_out)
