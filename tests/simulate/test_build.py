"""Builds by name, by flaw, and of a film's truth.  Next to each test: what it would catch."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import fields

import numpy as np
import pytest

from moireid.errors import SpecError
from moireid.simulate.build import BUILD_NUMBERS, Build, build_named, flawed
from moireid.simulate.filming import _check_backend
from moireid.simulate.flaw_table import FLAWS, PRESETS, read_flaw
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene
from moireid.simulate.truth import Truth


def test_a_flaw_has_a_field():
    """Catches: a field of `Build` that no option sets; two options for one."""
    named = [one.field for one in FLAWS.values()]
    assert sorted(named) == sorted({one.name for one in fields(Build)} - {"seed"})
    assert all({*wishes} <= {*FLAWS} for wishes in PRESETS.values())


def test_an_option_overrides_one_quantity():
    """Catches: degrees taken for radians; a flaw that resets the rest of the build."""
    build = flawed(build_named("usual", 1), dict([read_flaw("turn=2"), read_flaw("bow=inf")]))
    assert build.twist_rad == pytest.approx(math.radians(2)) and build.bow_radius_m == math.inf
    assert build.haze == 0.3 and build.lens_offset_mm == Build.typical(1).lens_offset_mm


def truth_text(prototype, build: Build) -> str:
    stream, place = io.StringIO(), np.array([50.0, 0.0, -1000.0])
    Truth(stream, Scene(prototype, build), "genuine").add(
        0, 0.0, Poses(place[None], np.eye(3)[None]), place, place, None
    )
    return stream.getvalue()


@pytest.mark.parametrize("name", ["ideal", "poor"])
def test_the_truth_holds_the_build_whole(prototype, name):
    """Catches: a figure that is rounded, or left out."""
    build = build_named(name, 11)
    row = next(csv.DictReader(io.StringIO(truth_text(prototype, build))))
    assert [float(row[f"build_{name}"]) for name in BUILD_NUMBERS] == [getattr(build, name) for name in BUILD_NUMBERS]


def test_mitsuba_refuses_what_it_does_not_build(prototype):
    """Catches: a reference film that silently lacks a flaw; a refusal of what it has."""
    for name in FLAWS:
        value = 0.6 if name == "bow" else 1.02 if getattr(Build(), FLAWS[name].field) == 1 else 0.01
        scene = Scene(prototype, flawed(Build(), {name: value}))
        if name in ("offset", "turn", "print-scale", "feed", "lens-scale", "thickness", "ink", "focus"):
            _check_backend(scene, "mitsuba", None)
        else:
            with pytest.raises(SpecError, match="shines evenly" if name == "glare" else f"builds no {name};"):
                _check_backend(scene, "mitsuba", None)
