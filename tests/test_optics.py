"""The phase law in closed form: signs, limits, and the geometry that it is of, written again here."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from moireid import optics
from moireid.errors import DesignError

#: The published prototype: front and rear pitch in mm, and the effective gap that was traced for its sheet.
FRONT, REAR, G_EFF = 0.508, 0.52, 0.60
#: A rear pitch finer than the lens: every sign of the prototype turned round.
FINER = 0.497


# The beat in space.


@pytest.mark.claim("The beat of two gratings is the textbook's fraction")
def test_beat_of_the_prototype_is_the_textbook_fraction() -> None:
    """Catches: |p_f - p_r| in place of a signed difference, or front and rear swapped."""
    exact = 1 / Fraction("0.52") - 1 / Fraction("0.508")
    beat = float(optics.beat_frequency_per_mm(FRONT, REAR))
    assert beat == pytest.approx(float(exact), rel=1e-12)
    assert beat == pytest.approx(-0.045427, abs=1e-6)
    assert float(optics.beat_period_mm(beat)) == pytest.approx(FRONT * REAR / (REAR - FRONT), rel=1e-12)
    assert float(optics.beat_period_mm(beat)) == pytest.approx(22.0, abs=0.05)
    near = optics.beat_frequency_per_mm(FRONT, REAR, effective_gap_mm=0.603, distance_mm=1000.0)
    assert 1 - float(near) / beat == pytest.approx(0.0255, abs=0.0003)


def test_equal_layers_have_no_beat_and_an_infinite_period() -> None:
    """Catches: a division by zero, or a small epsilon in the denominator that makes up a period."""
    assert float(optics.beat_frequency_per_mm(FRONT, FRONT)) == 0.0
    with np.errstate(all="raise"):
        assert optics.beat_period_mm([0.0, -0.25, 0.5]).tolist() == [math.inf, 4.0, 2.0]


@pytest.mark.claim("The beat at a distance is that of lines drawn from the camera")
@pytest.mark.parametrize("rear", [REAR, FINER])
@pytest.mark.parametrize("distance_mm", [300.0, 1000.0, 4200.0])
def test_beat_at_a_distance_is_that_of_lines_drawn_from_the_camera(rear: float, distance_mm: float) -> None:
    """Catches: (1 - g/D), or the correction on the front layer.

    Two routes: neighbouring printed lines a gap behind the front plane are drawn onto it along sight lines from the
    camera; they stand D / (D + g) as far apart there.
    """
    seen_pitch = rear * distance_mm / (distance_mm + G_EFF)
    beat = optics.beat_frequency_per_mm(FRONT, rear, effective_gap_mm=G_EFF, distance_mm=distance_mm)
    assert float(beat) == pytest.approx(1 / seen_pitch - 1 / FRONT, rel=1e-10)


@pytest.mark.parametrize("beat", [-0.0454, -1.2, 0.0, 0.03, 1.7])
def test_rear_pitch_is_the_inverse_of_the_beat(beat: float) -> None:
    """Catches: a pitch on the other side of the lens pitch."""
    rear = optics.rear_pitch_for_beat_mm(FRONT, beat)
    assert float(optics.beat_frequency_per_mm(FRONT, rear)) == pytest.approx(beat, abs=1e-12)
    assert (float(rear) > FRONT) == (beat < 0)


@pytest.mark.parametrize("pitch", [0.0, -0.5, math.nan, math.inf])
def test_a_pitch_that_is_none_is_refused(pitch: float) -> None:
    """Catches: a check of one layer only, or one that lets NaN pass."""
    with pytest.raises(DesignError, match="pitches"):
        optics.beat_frequency_per_mm(pitch, REAR)
    with pytest.raises(DesignError, match="pitches"):
        optics.beat_frequency_per_mm(FRONT, [REAR, pitch])


# The view.


def test_slab_at_45_degrees_is_exact() -> None:
    """Catches: the small-angle law.  sin 45 / n refracted: tan = 1 / sqrt(2 n^2 - 1)."""
    expected = 2.0 / math.sqrt(2 * 1.56**2 - 1)
    assert float(optics.slab_shift_mm(2.0, 1.56, 1.0)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("tan_x", "tan_y"), [(0.3, 0.8), (-0.9, 0.4), (1.2, -1.1), (0.05, 1.5)])
def test_slab_in_three_dimensions_bends_in_the_plane_of_incidence(tan_x: float, tan_y: float) -> None:
    """Catches: Snell's law applied to x and y one by one.  Second route: bend in the plane of incidence."""
    steepness = math.hypot(tan_x, tan_y)
    bent = math.tan(math.asin(math.sin(math.atan(steepness)) / 1.56))
    assert float(optics.slab_shift_mm(1.0, 1.56, tan_x, tan_y)) == pytest.approx(bent * tan_x / steepness, rel=1e-12)
    assert float(optics.slab_shift_mm(1.0, 1.56, -tan_x, -tan_y)) == pytest.approx(-bent * tan_x / steepness, rel=1e-12)


def test_slopes_of_the_small_angle_law_agree_with_its_phase() -> None:
    """Catches: a slope without 2 pi, over p_f, or without the factor 1 + g/D; phase falls as the camera goes to +x."""

    def phase(x: float, camera_x: float, distance: float) -> float:
        tangent = (x - camera_x) / distance
        law = optics.fringe_phase_rad(x, tangent, front_pitch_mm=FRONT, rear_pitch_mm=REAR, effective_gap_mm=G_EFF)
        return float(law)

    distance = 700.0
    by_parallax = (phase(3.0, 71.0, distance) - phase(3.0, 1.0, distance)) / (70.0 / distance)
    assert by_parallax == pytest.approx(-optics.parallax_slope_rad(G_EFF, REAR), rel=1e-9)
    assert optics.parallax_slope_rad(G_EFF, REAR) == pytest.approx(2 * math.pi * 0.6 / 0.52)
    along = (phase(9.0, 40.0, distance) - phase(2.0, 40.0, distance)) / 7.0
    beat = optics.beat_frequency_per_mm(FRONT, REAR, effective_gap_mm=G_EFF, distance_mm=distance)
    assert along == pytest.approx(2 * math.pi * float(beat), rel=1e-9)


