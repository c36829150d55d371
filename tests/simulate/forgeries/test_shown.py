"""What forged films show, and the truth that is written of it.  Each test names what it would catch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from moireid.badge import Badge
from moireid.simulate.analytic.analytic_renderer import AnalyticRenderer, BoardRadiance
from moireid.simulate.forgeries.rear_layer import (
    CLOCK_S,
    PATCHES,
    PHOTO_PX_PER_MM,
    OwnClocks,
    ShownViews,
    SquaredUp,
    parallax,
    shown_in,
)
from moireid.simulate.forgeries.trajectories import KINDS
from moireid.simulate.motion import Poses
from moireid.simulate.recording.sensor import opened
from moireid.simulate.scene import Build, Camera, Instant, Scene
from moireid.simulate.truth import shown_phase_rad

FPS = 30.0
#: The board fills the picture at 600 mm: 0.6 px to the millimetre.
NEAR = Camera(width=400, height=400, focal_px=1450.0, shutter_s=0.0)


def frontal_swing(times_s: np.ndarray) -> Poses:
    """A camera that slides sideways and up and never turns: the board keeps its shape in the picture."""
    times_s = np.atleast_1d(times_s)
    camera = np.column_stack([70 * np.sin(2 * times_s), 20 * np.sin(3 * times_s), np.full_like(times_s, -900.0)])
    return Poses(camera, np.tile(np.eye(3), (len(times_s), 1, 1)))


def seen(badge: Badge, kind: str | None, *frames: int) -> tuple[list[BoardRadiance], ShownViews]:
    """What some frames of a film of 60 show of the board."""
    scene = Scene(badge, Build(), NEAR)
    shown = shown_in(kind, scene, frontal_swing, frontal_swing(np.arange(60) / FPS).camera_mm, FPS, 3)
    render, boards = AnalyticRenderer(scene).render, []
    for frame in frames:
        opening = opened(frontal_swing, NEAR, scene.board_half_mm, frame / FPS, FPS)[1]
        board = render(shown.instant(frame, opening))
        assert board is not None
        boards.append(board)
    return boards, shown


def fringe_phase(badge: Badge, board: BoardRadiance, pose: Poses, camera: Camera = NEAR) -> float:
    """Phase of the middle rows' fringe at the board's centre, page plane, from a picture whose camera looks along z.

    A cosine of the beat that the picture's own distance gives is fitted to 9 mm of rows about the centre.
    """
    focal, (x, y, z) = camera.focal_px, pose.camera_mm[0]
    columns = np.arange(board.radiance.shape[1]) + board.left
    rows = np.arange(board.radiance.shape[0]) + board.top
    place_x = (columns - camera.matrix[0, 2]) * abs(z) / focal + x
    place_y = (rows - camera.matrix[1, 2]) * abs(z) / focal + y
    within = np.abs(place_x) < 30
    profile = board.radiance[np.abs(place_y) < 4.5][:, within].mean(axis=0)
    place_x = place_x[within]
    pitch, lens = badge.gratings[0].pitch_mm, badge.lens
    best = (-1.0, 0.0)
    for beat in np.linspace(0.5, 1.5, 201) * (1 / pitch - 1 / lens.pitch_mm):
        turn = 2 * math.pi * beat * place_x
        basis = np.column_stack([np.cos(turn), np.sin(turn), np.ones_like(turn)])
        weights, *_ = np.linalg.lstsq(basis, profile, rcond=None)
        power = 1 - ((basis @ weights - profile) ** 2).mean() / profile.var()
        if power > best[0]:
            best = (power, math.atan2(-weights[1], weights[0]))
    return best[1]


# The truth is what the picture shows.


@pytest.mark.parametrize("kind", [None, "gain_low", "reversed", "wobble", "generative", "photo", "screen", "frozen"])
def test_the_truth_s_phase_moves_as_the_picture_s(prototype, kind):
    """Catches: the true phase next to a forged film; a forged phase that forgets that the sheet lies above the page
    (3.7 % of the true motion); a picture whose fringes do not move as its truth says; a sign.
    """
    frames, measured, output = (0, 9, 20, 31, 42, 55), [], []
    boards, shown = seen(prototype, kind, *frames)
    for frame, board in zip(frames, boards, strict=True):
        measured.append(fringe_phase(prototype, board, frontal_swing(np.array([frame / FPS]))))
        field = shown.field(frame)
        centre = np.zeros(2) if field is None else field[field.shape[0] // 2, field.shape[1] // 2]
        output.append(
            shown_phase_rad(
                Scene(prototype), prototype.gratings[0], shown.camera_mm[frame], shown.sight_mm[frame], centre
            )
        )
    off = np.array([math.remainder(m - t, 2 * math.pi) for m, t in zip(measured, output, strict=True)])
    off = np.array([math.remainder(value - off[0], 2 * math.pi) for value in off])
    assert np.abs(off).max() < 0.05, off
    if kind in (None, "gain_low", "reversed"):
        assert np.ptp(output) > 0.4


# Parts with clocks of their own.


def test_each_patch_shows_the_true_motion_at_another_time():
    """Catches: random courses; one clock for all; patches that drift together; a field in millimetres."""
    clocks = OwnClocks(frontal_swing, seed=4)
    times = np.arange(0, 3, 0.1)
    fields = np.stack([clocks.at(float(t)) for t in times])
    assert fields.shape == (len(times), *PATCHES, 2)
    true = parallax(frontal_swing(times).camera_mm)
    late = []
    for i in range(PATCHES[0]):
        for j in range(PATCHES[1]):
            shown = true + fields[:, i, j]
            misfit = [
                np.abs(parallax(frontal_swing(times + lag).camera_mm) - shown).max()
                for lag in np.arange(-CLOCK_S, CLOCK_S, 0.002)
            ]
            assert min(misfit) < 1e-3
            late.append(-CLOCK_S + 0.002 * int(np.argmin(misfit)))
    assert np.std(late) > 0.4 and np.abs(late).max() <= CLOCK_S


def test_a_patch_of_the_board_shows_its_own_course(prototype):
    """Catches: a field that is mirrored, transposed or shifted on the board; one that is ignored."""
    scene, pose = Scene(prototype, Build(), NEAR), frontal_swing(np.zeros(1))
    renderer = AnalyticRenderer(scene)
    field = np.zeros((4, 4, 2))
    field[1, 2] = [0.06, 0.0]
    plain = renderer.render(Instant(pose, pose, pose.camera_mm[0]))
    patched = renderer.render(Instant(pose, pose, pose.camera_mm[0], field))
    elsewhere = renderer.render(Instant(pose, pose, pose.camera_mm[0] + [0.06 * 900, 0.0, 0.0]))
    assert plain is not None and patched is not None and elsewhere is not None
    # 146 mm of board at 1450/900 px to the millimetre, centred in the picture.
    per_mm = NEAR.focal_px / 900
    x = (np.arange(plain.radiance.shape[1]) + plain.left - NEAR.matrix[0, 2]) / per_mm / 146 * 4 + 2
    y = (np.arange(plain.radiance.shape[0]) + plain.top - NEAR.matrix[1, 2]) / per_mm / 146 * 4 + 2
    inside = np.outer((y > 1.05) & (y < 1.95), (x > 2.05) & (x < 2.95))
    outside = ~np.outer((y > 0.95) & (y < 2.05), (x > 1.95) & (x < 3.05))
    assert np.array_equal(patched.radiance[outside], plain.radiance[outside])
    assert np.abs(patched.radiance[inside] - plain.radiance[inside]).max() > 0.2
    # In float32 one ray of sixteen may fall on the other side of a line's edge.
    off = np.abs(patched.radiance[inside] - elsewhere.radiance[inside])
    assert off.max() < 0.06 and np.mean(off > 0.01) < 0.02


# Flat pictures.


def test_a_photograph_looks_true_from_where_it_was_taken(prototype):
    """Catches: a photograph shifted, mirrored or of another size or shape; markers that lie elsewhere.

    What may differ is the photograph's own grain of 1/8 mm: steep edges move by half of it.
    """
    built = Build(print_scale=1.004, print_aspect=0.99)
    scene, place = Scene(prototype, built, NEAR), np.array([0.0, 0.0, -900.0])
    pose = Poses(place[None], np.eye(3)[None])
    renderer = AnalyticRenderer(scene)
    true = renderer.render(Instant(pose, pose, place))
    flat = renderer.render(Instant(pose, pose, place, None, SquaredUp(scene, PHOTO_PX_PER_MM).picture(place)))
    assert true is not None and flat is not None
    assert np.array_equal(true.coverage, flat.coverage)
    off = flat.radiance - true.radiance
    assert np.sqrt((off**2).mean()) < 0.02 and abs(off.mean()) < 0.002


def test_a_picture_from_the_side_is_squared_up(prototype):
    """Catches: a viewpoint's shift with the wrong sign.  The page stays, the fringes move."""
    scene = Scene(prototype, Build(), NEAR)
    square = SquaredUp(scene, 4.0)
    front, side = (square.picture(np.array([x, 0.0, -900.0])) for x in (0.0, 80.0))
    pose = Poses(np.array([[80.0, 0.0, -900.0]]), np.eye(3)[None])
    true = AnalyticRenderer(Scene(prototype, Build(), NEAR)).render(Instant(pose, pose, pose.camera_mm[0]))
    assert true is not None
    x0, y0, x1, y1 = (round(4 * value) for value in prototype.gratings[0].rect_mm)
    assert np.abs(front[: y0 - 8] - side[: y0 - 8]).max() < 1e-6
    assert np.abs(front[y0:y1, x0:x1] - side[y0:y1, x0:x1]).max() > 0.2


# Every kind.


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_keeps_page_and_markers_true(prototype, kind):
    """Catches: a forgery that moves, blurs or repaints what lies outside the sheet."""
    ((true,), _), ((forged,), _) = seen(prototype, None, 30), seen(prototype, kind, 30)
    assert np.array_equal(true.coverage, forged.coverage)
    per_mm, y = NEAR.focal_px / 900, frontal_swing(np.ones(1)).camera_mm[0, 1]
    top = (np.arange(true.radiance.shape[0]) + true.top - NEAR.matrix[1, 2]) / per_mm + y + 73
    above = top < prototype.gratings[0].rect_mm[1] - 2
    off = forged.radiance[above] - true.radiance[above]
    # A flat picture has a grain; the others show the page itself.
    limit = 0.1 if kind in ("photo", "screen") else 0.0
    assert np.sqrt((off**2).mean()) <= limit
    assert np.abs(forged.radiance[~above] - true.radiance[~above]).max() > 0.1
