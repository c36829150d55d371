"""One round lens of an array.  Each test names which wrong implementation it would catch."""

from __future__ import annotations

import numpy as np
import pytest

from moireid.badge import Lens
from moireid.errors import SpecError
from moireid.lenticule import array_response, landed_mm, trace_mm, view_law

ARRAY = Lens("array", 0.508, 1.2, 1.56)
CYLINDER = Lens("lenticular", 0.508, 1.2, 1.56)


def test_a_ray_in_the_plane_of_the_axis_is_bent_as_by_a_cylinder():
    """Catches: a wrong normal or root of the sphere.  A sphere's great circle is the cylinder's cross section."""
    start, tan = np.linspace(-0.25, 0.25, 41), np.linspace(-0.5, 0.5, 41)
    zero = np.zeros(41)
    x, y, cosine = landed_mm(ARRAY, start, zero, tan, zero)
    expected, expected_cosine = trace_mm(CYLINDER, start, tan, zero)
    np.testing.assert_allclose(x, expected, atol=1e-12)
    np.testing.assert_allclose(cosine, expected_cosine, atol=1e-12)
    np.testing.assert_allclose(y, 0.0, atol=1e-15)


def test_x_and_y_change_places_with_the_ray():
    """Catches: an exchange of the two directions, with different starts and tangents in each."""
    one = landed_mm(ARRAY, 0.1, -0.05, 0.3, 0.12)
    other = landed_mm(ARRAY, -0.05, 0.1, 0.12, 0.3)
    np.testing.assert_allclose([one[0], one[1], one[2]], [other[1], other[0], other[2]], atol=1e-15)
    assert abs(float(one[0]) - float(one[1])) > 0.05


def test_a_slanted_ray_past_the_rim_lands_under_the_neighbour():
    """Catches: a ray that leaves its square and is still bent by the lens it missed."""
    x, _, _ = landed_mm(ARRAY, 0.25, 0.0, 0.9, 0.0)
    expected, _ = trace_mm(CYLINDER, np.array(0.25), np.array(0.9), np.array(0.0))
    assert float(x) == pytest.approx(float(expected), abs=1e-12)
    assert float(x) > 0.508


def test_the_law_is_odd_along_and_even_across():
    """Catches: an aperture that is not square about the axis."""
    tan_x, tan_y = np.array([0.2, -0.2, 0.2]), np.array([0.1, 0.1, -0.1])
    there, back, mirrored = array_response(ARRAY, 0.52, tan_x, tan_y)
    assert there == pytest.approx(np.conj(back), abs=1e-12)
    assert there == pytest.approx(mirrored, abs=1e-12)


def test_an_array_moves_fringes_nearly_as_far_as_a_sheet():
    """Catches: a law of another thickness or index.  The corners of a round lens add spherical aberration: 1 %."""
    array, sheet = (view_law(lens, 0.52).effective_gap_mm(0.52) for lens in (ARRAY, CYLINDER))
    assert array == pytest.approx(sheet, rel=0.02)
    assert array < sheet


def test_round_lenses_must_meet_at_the_corners():
    """Catches: the limit of cylinders, half a pitch, taken for spheres."""
    with pytest.raises(SpecError, match="half the diagonal"):
        Lens("array", 0.508, 0.9, 1.56)
    Lens("lenticular", 0.508, 0.9, 1.56)
