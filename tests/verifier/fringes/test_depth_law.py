"""Does the fringes' spacing follow the distance?  Beside each test: what it would catch.

A strip of a badge by its first-order law: a sight line of tangent t = X near - u through page place X, where u is the
camera's parallax and near is one over its distance, has 2 pi [SHIFT (t + BENT t^3) + f (X - THICK t)].
"""

from __future__ import annotations

import numpy as np
import pytest

from moireid.verifier.fringes.beyond_phase import depth_law
from moireid.verifier.fringes.grating_signal import BeyondPhase, DepthLaw
from moireid.verifier.fringes.strip_phase import StripLaw, StripPhase, measure_strip
from moireid.verifier.fringes.strip_shape import strip_shape

FRAMES, SAMPLES, LENGTH_MM, FREQUENCY = 240, 150, 76.0, -0.045
ALONG = np.linspace(-LENGTH_MM / 2, LENGTH_MM / 2, SAMPLES)
SHIFT, BENT, THICK = 1.1, 0.15, 0.8
TIMES = np.arange(FRAMES) / 30.0
PARALLAX = 0.16 * np.sin(2 * np.pi * 0.4 * TIMES) + 0.05 * np.sin(2 * np.pi * 0.9 * TIMES + 1)
#: A hand's way to and from the camera, 3 % of a metre.
NEAR = 1e-3 * (1 + 0.03 * np.sin(2 * np.pi * 0.23 * TIMES + 0.4))


def law_of(near: np.ndarray, parallax: np.ndarray = PARALLAX) -> StripLaw:
    def at(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        tangent = places * near[:, None] - parallax[:, None]
        return SHIFT * (tangent + BENT * tangent**3), places - THICK * tangent

    (fixed, per_frequency), (middle, own) = at(ALONG[None]), at(np.zeros((1, 1)))
    return StripLaw(fixed, per_frequency, middle[:, 0], own[:, 0])


def evidence(
    shown_near: np.ndarray,
    *,
    near: np.ndarray = NEAR,
    parallax: np.ndarray = PARALLAX,
    noise: float = 0.0,
    seed: int = 0,
    along: np.ndarray | float = 0.0,
    dark: slice = slice(0),
) -> tuple[DepthLaw, StripPhase]:
    """Evidence of a film whose camera is at `near` and whose fringes are spaced as at `shown_near`.

    along: phase (T, N) added to the fringes, rad; dark: frames that show none.
    """
    law, shown = law_of(near, parallax), law_of(shown_near, parallax)
    phase = shown.phase_rad(FREQUENCY) + shown.middle_phase_rad(FREQUENCY)[:, None] + along
    wave = np.cos(phase) + 0.3 * np.cos(2 * phase + 0.8) + 0.12 * np.cos(3 * phase - 1.1)
    wave[dark] = 0.0
    profiles = 120.0 + 0.2 * ALONG + 45.0 * wave + noise * np.random.default_rng(seed).standard_normal(wave.shape)
    found = measure_strip(profiles, law, LENGTH_MM, (FREQUENCY - 0.004, FREQUENCY + 0.004))
    return depth_law(strip_shape(profiles, law, found), law, found, parallax, LENGTH_MM), found


def gain_of(found: DepthLaw) -> tuple[float, float]:
    """Gain and its error bar for white noise."""
    information = float(found.information.sum())
    return 1 + float(found.score.sum()) / information, information**-0.5


def spaced(share: float) -> np.ndarray:
    """One over the distance, of whose change a share is shown."""
    return NEAR.mean() + share * (NEAR - NEAR.mean())


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0, -1.0])
def test_the_gain_is_the_share_of_the_change_that_is_shown(share):
    """Catches: a gain of the wrong sign or scale, a table of photographs (0) taken for a badge (1)."""
    quiet, _ = evidence(spaced(share))
    assert gain_of(quiet)[0] == pytest.approx(share, abs=0.02)
    noisy, _ = evidence(spaced(share), noise=2.0)
    gain, sd = gain_of(noisy)
    assert abs(gain - share) < 3.5 * sd and sd < 0.1


@pytest.mark.slow
def test_the_error_bar_is_honest():
    """Catches: information in other units than the noise's, so that strips would be weighted wrongly."""
    off = []
    for seed in range(24):
        gain, sd = gain_of(evidence(NEAR, noise=4.0, seed=seed)[0])
        off.append((gain - 1) / sd)
    # 24 samples know their deviation to 15 %.
    assert 0.6 < np.sqrt(np.mean(np.square(off))) < 1.5


@pytest.mark.parametrize("bend", [1, 2])
@pytest.mark.parametrize("power", [1, 2, 3])
def test_what_depends_on_parallax_alone_is_not_taken_for_distance(power, bend):
    """Catches: a bent sheet, a wrong focal length or an untraced law, which stretch the fringes as the view turns."""
    along = 0.05 * (PARALLAX[:, None] / 0.2) ** power * (ALONG / ALONG[-1]) ** bend
    assert gain_of(evidence(NEAR, along=along)[0])[0] == pytest.approx(1.0, abs=0.03)
    assert gain_of(evidence(spaced(0.0), along=along)[0])[0] == pytest.approx(0.0, abs=0.03)


def test_a_distance_that_goes_with_parallax_tells_nothing():
    """Catches: a camera on an arc, whose photographs show the right spacing too, counted as evidence."""
    arc = 1e-3 * (1 + 0.05 * PARALLAX - 0.8 * PARALLAX**2)
    free, _ = evidence(NEAR, noise=2.0)
    bound, _ = evidence(arc, near=arc, noise=2.0)
    assert bound.information.sum() < 1e-4 * free.information.sum()


def test_frames_that_cannot_be_read_count_nothing():
    """Catches: the noise of a covered strip taken for spacing, NaN from a contrast of 0."""
    dark = slice(60, 100)
    found, strip = evidence(NEAR, noise=2.0, dark=dark)
    assert not (strip.phase_sd_rad[dark] < 0.3).any()
    for values in (found.score, found.information, found.power):
        assert np.isfinite(values).all() and not values[dark].any() and values[:60].any()
    assert gain_of(found)[0] == pytest.approx(1.0, abs=0.3)


def test_sums_and_parts_are_evidence_too():
    """Catches: gains that are averaged where evidence adds up; parts by another series' frames."""
    one, two = evidence(NEAR, noise=2.0)[0], evidence(NEAR, noise=6.0, seed=1)[0]
    both = DepthLaw(*(a + b for a, b in zip(one, two, strict=True)))
    weights = one.information.sum(), two.information.sum()
    assert weights[0] > 4 * weights[1]
    assert gain_of(both)[0] == pytest.approx(np.average([gain_of(one)[0], gain_of(two)[0]], weights=weights))
    whole = BeyondPhase(PARALLAX, both, 0j * PARALLAX, np.zeros((FRAMES, 2)), 1 + 0j * PARALLAX)
    early, late = (whole.part(frames).depth for frames in (slice(0, 100), np.arange(100, FRAMES)))
    for name in ("score", "information", "power"):
        apart = np.concatenate([getattr(early, name), getattr(late, name)])
        assert apart == pytest.approx(getattr(both, name))
