"""Sheets and pages by name, and what the truth next to a film says of them.  Each test names what it would catch."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from moireid.cli.simulate_cmd import SHEETS
from moireid.errors import SpecError
from moireid.simulate.build import Build, sheet_named
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene
from moireid.simulate.truth import Truth, shown_phase_rad

TYPICAL = Build.typical(3)


def test_every_name_changes_one_thing_and_keeps_the_build():
    """Catches: a name of the command line that is none; a sheet that forgets how the badge was assembled."""
    for name in SHEETS:
        made = sheet_named(name, TYPICAL)
        assert len([key for key, value in vars(made).items() if value != getattr(TYPICAL, key)]) == 1
    warm = sheet_named("warm", TYPICAL)
    assert warm.lens_scale == pytest.approx(1.0014 * TYPICAL.lens_scale)
    with pytest.raises(SpecError, match="jittered"):
        sheet_named("wet", TYPICAL)


@pytest.mark.parametrize(("name", "gain"), [("", 1.0), ("thin", 0.7), ("gap", 1.2), ("warm", 1.0), ("fed", 1.0)])
def test_the_truth_tells_the_sheet_and_moves_as_it_does(prototype, name, gain):
    """Catches: the design's phase stated for another sheet; a gain that is not that of the phases."""
    scene = Scene(prototype, sheet_named(name, TYPICAL) if name else TYPICAL)
    stream = io.StringIO()
    place = np.array([50.0, 0.0, -1000.0])
    Truth(stream, scene, "genuine").add(0, 0.0, Poses(place[None], np.eye(3)[None]), place, place, None)
    columns, row = csv.reader(stream.getvalue().splitlines())
    document = dict(zip(columns, row, strict=True))
    assert float(document["air_gap_mm"]) == pytest.approx(0.1 if name == "gap" else 0.0)
    assert float(document["sheet_thickness_mm"]) == pytest.approx(0.457 / 0.67 if name == "thin" else 1.0, abs=1e-5)
    assert float(document["print_aspect"]) == pytest.approx(1.003 if name == "fed" else TYPICAL.print_aspect, abs=1e-6)
    assert float(document["sheet_gain"]) == pytest.approx(gain, abs=0.04)

    def moved(one: Scene) -> float:
        ends = [np.array([x, 0.0, -1000.0]) for x in (-50.0, 50.0)]
        first, last = (shown_phase_rad(one, prototype.gratings[0], end, end, np.zeros(2)) for end in ends)
        return last - first

    plain = Scene(replace(prototype))
    assert moved(scene) / moved(plain) == pytest.approx(float(document["sheet_gain"]), rel=0.03)
