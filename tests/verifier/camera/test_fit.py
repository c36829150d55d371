"""Poses from synthetic corners: focal length, shutter, signs, smoothing.  Beside each test: what it would catch.

Corners are projected here by the pinhole's own formula, with the noise that registration leaves.
"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kit.made_corners import CENTRE, FPS, MIDDLE, PAGE_MM, SIZE, Course, project, registered, rolled, tangents
from moireid.question import KnownCamera
from moireid.verifier.camera.fit import CameraFit, fit_camera
from moireid.verifier.camera.page_shape import gain_sd_share
from moireid.verifier.camera.page_speed import jumps
from moireid.verifier.camera.smoothing import smooth_camera, without_outliers
from moireid.verifier.limits import MAX_LASTING_PX
from moireid.verifier.measuring import AXIS_PRIOR_SD_SHARE
from moireid.verifier.tracking.patches import marker_corners_mm


def fitted(points: np.ndarray, times: np.ndarray, focal_px: float | None = None) -> CameraFit:
    camera = None if focal_px is None else KnownCamera(focal_px)
    return fit_camera(points, PAGE_MM, times, SIZE, camera=camera)


# Poses.


def test_exact_corners_give_exact_poses(rng):
    """Catches: z into the camera; centres relative to the board; a principal point at (960, 540)."""
    times = np.arange(12) / FPS
    camera, turn = Course(rng, 900.0).pose(times)
    fit = fitted(project(camera, turn, 1450.0), times, focal_px=1450.0)
    assert np.abs(fit.camera_mm - camera).max() < 0.05
    assert fit.focal_given and fit.focal_px == 1450.0 and fit.focal_sd_px == 0.0
    # The remaining error is that of the lens's distortion, which a dozen frames determine poorly.
    assert max(fit.tangent_sd) < 0.05 and abs(fit.bend_k1) < 1e-3
    assert fit.reprojection_px.max() < 1e-2


def test_signs_of_the_camera_s_place():
    """Catches: x or y mirrored; a camera behind the page.  Right of, below and before the page's middle."""
    times = np.arange(9) / FPS
    camera = np.tile([MIDDLE[0] + 200.0, MIDDLE[1] + 90.0, -800.0], (9, 1))
    aim = Rotation.from_euler("yx", [np.arctan2(-200.0, 800.0), -np.arctan2(-90.0, 800.0)]).inv()
    fit = fitted(project(camera, Rotation.concatenate([aim] * 9), 1450.0), times, focal_px=1450.0)
    assert fit.camera_mm == pytest.approx(camera, abs=0.5)


@pytest.mark.parametrize("seed", (0, 4, 7, 8))
def test_a_call_that_freezes_does_not_decide_on_one_picture(seed):
    """Catches: a repeated picture that counts as many, which is fitted without error; all others are outliers then."""
    rng = np.random.default_rng(seed)
    times = np.arange(90) / FPS
    camera, turn = Course(rng, 900.0).pose(times)
    points = registered(project(camera, turn, 1450.0), rng, 0.1)
    # After a second nothing moves but by what registration leaves of one picture.
    points[30:], camera[30:] = points[30] + 1e-4 * rng.standard_normal((60, 16, 2)), camera[30]
    fit = fitted(points, times)
    measured, true = tangents(fit.camera_mm)[:31, 0], tangents(camera)[:31, 0]
    gain = np.polyfit(true - true.mean(), measured, 1)[0]
    assert abs(gain - 1) < 3 * fit.tangent_sd[0] and fit.tangent_sd[0] < 0.3


# Focal length.


@pytest.mark.parametrize("focal_px", [2900.0, 4100.0, 7600.0])
def test_a_badge_moved_flat_shows_no_focal_length_and_excludes_none(rng, focal_px):
    """Catches: a usual lens taken for the one that the film shows; a telephoto lens excluded by what is usual."""
    times = np.arange(120) / FPS
    x, y = 60.0 * np.sin(1.7 * times), 10.0 * np.sin(2.9 * times)
    camera = np.column_stack([MIDDLE[0] + x, MIDDLE[1] + y, np.full(120, -0.55 * focal_px)])
    level = Rotation.from_euler("xyz", np.zeros((120, 3)))
    fit = fitted(registered(project(camera, level, focal_px), rng, 0.05), times)
    least, most = fit.focal_span_px
    assert least < fit.focal_px < focal_px <= most and fit.shown["focal"] < 0.3
    assert fit.lens_room[0] <= fit.focal_px / focal_px and fit.lens_room[1] >= 1


