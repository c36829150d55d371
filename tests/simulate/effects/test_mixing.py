"""Pictures mixed with those before.  Each test names what it would catch."""

from __future__ import annotations

import cv2
import numpy as np

from kit.takes import SIZE, step_of


def test_compensated_mixing_lowers_noise_of_a_picture_that_moves():
    """Catches: flow turned round, which smears what moves; no mixing at all; a picture before that is never renewed."""
    rng = np.random.default_rng(5)
    world = cv2.GaussianBlur(rng.integers(0, 256, (400, 720)).astype(np.float32), (0, 0), 4)
    world = 60 + 130 * (world - world.min()) / np.ptp(world)
    errors = {}
    for name in ("tnr:strong", "tnr-mc:strong"):
        step = step_of(name)
        for k in range(12):
            clean = world[20 : 20 + SIZE[1], 4 * k : 4 * k + SIZE[0]]
            noisy = np.clip(clean + rng.normal(0, 4, clean.shape), 0, 255).astype(np.uint8)
            shown = step(k, noisy)
        errors[name] = np.std(shown.astype(float) - clean)
    assert errors["tnr-mc:strong"] < 3.4 < 5 < errors["tnr:strong"]