@pytest.mark.claim("The phase law is what lenses sample off the printed lines")
@pytest.mark.parametrize("rear", [REAR, FINER])
def test_phase_law_is_what_the_lenses_sample_off_the_printed_lines(rear: float) -> None:
    """Catches: any sign or factor of the law.  Second route: lens k shows the page under it, shifted by the view."""
    lenses = np.arange(-80, 81) * FRONT
    tangent = (lenses - 37.0) / 640.0
    page_phase = 2 * np.pi * (lenses + G_EFF * tangent) / rear
    law = optics.fringe_phase_rad(lenses, tangent, front_pitch_mm=FRONT, rear_pitch_mm=rear, effective_gap_mm=G_EFF)
    assert np.exp(1j * law) == pytest.approx(np.exp(1j * page_phase), abs=1e-9)


@pytest.mark.claim(
    "The published law is that of two gratings seen by a pinhole, and ends where the badge turns in its place"
)
def test_the_published_law_is_that_of_two_gratings_seen_by_a_pinhole() -> None:
    """Catches: a factor 1 + g/D that counts twice, a turn of the camera that moves fringes, or one of the badge that
    does not.  Second route: sight lines in the plane, from a pinhole to both layers."""
    gap, focal = 1.0, 1450.0

    def seen(camera: tuple[float, float], camera_turn: float = 0.0, badge_turn: float = 0.0) -> tuple[float, float]:
        """Where the badge's middle is in the picture, in px, and the phase of the fringes there."""
        across, away = camera
        pixel = focal * math.tan(math.atan2(-across, away) + camera_turn)
        own = math.atan2(across, away) - badge_turn
        return pixel, 2 * math.pi * -gap * math.tan(own) / REAR

    pixels, phases = np.transpose([seen((across, 700 + 5 * across)) for across in range(-60, 61, 20)])
    slope = np.diff(phases) / np.diff(pixels)
    assert slope == pytest.approx(2 * math.pi * gap / (REAR * focal), rel=1e-9)
    # Counted from the page, the distance has the published factor.
    page, front = 501.0, 500.0
    assert 2 * math.pi * gap / (REAR * page) * (1 + gap / front) == pytest.approx(-seen((1.0, front))[1], rel=1e-12)
    still, turned, leaning = seen((0.0, 900.0)), seen((0.0, 900.0), camera_turn=0.01), seen((0.0, 900.0), 0.0, 0.017453)
    assert turned[1] == still[1] and turned[0] - still[0] == pytest.approx(14.5, abs=0.01)
    assert leaning[0] == still[0] and leaning[1] - still[1] == pytest.approx(0.211, abs=0.001)
    # Lines that are shifted by d move the fringes 42 times as far.
    magnified = float(optics.beat_period_mm(optics.beat_frequency_per_mm(FRONT, REAR))) / REAR
    assert magnified == pytest.approx(FRONT / (REAR - FRONT), rel=1e-12) == pytest.approx(42.33, abs=0.01)


@pytest.mark.parametrize(
    ("gap", "rear", "focal", "away"),
    [(1.0, REAR, 1450.0, 700.0), (3.0, FINER, 600.0, 3000.0), (0.4, 0.33, 960.0, 300.0)],
)
def test_the_published_correlation_is_1_whatever_the_device_and_the_distance_are(
    gap: float, rear: float, focal: float, away: float
) -> None:
    """Catches: a phase that depends on the distance in another way than the badge's place in the picture does."""
    across = np.linspace(-60.0, 60.0, 41)
    distance = away * (1 + 0.2 * np.sin(across / 15))
    phase = optics.fringe_phase_rad(
        0.0, -across / distance, front_pitch_mm=FRONT, rear_pitch_mm=rear, effective_gap_mm=gap
    )
    assert abs(np.corrcoef(-focal * across / distance, phase)[0, 1]) == pytest.approx(1.0, abs=1e-12)


def test_the_published_place_is_bent_by_the_orientation_of_the_first_frame() -> None:
    """Catches: a correlation that shows what a reference orientation does to a board that is turned by 20 degrees."""
    view, first = np.radians(np.linspace(-10.0, 10.0, 2001)), math.radians(20.0)
    turn = np.array([[math.cos(first), -math.sin(first)], [math.sin(first), math.cos(first)]])
    across, away = turn @ np.stack([np.sin(view), np.cos(view)])
    place, parallax = across / away, np.tan(view)
    slope = np.diff(place) / np.diff(parallax)
    assert slope.max() / slope.min() == pytest.approx(1.29, abs=0.005)
    assert np.corrcoef(place, parallax)[0, 1] > 0.999


@pytest.mark.parametrize("beat", [-1 / FRONT, -5.0, math.nan, -math.inf])
def test_a_beat_that_no_pitch_makes_is_refused(beat: float) -> None:
    """Catches: a negative, infinite or NaN pitch handed back as if lines could be drawn with it."""
    with pytest.raises(DesignError, match="no printed pitch"):
        optics.rear_pitch_for_beat_mm(FRONT, [0.01, beat])
