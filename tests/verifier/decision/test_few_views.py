"""Films of few views, from the picture to the verdict.  Beside each test: what it would catch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from moireid.simulate.filming import film
from moireid.simulate.motion import Poses
from moireid.simulate.scene import Build, Scene
from moireid.verifier import Question, verify
from moireid_lab.bench.forgers.forgers_suite import CAMERA, badge_of

FPS, FRAMES = 12.0, 110


@pytest.mark.slow
@pytest.mark.parametrize(("views", "hold"), [(3, 1), (3, 12), (None, 1)])
def test_true_pictures_of_a_badge_turned_on_the_spot_must_show_the_way_between(tmp_path, views, hold):
    """Catches: a few true photographs, shown in turn, as a film: they obey the law, and the page hardly moves.

    The last film, of a badge that is turned to and fro by a hand as far, must be accepted.
    """
    badge = badge_of("x")

    def turned(times_s):
        frame = np.rint(np.asarray(times_s) * FPS).astype(int)
        phase = 2 * np.pi * 0.45 * np.asarray(times_s)
        shown = np.sin(phase + 0.8 * np.sin(0.9 * phase)) if views is None else None
        if views is not None:
            order = [*range(views), *range(views - 2, 0, -1)]
            shown = np.take(np.linspace(-1, 1, views), np.take(order, frame // hold % len(order)))
        turn = Rotation.from_euler("yx", np.column_stack([5.0 * shown, 2.0 * shown**2]), degrees=True)
        return Poses(-turn.inv().apply([0.0, 0.0, 1000.0]), turn.as_matrix())

    path = tmp_path / "film.mp4"
    film(Scene(badge, Build.typical(1), CAMERA), turned, path, frames=FRAMES, fps=FPS, seed=1)
    report = verify(path, Question(badge, badge.id))
    open_codes = {reason.code for reason in report.reasons if reason.level in ("fail", "undecided")}
    assert not open_codes if views is None else {"cross_fade"} <= open_codes <= {"cross_fade", "gain"}
    assert (report.verdict == "accept") == (views is None)