@pytest.mark.claim("A page that is never turned is not taken for one that is seen from aside")
@pytest.mark.parametrize(("seed", "focal_px"), [(0, None), (0, 1450.0), (20, None)])
def test_a_page_that_is_never_turned_shows_neither_axis_nor_lens(seed, focal_px):
    """Catches: an axis 1100 px aside, as far from it poses follow a noise of 0.002 px; a lens that is excluded by where
    the search stopped.  A true film of a frontal circle was rejected for the first.
    """
    rng, times = np.random.default_rng(seed), np.arange(60) / FPS
    angle = 2 * np.pi * times / times[-1]
    camera = np.column_stack([*(MIDDLE + 150 * np.column_stack([np.cos(angle), np.sin(angle)])).T, np.full(60, -900.0)])
    points = registered(project(camera, Rotation.identity(60), 1450.0), rng, 0.002)
    wider = 1e-4 * rng.standard_normal((60, 1, 1)) * [1.0, 0.0]
    fit = fitted(points + (points - points.mean(axis=1, keepdims=True)) * wider, times, focal_px)
    assert np.abs(fit.axis_px).max() < 15.0
    assert fit.parallel == (focal_px is None)
    true = tangents(camera)
    assert tangents(fit.camera_mm) - true == pytest.approx(np.zeros_like(true), abs=0.02)


@pytest.mark.claim("A picture that is cropped off its middle is not taken for one that is not")
def test_a_slight_turn_shows_the_axis_though_not_the_lens():
    """Catches: an axis that is put in the middle of a cropped picture, whose false poses then explain another gain.

    A page that slides, and turns by 0.2 degrees; the axis is 450 px left of the middle.
    """
    rng, times = np.random.default_rng(0), np.arange(90) / FPS
    x, y = 150 * np.sin(1.7 * times), 30 * np.sin(2.1 * times)
    turns = np.radians(0.28) * np.column_stack([np.sin(2.9 * times), np.cos(2.3 * times)])
    camera = np.column_stack([MIDDLE[0] + x, MIDDLE[1] + y, np.full(90, -900.0)])
    points = project(camera, Rotation.from_euler("xy", turns), 1450.0) - [450.0, 0.0]
    fit = fitted(registered(points, rng, 0.01), times)
    assert fit.parallel and fit.axis_px == pytest.approx([-450.0, 0.0], abs=30.0)


def test_a_badge_that_turns_shows_its_focal_length(rng):
    """Catches: any lens that is allowed for a film which shows its own; a span that leaves out the true one."""
    times = np.arange(120) / FPS
    points = registered(project(*Course(rng, 900.0).pose(times), 1450.0), rng, 0.05)
    fit = fitted(points, times)
    least, most = fit.focal_span_px
    assert 0.8 * 1450 < least < 1450 < most < 1.2 * 1450 and fit.shown["focal"] > 0.9
    assert fitted(points, times, focal_px=1450.0).focal_span_px == (1450.0, 1450.0)


@pytest.mark.claim("The focal length has an honest error bar")
@pytest.mark.slow
def test_the_focal_length_is_found_with_an_honest_error_bar():
    """Catches: a bar that is too short by a half; a prior that outweighs the film; a biased minimum."""
    deviations, bars = [], []
    for seed, focal in enumerate([1250.0, 1350.0, 1450.0, 1550.0, 1650.0, 1750.0]):
        rng = np.random.default_rng(seed)
        times = np.arange(90) / FPS
        course = Course(rng, 1600.0, tilt_deg=14.0, sway_mm=220.0)
        fit = fitted(registered(rolled(course, times, focal, 0.010), rng, 0.08), times)
        assert not fit.focal_given
        deviations.append((fit.focal_px - focal) / fit.focal_sd_px)
        bars.append(fit.focal_sd_px / focal)
    assert max(bars) < 0.03
    # Six normal deviates have a root mean square between 0.4 and 1.7 in 99 of 100 cases; the bar is a little wide.
    assert 0.2 < np.sqrt(np.mean(np.square(deviations))) < 1.7


