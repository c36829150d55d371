"""What of a page's speed hides between the frames.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from kit.made_corners import FPS, PAGE_MM, SIZE, Course, project, registered, tangents
from moireid.verifier.camera.fit import fit_camera
from moireid.verifier.camera.page_speed import hidden_speed_px_s
from moireid.verifier.limits import TREMOR_HZ


def test_a_tremor_that_hides_between_frames_costs_the_rows_their_say(rng):
    """Catches: rows that a tremor of the hand moved taken for tilts: the error of poses far above what is told of it,
    and a focal length a tenth too short.  A tremor of 11 Hz with a new phase in each frame is what 15 frames a second
    see.
    """
    times = np.arange(150) / 15.0
    course = Course(rng, 900.0, sway_mm=220.0)
    camera, turn = course.pose(times)
    clean = project(camera, turn, 1450.0)
    speeds = rng.normal(0.0, 120.0, (len(times), 1, 2))
    rows = (clean[..., 1:] - SIZE[1] / 2) / SIZE[1]
    shaken = registered(clean + speeds / (2 * np.pi * TREMOR_HZ) + 0.016 * rows * speeds, rng, 0.05)
    fit = fit_camera(shaken, PAGE_MM, times, SIZE)
    assert hidden_speed_px_s(shaken, times, np.zeros(len(times), bool)) == pytest.approx(120.0, rel=0.25)
    assert abs(fit.focal_px - 1450.0) < 2.5 * fit.focal_sd_px and fit.focal_sd_px < 0.1 * fit.focal_px
    error = np.std(tangents(fit.camera_mm) - tangents(camera), axis=0)
    assert np.all(error < 2 * np.array(fit.tangent_error))


def test_a_calm_path_hides_nothing(rng):
    """Catches: a motion that the frames show well taken for a tremor, so that its rows count for less."""
    times = np.arange(150) / FPS
    seen = registered(project(*Course(rng, 900.0, sway_mm=220.0).pose(times), 1450.0), rng, 0.05)
    assert hidden_speed_px_s(seen, times, np.zeros(len(times), bool)) < 5.0
