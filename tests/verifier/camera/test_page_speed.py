"""What of a page's speed hides between the frames.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kit.made_corners import FPS, MIDDLE, PAGE_MM, SIZE, project, registered, rolled, tangents
from moireid.simulate.motion import measured_run
from moireid.verifier.camera.fit import fit_camera
from moireid.verifier.camera.page_speed import hidden_speed_px_s


class Hand:
    """A measured run of a hand, from a moment on, before the badge."""

    def __init__(self, start_s: float) -> None:
        self._start, self._run = start_s, measured_run(1100.0)

    def pose(self, times: np.ndarray) -> tuple[np.ndarray, Rotation]:
        poses = self._run(times + self._start)
        return poses.camera_mm + np.append(MIDDLE, 0.0), Rotation.from_matrix(poses.rotation)


@pytest.mark.parametrize("start_s", [2.0, 10.0])
def test_a_tremor_that_hides_between_frames_costs_the_rows_their_say(rng, start_s):
    """Catches: rows that a hand moved while they were read, taken for tilts: errors of the poses that are four to five
    times as large as they are told to be.
    """
    times = np.arange(180) / FPS
    hand = Hand(start_s)
    fit = fit_camera(registered(rolled(hand, times, 1450.0, 0.012), rng, 0.05), PAGE_MM, times, SIZE)
    error = np.std(tangents(fit.camera_mm) - tangents(hand.pose(times)[0]), axis=0)
    assert np.all(error < 2.5 * np.array(fit.tangent_error))


@pytest.mark.parametrize(("fps", "errs_px_s"), [(15.0, 126.0), (30.0, 79.0), (50.0, 49.6)])
def test_what_hides_is_what_a_spline_through_the_frames_misses(fps, errs_px_s):
    """Catches: a speed that is right at one frame rate alone.  Against the median error of such splines, by hand."""
    times = np.arange(int(16 * fps)) / fps
    run = measured_run(1400.0)(times)
    seen = project(run.camera_mm + np.append(MIDDLE, 0.0), Rotation.from_matrix(run.rotation), 1150.0)
    assert hidden_speed_px_s(seen, times, np.zeros(len(times), bool)) == pytest.approx(errs_px_s, rel=0.4)
