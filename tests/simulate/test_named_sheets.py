"""What the truth next to a film says of another sheet.  Each test names what it would catch."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from moireid.simulate.build import Build
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Scene
from moireid.simulate.truth import Truth, shown_phase_rad

TYPICAL = Build.typical(3)


@pytest.mark.parametrize(
    ("flaw", "gain"),
    [({}, 1.0), ({"thickness_ratio": 0.68}, 0.63), ({"air_gap_mm": 0.1}, 1.2), ({"lens_scale": 1.0014}, 1.0)],
)
def test_the_truth_tells_the_sheet_and_moves_as_it_does(prototype, flaw, gain):
    """Catches: the design's phase stated for another sheet; a gain that is not that of the phases."""
    scene = Scene(prototype, replace(TYPICAL, **flaw))
    stream = io.StringIO()
    place = np.array([50.0, 0.0, -1000.0])
    Truth(stream, scene, "genuine").add(0, 0.0, Poses(place[None], np.eye(3)[None]), place, place, None)
    columns, row = csv.reader(stream.getvalue().splitlines())
    document = dict(zip(columns, row, strict=True))
    assert float(document["sheet_gain"]) == pytest.approx(gain, abs=0.04)

    def moved(one: Scene) -> float:
        ends = [np.array([x, 0.0, -1000.0]) for x in (-50.0, 50.0)]
        first, last = (shown_phase_rad(one, prototype.gratings[0], end, end, np.zeros(2)) for end in ends)
        return last - first

    plain = Scene(replace(prototype))
    assert moved(scene) / moved(plain) == pytest.approx(float(document["sheet_gain"]), rel=0.03)
