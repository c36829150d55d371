"""Photographs re-posed onto a trajectory.  Each test states what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.designer import Request, design_badge
from moireid.simulate import Build, Camera, Scene, motion_named
from moireid.simulate.forgeries.rear_layer import SquaredUp
from moireid_lab.bench.forgers.reposed import REACH_MM, Field, Reposer, fields_of, for_all_fields, over, whole_of

TIMES = np.arange(90) / 30
PAYLOAD = bytes.fromhex("0f5ac3962d784be1")


def direction(degrees: float) -> Field:
    angle = math.radians(degrees)
    return Field(np.array([[math.cos(angle)], [math.sin(angle)]]))


def circle(radius: float = 0.1, away: float = 0.035) -> np.ndarray:
    """Views on a circle, at one distance or at two."""
    turn = 2 * np.pi * TIMES / 3
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(90, away)])


@pytest.mark.parametrize("angles", [(0,), (0, 90), (0, 60, 120)])
def test_one_set_of_photographs_is_even_for_every_field(angles):
    """Catches: places along a line, of which some field sees only a few."""
    fields, count, views = [direction(angle) for angle in angles], 15, circle()
    places = for_all_fields(views, fields, count)
    for field in fields:
        seen = np.sort((places[:, :2] @ field.senses)[:, 0])
        course = views[:, :2] @ field.senses
        wanted = np.ptp(course) / (count - 1)
        within = seen[(seen > course.min() - wanted) & (seen < course.max() + wanted)]
        assert np.diff(within).max() < 1.25 * wanted
        assert within.min() < course.min() + wanted and within.max() > course.max() - wanted


def test_a_plane_of_views_needs_the_square_of_what_a_line_needs():
    """Catches: places spread over one coordinate only, or a distance that is counted where it stays still."""
    rng = np.random.default_rng(3)
    views = np.column_stack([rng.uniform(-0.2, 0.2, (2000, 2)), np.full(2000, 0.035)])

    def worst(field: Field, count: int) -> float:
        places = over(views, field, count)
        here, there = field.seen(views, places)
        assert here.shape[1] == field.senses.shape[1]
        return float(np.min(np.linalg.norm(here[:, None] - there[None], axis=2), axis=1).mean())

    line, plane = direction(0), Field(np.eye(2))
    assert worst(line, 8) / worst(line, 32) == pytest.approx(4, rel=0.15)
    assert worst(plane, 16) / worst(plane, 64) == pytest.approx(2, rel=0.15)


def test_a_changing_distance_is_a_coordinate_of_its_own():
    """Catches: photographs from one distance for a course that comes nearer."""
    views = circle()
    views[:, 2] = REACH_MM / np.linspace(500, 1500, 90)
    assert direction(0).seen(views)[0].shape[1] == 2
    assert np.ptp(over(views, direction(0), 12)[:, 2]) > 0.5 * np.ptp(views[:, 2])


def test_fields_are_distinguished_and_an_array_is_taken_whole():
    """Catches: an array taken for two fields because its two gratings' axes differ."""
    two = design_badge(Request("Bench", axes="xy"), PAYLOAD)
    assert [field.grating for field in fields_of(two)] == [None, two.gratings[1]]
    assert whole_of(two).senses.shape == (2, 2)
    assert whole_of(design_badge(Request("Bench"), PAYLOAD)).senses.shape == (2, 1)


@pytest.mark.slow
@pytest.mark.parametrize("blend", [False, True])
def test_a_film_of_many_photographs_is_nearly_the_true_one(blend):
    """Catches: pictures taken from the wrong side, mixed with weights that do not sum to one, or fields exchanged."""
    badge = design_badge(Request("Bench", axes="xy"), PAYLOAD)
    scene = Scene(badge, Build(), Camera(1280, 720, 1150.0))
    camera = motion_named("circle", distance_mm=1000, seed=1)(TIMES).camera_mm
    motion = motion_named("circle", distance_mm=1000, seed=1)
    few, many = (Reposer(count, blend, by_field=True).shown(scene, motion, camera, 30.0) for count in (5, 41))
    frame = 17
    true = SquaredUp(scene, 3.0).picture(camera[frame])
    far, near = (float(np.abs(shown.picture(frame) - true).mean()) for shown in (few, many))
    # The picture that is compared with is itself taken from the page's plane, which leaves a third.
    assert near < 0.5 * far