@pytest.mark.parametrize(("focal", "seed"), [(1150.0, 0), (2300.0, 11)])
def test_a_focal_length_far_from_the_prior_is_found_too(focal, seed):
    """Catches: shutter, then focal length, each solved once: a shutter solved at the prior's focal length takes up what
    is that one's fault (14 ms for 10 here), and then holds the focal length off its place.
    """
    rng = np.random.default_rng(seed)
    times = np.arange(90) / FPS
    course = Course(rng, 1600.0, tilt_deg=14.0, sway_mm=220.0)
    fit = fitted(registered(rolled(course, times, focal, 0.010), rng, 0.08), times)
    assert fit.shutter_s == pytest.approx(0.010, abs=0.001)
    assert abs(fit.focal_px - focal) < 2 * fit.focal_sd_px and fit.focal_sd_px < 0.02 * focal


@pytest.mark.slow
@pytest.mark.parametrize("aspect", [0.75, 0.97, 1.03, 4 / 3])
def test_a_stretched_picture_is_judged_as_it_was_taken(aspect):
    """Catches: square pixels taken for granted, which makes half a gain look whole and a whole one a forgery's."""
    rng = np.random.default_rng(3)
    times = np.arange(90) / FPS
    course = Course(rng, 1600.0, tilt_deg=14.0, sway_mm=220.0)
    points = rolled(course, times, 1450.0, 0.010)
    middle = np.array([(size - 1) / 2 for size in SIZE])
    squeezed = registered((points - middle) * [aspect, 1.0] + middle, rng, 0.08)
    fit = fitted(squeezed, times)
    assert fit.aspect == pytest.approx(aspect, rel=4e-3) and not fit.focal_at_limit
    assert abs(fit.focal_px - 1450.0) < 4 * fit.focal_sd_px < 0.1 * 1450.0
    true = course.pose(times)[0]
    assert np.polyfit(tangents(true)[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("aspect", [0.995, 1.01])
def test_a_print_of_another_aspect_is_solved(aspect):
    """Catches: a page taken for as designed, whose gain is 10 % wrong for each thousandth; an aspect upside down; one
    that is lost where the picture is moved by the shutter.
    """
    rng = np.random.default_rng(5)
    times = np.arange(90) / FPS
    course = Course(rng, 1600.0, tilt_deg=5.0, sway_mm=60.0)
    points = rolled(course, times, 1450.0, 0.010, MIDDLE + (PAGE_MM - MIDDLE) * [1.0, aspect])
    fit = fitted(registered(points, rng, 0.05), times)
    assert fit.print_aspect == pytest.approx(aspect, abs=5e-4) and fit.aspect == pytest.approx(1.0, abs=5e-4)
    slope = np.polyfit(tangents(course.pose(times)[0])[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0]
    assert abs(slope - 1) < max(0.02, 3 * fit.tangent_sd[0]) and fit.tangent_sd[0] < 0.04


def lifted(twist_per_m: float, bow_per_m: float = 0.0) -> np.ndarray:
    """The page's corners, (16, 3), with this twist and this bow along x."""
    x, y = (PAGE_MM - MIDDLE).T
    return np.column_stack([PAGE_MM, (twist_per_m * x * y + bow_per_m * x * x / 2) / 1000])


@pytest.mark.parametrize("twist", [-0.5, 0.35])
def test_a_page_that_is_twisted_is_solved(twist, rng):
    """Catches: a twist of the wrong sign or size; poses of a flat page, which err by twenty times the noise; a focal
    length that takes the twist up.
    """
    times = np.arange(150) / FPS
    camera, turn = Course(rng, 1000.0).pose(times)
    fit = fitted(registered(project(camera, turn, 1450.0, lifted(twist)), rng, 0.04), times)
    assert fit.twist_per_m == pytest.approx(twist, abs=0.05)
    assert np.median(fit.reprojection_px) < 0.04 and abs(fit.focal_px - 1450.0) < 0.03 * 1450.0
    assert (tangents(fit.camera_mm) - tangents(camera)).std(axis=0).max() < 0.004


def test_the_gain_of_a_twisted_page_owes_an_error_bar_to_its_bows(ada):
    """Catches: an error bar that is 0, in other units, or that grows with a page that has no beat to move.

    By hand: a bow puts the grating off the markers' plane by half its curvature times the difference of mean squares
    of places; fringes there move by f_b turns per mm more for each unit of parallax, of g / (n p_r).
    """
    grating = ada.gratings[0]
    page = marker_corners_mm(ada.markers).reshape(-1, 2)
    square = (page - page.mean(axis=0)) ** 2
    low, top, high, bottom = grating.rect_mm
    inside = np.array([[high - low, bottom - top]]) ** 2 / 12
    off_mm = 0.5 * (square.mean(axis=0) - inside[0]) / 2000
    beat = 1 / grating.pitch_mm - 1 / ada.lens.pitch_mm
    slope = ada.lens.thickness_mm / ada.lens.refractive_index / grating.pitch_mm
    expected = abs(beat) * np.hypot(*off_mm) / slope
    assert gain_sd_share(ada, grating, page, 0.5) == pytest.approx(expected, rel=0.05) and expected > 0.005
    assert gain_sd_share(ada, grating, page, 0.0) == 0.0


def changed(zoom: np.ndarray, aside_px: np.ndarray, noise_px: float) -> tuple[CameraFit, np.ndarray, np.ndarray]:
    """The fit of five seconds whose picture is zoomed by (T,) and shifted by (T,) px, the times and the true path."""
    rng = np.random.default_rng(8)
    times = np.arange(150) / FPS
    course = Course(rng, 1200.0, tilt_deg=14.0, sway_mm=220.0)
    points = rolled(course, times, 1450.0, 0.010)
    seen = CENTRE + (points - CENTRE) * zoom[:, None, None] + aside_px[:, None, None]
    return fitted(registered(seen, rng, noise_px), times), times, course.pose(times)[0]


SLOWLY = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(150) / 149)
LATER = (np.arange(150) >= 70).astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("share", [SLOWLY, LATER])
def test_the_course_of_a_zoom_is_found_and_taken_away(share):
    """Catches: distances that a zoom makes wrong; a smooth course across a cut; a zoom the wrong way round."""
    zoom = 1.4**share
    fit, _, true = changed(zoom, np.zeros(150), 0.08)
    wrong = fit.log_zoom - np.log(zoom)
    assert wrong.std() < 0.3 * np.log(zoom).std() and fit.lasting_px < MAX_LASTING_PX
    assert np.polyfit(tangents(true)[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0] == pytest.approx(1.0, abs=0.02)
    far = np.abs(fit.camera_mm[:, 2] / true[:, 2])
    assert far.std() / far.mean() < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("aside", [(300.0, 0.0), (-500.0, -250.0), (900.0, 100.0)])
def test_a_crop_s_optical_axis_is_found_wherever_it_is(aside):
    """Catches: an axis in the picture's middle taken for granted; a search that never leaves it."""
    rng = np.random.default_rng(4)
    times = np.arange(90) / FPS
    course = Course(rng, 1600.0, tilt_deg=14.0, sway_mm=220.0)
    fit = fitted(registered(rolled(course, times, 1450.0, 0.010) + np.array(aside), rng, 0.08), times)
    assert np.allclose(fit.axis_px, aside, atol=15.0)
    assert fit.focal_px == pytest.approx(1450.0, rel=0.03)
    true = course.pose(times)[0]
    assert np.polyfit(tangents(true)[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_camera_that_moves_straight_and_does_not_turn_leaves_the_focal_length_to_the_prior(seed):
    """Catches: free tilts that fit the noise better the longer the focal length is, two to three times the true one
    with an error bar of a tenth; seen on true films from 2 m.
    """
    rng = np.random.default_rng(seed)
    times = np.arange(200) / FPS
    along = np.linspace(-150.0, 150.0, len(times))
    camera = np.column_stack([MIDDLE[0] + along, np.full((len(times), 1), MIDDLE[1]), np.full(len(times), -2000.0)])
    seen = registered(project(camera, Rotation.identity(len(times)), 1450.0), rng, 0.15)
    fit = fitted(seen, times)
    assert abs(np.log(fit.focal_px / (0.78 * SIZE[0]))) < 2 * 0.15 and fit.focal_sd_px > 0.08 * fit.focal_px


@pytest.mark.slow
def test_what_the_unknowns_do_to_the_tangents_is_told(rng):
    """Catches: an error bar left at zero; tangents that do not feel the focal length.  Against films of one course.

    The noise of single poses, which smoothing would take away, adds to what the unknowns do.
    """
    times = np.arange(40) / FPS
    camera, turn = Course(rng, 2200.0, tilt_deg=4.0).pose(times)
    clean, true = project(camera, turn, 1450.0), tangents(camera)
    true = true - true.mean(axis=0)
    fits = [fitted(registered(clean, rng, 0.06), times) for _ in range(12)]
    slopes = [(true * tangents(fit.camera_mm)).sum(axis=0) / (true**2).sum(axis=0) for fit in fits]
    poses = np.mean([fit.tangent_error for fit in fits], axis=0) / np.sqrt((true**2).sum(axis=0))
    told = np.hypot(np.mean([fit.tangent_sd for fit in fits], axis=0), poses)
    wrong = np.sqrt(np.mean((np.array(slopes) - 1) ** 2, axis=0))
    assert np.all(wrong > 0.5 * told) and np.all(wrong < 2 * told)


# The rolling shutter.


@pytest.mark.parametrize("shutter_s", [0.0, 0.008, 0.019])
def test_the_shutter_s_time_is_found(rng, shutter_s):
    """Catches: a shutter that runs upwards; rows counted over the board; half the time."""
    times = np.arange(90) / FPS
    course = Course(rng, 900.0, sway_mm=220.0)
    points = registered(rolled(course, times, 1450.0, shutter_s), rng, 0.05)
    fit = fitted(points, times, focal_px=1450.0)
    assert fit.shutter_s == pytest.approx(shutter_s, abs=0.0012)


def test_a_hand_s_tremor_does_not_lengthen_the_shutter(rng):
    """Catches: a velocity from the chord over two neighbours, which sees a tremor of 7 Hz a third too slow at 30 fps:
    the shutter comes out at 0.023 s, the poses shake, and far away the focal length drifts by ten percent.
    """
    times = np.arange(90) / FPS
    course = Course(rng, 900.0)
    steady = course.pose

    def shaking(at: np.ndarray) -> tuple[np.ndarray, Rotation]:
        camera, turn = steady(at)
        shake = np.column_stack([np.sin(2 * np.pi * 6.7 * at), np.cos(2 * np.pi * 7.9 * at), 0 * at])
        return camera, Rotation.from_rotvec(np.radians(0.7) * shake) * turn

    course.pose = shaking
    fit = fitted(registered(rolled(course, times, 1450.0, 0.016), rng, 0.05), times, focal_px=1450.0)
    assert fit.shutter_s == pytest.approx(0.016, abs=0.002)


@pytest.mark.slow
def test_the_error_of_a_pose_is_told_from_what_it_leaves(rng):
    """Catches: an error bar a pixel's, a radian's or a root of two off; along x and y exchanged."""
    times = np.arange(240) / FPS
    for distance in (900.0, 2000.0):
        actual, expected = np.zeros(2), np.zeros(2)
        for _ in range(4):
            camera, turn = Course(rng, distance).pose(times)
            fit = fitted(registered(project(camera, turn, 1450.0), rng, 0.15), times, focal_px=1450.0)
            actual += np.std(tangents(fit.camera_mm) - tangents(camera), axis=0)
            expected += fit.tangent_error
        assert actual == pytest.approx(expected, rel=0.4), distance


# Smoothing.

#: What the smoothing tests say of the poses' errors.
KNOWN = (0.003, 0.003)


def swaying(rng: np.random.Generator, noise: float, count: int = 120) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, true and noisy centres of a sway of 1 Hz and 0.06 in the tangent, while walking nearer."""
    times = np.arange(count) / FPS
    distance = 1500.0 - 60.0 * times
    tangent = 0.06 * np.sin(2 * np.pi * times + 0.4)
    true = np.column_stack([tangent * distance, 0.5 * tangent * distance, -distance])
    shaken = tangent[:, None] * [1.0, 0.5] + noise * rng.standard_normal((count, 2))
    return times, true, np.column_stack([shaken * distance[:, None], -distance])


def test_smoothing_keeps_a_sway_of_one_hertz(rng):
    """Catches: a fixed window that eats a hand's motion, and with it the gain."""
    times, true, noisy = swaying(rng, 0.003)
    smooth = smooth_camera(noisy, times, KNOWN)
    wave = np.sin(2 * np.pi * times + 0.4)
    for axis, size in ((0, 0.06), (1, 0.03)):
        kept = 2 * np.mean((smooth[:, axis] / -smooth[:, 2]) * wave)
        assert kept == pytest.approx(size, rel=0.03)
    assert smooth[:, 2] == pytest.approx(true[:, 2], rel=2e-3)


def test_smoothing_takes_the_noise_out(rng):
    """Catches: smoothing that is left out, or that smooths millimetres of a changing distance."""
    times, true, noisy = swaying(rng, 0.006)
    before = np.std((noisy[:, :2] - true[:, :2]) / true[:, 2:])
    after = np.std((smooth_camera(noisy, times, KNOWN)[:, :2] - true[:, :2]) / true[:, 2:])
    assert after < 0.6 * before


@pytest.mark.parametrize("how", ["repeated", "a millisecond later", "all at once", "backwards"])
def test_times_that_do_not_rise_evenly_do_no_harm(rng, how):
    """Catches: a spline through two frames of one time, whose velocity has no end; a film that stops the program."""
    times = np.arange(90) / FPS
    camera, turn = Course(rng, 900.0).pose(times)
    told = times.copy()
    if how == "all at once":
        told[:] = 0.0
    elif how == "backwards":
        told = told[::-1].copy()
    else:
        told[45] = told[44] + (1e-3 if "later" in how else 0.0)
    fit = fitted(registered(project(camera, turn, 1450.0), rng, 0.05), told, focal_px=1450.0)
    assert np.all(np.isfinite(fit.camera_mm))
    if how in ("repeated", "a millisecond later"):
        assert np.std((tangents(fit.camera_mm) - tangents(camera))[:, 0]) < 0.01


# Distortion.


def bent(points: np.ndarray, k1: float, focal: float) -> np.ndarray:
    """Pictures through a lens that distorts, by OpenCV's own formula."""
    place = (points - CENTRE) / focal
    return CENTRE + focal * place * (1 + k1 * (place**2).sum(axis=-1, keepdims=True))


@pytest.mark.parametrize(("k1", "given"), [(-0.12, None), (0.08, None), (0.0, None), (-0.12, 1450.0)])
def test_a_lens_that_distorts_is_told_and_made_up_for(k1, given, rng):
    """Catches: distortion left out (gain 9 % off at 0.1), its sign, points bent back that a homography never bent."""
    times = np.arange(180) / FPS
    camera, turn = Course(rng, 1000.0).pose(times)
    # The badge wanders through the picture, where distortion differs; aimed cameras alone keep it in the middle.
    turn = Rotation.from_euler("yx", np.column_stack([0.12 * np.sin(times), 0.06 * np.cos(1.3 * times)])) * turn
    fit = fitted(registered(bent(project(camera, turn, 1450.0), k1, 1450.0), rng, 0.03), times, given)
    assert fit.bend_k1 == pytest.approx(k1, abs=4 * fit.bend_sd) and fit.bend_sd < 0.02
    true, found = tangents(camera)[:, 0], tangents(fit.camera_mm)[:, 0]
    gain = np.polyfit(true, found, 1)[0]
    assert gain == pytest.approx(1.0, abs=0.015)


#: Focal length over the long side, and OpenCV's k1, k2, p1, p2, k3: a phone's wide lens and its main one, and two
#: webcams of caliscope's test sessions.
LENSES = {
    "wide": (0.365, (-0.02, -0.01, 0.0, 0.0, 0.0)),
    "phone": (0.74, (0.13, -0.35, 0.0, 0.0, 0.0)),
    "barrel": (0.706, (-0.332, 0.046, -0.0043, 0.0041, 0.0666)),
    "webcam": (0.594, (0.0986, -0.2197, 0.0004, -0.0026, 0.0807)),
}


@pytest.mark.slow
@pytest.mark.parametrize(("lens", "seed"), list(zip(LENSES, (1, 2, 1, 2), strict=True)))
def test_real_lenses_leave_the_gain_as_it_is(lens, seed):
    """Catches: a second term of the distortion left out (gain 1.11 instead of 1), a focal length or a distortion that
    is beyond the search's bounds, a search that stops on its way.
    """
    share, distortion = LENSES[lens]
    rng, focal = np.random.default_rng(seed), share * SIZE[0]
    times = np.arange(180) / FPS
    camera, turn = Course(rng, 1300.0 * share).pose(times)
    turn = Rotation.from_euler("yx", np.column_stack([0.2 * np.sin(times), 0.1 * np.cos(1.3 * times)])) * turn
    flat = (project(camera, turn, focal) - CENTRE) / focal
    solid = np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1).reshape(-1, 1, 3)
    matrix = np.array([[focal, 0, CENTRE[0]], [0, focal, CENTRE[1]], [0, 0, 1]])
    seen, _ = cv2.projectPoints(solid, np.zeros(3), np.zeros(3), matrix, np.array(distortion))
    fit = fitted(registered(seen.reshape(flat.shape), rng, 0.03), times)
    assert not fit.focal_at_limit
    true, found = tangents(camera)[:, 0], tangents(fit.camera_mm)[:, 0]
    assert abs(np.polyfit(true, found, 1)[0] - 1) < max(3 * fit.tangent_sd[0], 0.01) < 0.1


@pytest.mark.claim("A webcam's barrel, k1 of -0.4, does not make the gain wrong")
@pytest.mark.parametrize("k1", [-0.34, -0.4])
def test_a_barrel_is_found_where_the_badge_is_near_the_border(k1):
    """Catches: a far minimum without distortion, whose gain is wrong by ten error bars; a distortion that is taken off
    by a step along the homographies' tangent space, or weighed by the markers' corners alone.
    """
    rng, times, focal = np.random.default_rng(3), np.arange(120) / FPS, 0.66 * SIZE[0]
    camera, turn = Course(rng, 700.0).pose(times)
    aside = Rotation.from_euler("yx", [0.28, -0.1])
    # All that registration sees of a marker: points all over it.
    grid = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 5)]), axis=-1).reshape(-1, 2)
    low, high = (side(PAGE_MM.reshape(4, 4, 2), axis=1) for side in (np.min, np.max))
    places = (low[:, None] + grid * (high - low)[:, None]).reshape(-1, 2)
    seen = bent(project(camera, aside * turn, focal, places), k1, focal)
    seen += 0.08 * rng.standard_normal(seen.shape)
    points = np.array(
        [cv2.perspectiveTransform(PAGE_MM[:, None], cv2.findHomography(places, f)[0])[:, 0] for f in seen]
    )
    fit = fitted(points, times)
    gain = np.polyfit(tangents(camera)[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0]
    assert abs(gain - 1) < 3 * fit.tangent_sd[0] < 0.03
    assert fit.bend_k1 == pytest.approx(k1, abs=0.03) and fit.focal_px == pytest.approx(focal, rel=0.02)


@pytest.mark.slow
def test_the_error_bar_of_the_parallax_s_spread_is_neither_luck_nor_fear():
    """Catches: errors of focal length, distortion and axis added as if apart, where they make up for one another; one
    of them forgotten; a search that stops in a valley.
    """
    apart, told = [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        times = np.arange(120) / FPS
        camera, _ = Course(rng, 1600.0, sway_mm=200.0).pose(times)
        # A camera that shifts without turning: the badge crosses the picture, and only perspective shows a shift.
        level = Rotation.from_euler("yx", 0.02 * rng.standard_normal((1, 2))).as_matrix()
        turn = Rotation.from_matrix(np.repeat(level, len(times), axis=0))
        k1, aside = float(rng.normal(0, 0.01)), rng.normal(0, AXIS_PRIOR_SD_SHARE * max(SIZE), 2)
        fit = fitted(registered(bent(project(camera, turn, 1450.0), k1, 1450.0) + aside, rng, 0.05), times)
        gain = np.polyfit(tangents(camera)[:, 0], tangents(fit.camera_mm)[:, 0], 1)[0]
        apart.append(gain - 1)
        told.append(fit.tangent_sd[0])
    in_sd = np.array(apart) / np.array(told)
    assert 0.3 < np.sqrt(np.mean(in_sd**2)) < 2.0 and np.abs(in_sd).max() < 4


def test_a_misregistered_frame_drags_no_other_along():
    """Catches: one frame whose page was found a module off, by which a true film was rejected."""
    times = np.arange(60) / FPS
    course = np.column_stack([200 * np.sin(3 * times), 30 * np.cos(times), np.full(60, -1000.0)])
    errors = np.full(60, 0.04)
    spoilt = course.copy()
    spoilt[30], errors[30] = (-350.0, 0.0, -1000.0), 1.9
    mended, good = without_outliers(spoilt, errors, times)
    assert list(np.flatnonzero(~good)) == [30]
    assert mended == pytest.approx(course, abs=1.5)
    assert np.array_equal(without_outliers(course, np.full(60, 0.3), times)[0], course)


@pytest.mark.parametrize(("frames", "mended"), [([30], True), ([30, 31], True), ([*range(25, 40)], False)])
def test_a_doubted_frame_takes_its_neighbours_pose_and_keeps_its_fringes(frames, mended):
    """Catches: a pose that is wrong by a tenth and is believed, which made a true film of 15 frames a second a forgery;
    fringes left out where somebody moved the markers a little; half a second of course made up.
    """
    times = np.arange(60) / FPS
    course = np.column_stack([100.0 * times, np.zeros(60), np.full(60, -1000.0)])
    spoilt, errors = course.copy(), np.full(60, 0.02)
    spoilt[frames, 0] += 100.0
    errors[frames] = 0.2
    found, good = without_outliers(spoilt, errors, times)
    assert good.all()
    assert found[frames] == pytest.approx((course if mended else spoilt)[frames], abs=1e-6)


def test_a_doubted_frame_that_is_far_from_its_neighbours_is_left_out():
    """Catches: one bad registration of a film of 6 frames a second, taken for fringes that meanwhile stay still; frames
    that err together left out, as somebody might wish.
    """
    errors = np.full(60, 0.02)
    errors[[20, 40, 41]] = 0.2
    course = np.column_stack([np.linspace(-200, 200, 60), np.zeros(60), np.full(60, -1000.0)])
    assert list(np.flatnonzero(~without_outliers(course, errors, np.arange(60) / 6)[1])) == [20]
    assert without_outliers(course, errors, np.arange(60) / FPS)[1].all()


EVEN = np.arange(80) / FPS
#: The first fifty frames and then every second one.
THINNED = np.concatenate([np.arange(50), 49 + 2 * np.arange(1, 31)]) / FPS


def across_a_cut(kind: str, times: np.ndarray) -> np.ndarray:
    """Points in focal lengths of 80 frames; from frame 40 on another take, frame 40 exposed in both where so asked."""
    sway = 0.1 * np.sin(2 * np.pi * 0.6 * times)
    points = np.stack([sway, 0.5 * sway], axis=1)[:, None] + np.array([[0.0, 0.0], [0.05, 0.02]])
    points += 2e-5 * np.random.default_rng(5).standard_normal(points.shape)
    if kind != "none":
        points[40:] += [0.02, -0.01]
    if kind == "blended":
        points[40] -= [0.009, -0.005]
    return points


@pytest.mark.parametrize("times", [EVEN, THINNED], ids=["even", "thinned"])
@pytest.mark.parametrize(("kind", "before"), [("none", []), ("clean", [40]), ("blended", [40, 41])])
def test_cuts_are_found_in_the_picture(kind, before, times):
    """Catches: a cut found a frame early or late; a frame exposed across it joined to either take; a sway cut up; a cut
    seen where a film's frames go on at half their rate.
    """
    assert np.flatnonzero(jumps(across_a_cut(kind, times), times)).tolist() == before


@pytest.mark.parametrize("fps", [12.0, 24.0, 30.0])
def test_a_quick_hand_is_no_cut_however_few_pictures_there_are(fps):
    """Catches: moves that a prompt asks for (20 cm in 0.9 s, at 0.7 m), cut up where they begin and end because a call
    shows twelve pictures a second, some of them late; a jump of as many pixels that is then missed."""
    rng = np.random.default_rng(3)
    times = np.arange(0.0, 8.0, 1 / fps)
    taken = times + rng.uniform(0.0, 0.1 / fps, len(times))
    way = np.clip((taken[:, None] - [2.0, 5.0]) / 0.9, 0, 1)
    sway = (way**3 * (10 - 15 * way + 6 * way**2)) @ [0.3, -0.3]
    points = np.stack([sway, np.zeros_like(sway)], axis=1)[:, None] + np.array([[0.0, 0.0], [0.05, 0.02]])
    points += 3e-5 * rng.standard_normal(points.shape)
    assert not jumps(points, times).any()
    place = round(1.0 * fps)
    points[place:] += [1.5 * 40.0 / fps**3, 0.0]
    assert np.flatnonzero(jumps(points, times)).tolist() == [place]
