"""What neighbours add to a cell where lines pass into each other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from kit.numeric_films import Building, filmed
from kit.payloads import payload_for_name
from moireid.badge import Badge
from moireid.designer import Order, design_badge
from moireid.frames import own_rect
from moireid.idcodes.pitch import steps_from_reference
from moireid.idcodes.spacing import PHASE_LEVELS, true_phases_rad
from moireid.question import KnownCamera
from moireid.verifier.fringes.signals import Measurement, measure
from moireid.verifier.identity import cell_phase, neighbour_lines
from moireid.verifier.identity.cell_phase import UNREAD, uniform_readings
from moireid.verifier.identity.decode import read_identity
from moireid.verifier.identity.neighbour_lines import ahead_of_own_lines
from moireid.verifier.tracking.track import Track


@pytest.fixture(scope="module")
def silk() -> Badge:
    return design_badge(Order("Ada", lens="50lpi", pattern="silk"), payload_for_name("Ada"))


@pytest.fixture(scope="module")
def seen(silk: Badge) -> tuple[Track, Measurement]:
    track = filmed(silk, Building(scale=1.003, offset_rad=2.1, twist_rad_per_mm=0.025))
    return track, measure(track, camera=KnownCamera(1450.0))


def errors_rad(silk: Badge, seen: tuple[Track, Measurement]) -> np.ndarray:
    cells = read_identity(*seen).cells
    true = true_phases_rad(bytes.fromhex(silk.id or ""), silk.gratings)
    return np.array([math.remainder(cells[g][c].free_rad - phase, 2 * math.pi) for (g, c), phase in true.items()])


def test_cells_are_read_less_what_neighbours_add(silk, seen, monkeypatch: pytest.MonkeyPatch):
    """Catches: a correction of the wrong sign or none, cells and rows mixed up; cells that are not read whole."""
    # These films are made of numbers and have no blur.
    monkeypatch.setattr(neighbour_lines, "PICTURE_BLUR_PX", 0.05)
    corrected = np.sqrt(np.mean(errors_rad(silk, seen) ** 2))
    none = dict.fromkeys(range(len(silk.gratings[0].cells)), np.zeros(len(seen[0].strips[0].along_mm)))
    monkeypatch.setattr(cell_phase, "ahead_of_own_lines", lambda *_: none)
    assert corrected < 0.03 and np.sqrt(np.mean(errors_rad(silk, seen) ** 2)) > 0.06


def test_a_cell_ahead_takes_its_neighbours_along(silk, seen):
    """Catches: a sign turned round; a cell that changes all others; a field that is mirrored."""
    track, measurement = seen
    code = silk.gratings[0].code
    assert code is not None
    uniform = uniform_readings(track, measurement, 0)
    beats = steps_from_reference([uniform.get(k, UNREAD) for k in range(len(code.roles))], silk.gratings[0])
    steps = [round(beats[k][0]) for k in sorted(uniform)]
    row = next(strip for strip in track.strips if len(strip.cells) > 3)
    cells, chosen = [k for k, role in enumerate(code.roles) if role == "phase"], row.cells[2]
    level = ahead_of_own_lines(track, 0, dict.fromkeys(cells, 0), steps)
    moved = ahead_of_own_lines(track, 0, dict.fromkeys(cells, 0) | {chosen: 1}, steps)
    shares = {}
    for cell in row.cells[:5]:
        low, _, high, _ = own_rect(silk.gratings[0].axis, silk.gratings[0].cells[cell].rect_mm)
        inside = (row.along_mm > low + 1) & (row.along_mm < high - 1)
        shares[cell] = float((moved[cell] - level[cell])[inside].mean()) / (2 * math.pi / PHASE_LEVELS)
    before, left, own, right, after = shares.values()
    assert before == pytest.approx(0, abs=1e-3) and after == pytest.approx(0, abs=1e-3)
    assert left == pytest.approx(right, rel=0.2) and 0.01 < left < 0.2 and own < -0.02


def test_beats_of_the_rows_are_those_of_the_badge(silk, seen):
    """Catches: rows in another order; steps of the wrong sign."""
    pitches = [
        cell.pitch_mm for cell, role in zip(silk.gratings[0].cells, _roles(silk), strict=True) if role != "phase"
    ]
    uniform = uniform_readings(*seen, 0)
    found = steps_from_reference([uniform.get(k, UNREAD) for k in range(len(_roles(silk)))], silk.gratings[0])
    steps = [found[k][0] for k in sorted(uniform)]
    beats = np.subtract(np.reciprocal(pitches), 1 / silk.gratings[0].pitch_mm)
    assert steps == pytest.approx(list(beats / silk.gratings[0].code.frequency_step_per_mm), abs=0.05)


def _roles(badge: Badge) -> tuple[str, ...]:
    code = badge.gratings[0].code
    assert code is not None
    return code.roles
