# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
import itertools
import math

import numpy as np
import pytest

import sightline as sl

CUBE = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
CAMERA = sl.Camera(640, 480, 800)
EXACT = 1e-6  # metres and parts of a rotation: far above rounding, far below a pixel's worth


def rotation_about_z_and_x(a, b):
    turn_z = [[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]]
    turn_x = [[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]]
    return np.array(turn_z) @ np.array(turn_x)


TRUTH = np.eye(4)
TRUTH[:3, :3] = rotation_about_z_and_x(0.4, 0.7)
TRUTH[:3, 3] = [0.1, -0.2, 5]


def seen(camera=CAMERA):
    return camera.project(CUBE @ TRUTH[:3, :3].T + TRUTH[:3, 3])


def test_the_list_of_solvers_is_the_programs(program):
    printed = program("list", "solvers").stdout
    assert len(sl.solvers()) > 5
    for name, text in sl.solvers().items():
        assert f" {name} " in printed and text in printed
    assert set(sl.methods()) > {"fast", "arun"}
    assert "model_edges" in sl.extractors()


@pytest.mark.parametrize("solver", [name for name in sl.solvers() if name != "oracle"])
def test_exact_pixels_give_the_exact_pose(solver):
    estimate = sl.solve(CUBE, seen(), CAMERA, solver)
    assert estimate.is_ok and estimate.status == "ok"
    assert np.abs(estimate.cam_from_target - TRUTH).max() < EXACT
    assert np.array_equal(estimate.rotation, estimate.cam_from_target[:3, :3])
    assert np.array_equal(estimate.translation, estimate.cam_from_target[:3, 3])


def cube_edges():
    """Of each edge its two points, two pixels of its line and a sigma of a tenth of a pixel."""
    ends = [(i, j) for i, j in itertools.combinations(range(8), 2)
            if np.count_nonzero(CUBE[i] - CUBE[j]) == 1]
    pixels = seen()
    return np.array([[*CUBE[i], *CUBE[j], *(0.8 * pixels[i] + 0.2 * pixels[j]),
                      *(0.3 * pixels[i] + 0.7 * pixels[j]), 0.1] for i, j in ends])


@pytest.mark.parametrize("solver", ["consensus", "lspe"])
def test_edges_seen_as_lines_give_the_pose_without_a_point(solver):
    nothing = np.empty((0, 3)), np.empty((0, 2))
    start = TRUTH.copy()
    start[:3, 3] += [0.1, -0.05, 0.2]
    estimate = sl.solve(*nothing, CAMERA, solver, lines=cube_edges(), initial=start)
    assert estimate.is_ok
    assert np.abs(estimate.cam_from_target - TRUTH).max() < EXACT


def test_a_wrong_line_is_removed_and_a_useless_one_ignored():
    lines = cube_edges()
    lines[4, 6:10] += [7, 9, 7, 9]
    lines[7, :3] = lines[7, 3:6]
    estimate = sl.solve(CUBE, seen(), CAMERA, "consensus", sigma=0.1, lines=lines)
    assert estimate.removed_lines == (4,) and estimate.ignored_lines == (7,)
    assert np.abs(estimate.cam_from_target - TRUTH).max() < EXACT
    with pytest.raises(sl.InputError, match="uses no lines"):
        sl.solve(CUBE, seen(), CAMERA, "orpe", lines=lines)


def test_an_outlier_is_removed_and_said_so():
    pixels = seen()
    pixels[3] += [25, -14]
    clean = sl.solve(CUBE, pixels, CAMERA, "orpe")
    assert clean.removed == (3,)
    assert np.abs(clean.cam_from_target - TRUTH).max() < EXACT
    spoilt = sl.solve(CUBE, pixels, CAMERA, "lspe")
    assert spoilt.removed == ()
    assert np.abs(spoilt.cam_from_target - TRUTH).max() > 100 * EXACT
    assert sl.solve(CUBE, pixels, CAMERA, "orpe_weighed").removed == (3,)
    kept = sl.solve(CUBE, pixels, CAMERA, "orpe_weighed", options={"max_removed": 0})
    assert kept.removed == ()
    told = sl.solve(CUBE, pixels, CAMERA, "oracle", true_inliers=np.arange(8) != 3)
    assert np.abs(told.cam_from_target - TRUTH).max() < EXACT


def test_covariances_are_of_the_noise_that_is_told():
    pixels = seen() + np.random.default_rng(1).normal(0, 0.3, (8, 2))
    unknown = sl.solve(CUBE, pixels, CAMERA, "lspe")
    assert unknown.covariance is None and unknown.unit_covariance.shape == (6, 6)
    known = sl.solve(CUBE, pixels, CAMERA, "lspe", sigma=0.3)
    assert np.allclose(known.covariance, 0.09 * unknown.unit_covariance, rtol=1e-9)
    weighed = sl.solve(CUBE, pixels, CAMERA, "orpe_weighed", covariance=0.09 * np.eye(2))
    each = np.tile(0.09 * np.eye(2), (8, 1, 1))
    again = sl.solve(CUBE, pixels, CAMERA, "orpe_weighed", covariance=each)
    assert np.array_equal(weighed.cam_from_target, again.cam_from_target)
    assert weighed.diagnosis.is_ambiguous is False
    assert 0 <= weighed.diagnosis.removed_probability <= 1
    assert unknown.diagnosis.removed_probability is None


@pytest.mark.parametrize("solver", [name for name in sl.solvers() if name != "oracle"])
def test_points_that_cannot_be_used_are_left_out(solver):
    pixels, covariances = seen(), np.tile(np.eye(2), (8, 1, 1))
    pixels[2] = np.nan
    covariances[5] = 0
    estimate = sl.solve(CUBE, pixels, CAMERA, solver, covariance=covariances)
    assert estimate.is_ok and estimate.ignored == (2, 5) and estimate.removed == ()
    assert np.abs(estimate.cam_from_target - TRUTH).max() < EXACT
    assert estimate.residual_rms < 1e-6
    none = sl.solve(CUBE, np.full((8, 2), np.nan), CAMERA, solver)
    assert none.status == "degenerate" and none.ignored == tuple(range(8))
    assert sl.solve(CUBE, seen(), CAMERA, solver).ignored == ()


def test_an_initial_pose_may_be_rounded():
    rounded = np.round(TRUTH, 4)
    assert np.abs(sl.solve(CUBE, seen(), CAMERA, "lspe", initial=rounded).cam_from_target
                  - TRUTH).max() < EXACT


def test_all_poses_of_three_points_and_of_a_plane():
    three = sl.solve_all(CUBE[:3], seen()[:3], CAMERA)
    assert 1 < len(three) <= 4
    assert min(np.abs(pose.cam_from_target - TRUTH).max() for pose in three) < EXACT
    assert max(pose.cost for pose in three) < 1e-12
    solid = sl.solve_all(CUBE, seen(), CAMERA, sigma=1.0)
    assert np.abs(solid[0].cam_from_target - TRUTH).max() < EXACT
    assert all(a.cost <= b.cost for a, b in zip(solid, solid[1:]))
    plane = CUBE * [1, 1, 0]
    pixels = CAMERA.project(plane @ TRUTH[:3, :3].T + TRUTH[:3, 3])
    assert len(sl.solve_all(plane[::2], pixels[::2], CAMERA)) >= 2
    assert sl.solve_all(CUBE, seen(), CAMERA, left_out=range(6)) == []
    with pytest.raises(sl.InputError, match="left_out: is 8, must be a whole number"):
        sl.solve_all(CUBE, seen(), CAMERA, left_out=[8])


def test_expected_failures_are_statuses():
    few = sl.solve(CUBE[:3], seen()[:3], CAMERA, "lspe")
    assert few.status == "too_few_points" and not few.is_ok
    assert few.cam_from_target is None and few.rotation is None and few.translation is None
    with_start = sl.solve(CUBE[:3], seen()[:3], CAMERA, "lspe", initial=TRUTH)
    assert with_start.is_ok
    line = np.outer(np.arange(6), [1.0, 0, 0])
    assert sl.solve(line, line[:, :2], CAMERA, "lspe").status == "degenerate"


@pytest.mark.parametrize("change, text", [
    (dict(solver="orpee"), "solve: solver 'orpee' is not known (did you mean 'orpe'?)"),
    (dict(options={"rhoo": 3}), "solver.rhoo is not a known key"),
    (dict(options={"rho": 0}), "solver.rho is 0, must be"),
    (dict(options={"start": "free"}), "solver.start is not a known key"),
    (dict(points=CUBE[:, :2]), "solve: points: has shape (8, 2), must be (n, 3)"),
    (dict(pixels=np.zeros((7, 2))), "solve: pixels has 7 rows, points has 8"),
    (dict(points="abc"), "solve: points: is no array of numbers"),
    (dict(camera=None), "solve: camera is of type NoneType, must be a Camera"),
    (dict(sigma=0), "solve: sigma is 0.0, must be positive, or None"),
    (dict(covariance=-np.eye(2)), "solve: covariance: is not symmetric and positive definite"),
    (dict(initial=2 * np.eye(4)), "solve: initial is no rigid transform"),
    (dict(solver="oracle"), "solve: solver 'oracle' needs true_inliers"),
])
def test_what_cannot_be_used_is_refused_by_one_line(change, text):
    given = dict(points=CUBE, pixels=seen(), camera=CAMERA, solver="orpe")
    with pytest.raises(sl.InputError) as refusal:
        sl.solve(**{**given, **change})
    assert text in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert isinstance(refusal.value, ValueError)


def test_pixel_centres_are_at_whole_coordinates():
    # The middle of an image of even size lies between pixels.
    assert (CAMERA.cx_px, CAMERA.cy_px, CAMERA.fy_px) == (319.5, 239.5, 800)
    assert np.array_equal(CAMERA.project([[0, 0, 2]]), [[319.5, 239.5]])
    assert np.isnan(CAMERA.project([[0, 0, -2]])).all()
    x, y, k1 = 0.25, -0.5, 0.1
    bent = sl.Camera(640, 480, 800, distortion=(k1, 0, 0, 0, 0))
    factor = 1 + k1 * (x * x + y * y)
    assert np.allclose(bent.project([[x, y, 1]]), [[319.5 + 800 * x * factor,
                                                   239.5 + 800 * y * factor]])
    assert np.array_equal(CAMERA.matrix, [[800, 0, 319.5], [0, 800, 239.5], [0, 0, 1]])
    assert np.abs(sl.solve(CUBE, seen(bent), bent, "lspe").cam_from_target - TRUTH).max() < EXACT


@pytest.mark.parametrize("camera", [
    sl.Camera(640, 480, 400, distortion=(-0.02, 0.005, -0.003, 0.0004), lens="fisheye"),
    sl.Camera(640, 480, 400, lens="fisheye", skew_px=3),
    sl.Camera(640, 480, 400, 410, distortion=(0.9, 0.25, 1e-3, -5e-4, 0.01, 1.2, 0.5, 0.05),
              lens="rational"),
])
def test_poses_through_every_lens(camera):
    assert np.abs(sl.solve(CUBE, seen(camera), camera, "lspe").cam_from_target - TRUTH).max() < EXACT
    straight = sl.Camera(640, 480, 400)
    wrong = sl.solve(CUBE, seen(camera), straight, "lspe")
    assert not wrong.is_ok or np.abs(wrong.cam_from_target - TRUTH).max() > 1e-3


def test_a_fisheye_shows_angles():
    camera = sl.Camera(640, 480, 400, lens="fisheye")
    assert np.allclose(camera.project([[math.tan(1.2), 0, 1]]), [[319.5 + 400 * 1.2, 239.5]])
    assert camera.distortion == (0, 0, 0, 0)


def test_cameras_are_read_from_calibrations(tmp_path):
    file = tmp_path / "cameras.txt"
    file.write_text("1 PINHOLE 640 480 800 800 320 240\n"
                    "2 OPENCV_FISHEYE 640 480 400 410 320 240 -0.02 0.005 -0.003 0.0004\n")
    camera = sl.Camera.read(f"{file}#2")
    assert (camera.lens, camera.distortion) == ("fisheye", (-0.02, 0.005, -0.003, 0.0004))
    assert (camera.fy_px, camera.cx_px) == (410, 319.5)
    assert sl.Camera.read(f"{file}#1") == sl.Camera(640, 480, 800)
    with pytest.raises(sl.InputError, match="cameras.txt: has the cameras 1, 2: say which"):
        sl.Camera.read(file)


@pytest.mark.parametrize("arguments, text", [
    ((0, 480, 800), "Camera: width_px: is 0, must be a whole number from 1"),
    ((640, 480.5, 800), "Camera: height_px: is 480.5"),
    ((640, 480, -1), "Camera: fx_px is -1.0, must be positive"),
    ((640, 480, math.inf), "Camera: fx_px: holds a number that is not finite"),
    ((640, 480, 800, None, None, None, (1, 2)), "Camera: distortion: has 2 numbers, must have 4 or 5 of a brown_conrady lens"),
    ((640, 480, 800, None, None, None, (), "omni"),
     "Camera: lens is 'omni', must be one of brown_conrady, rational, fisheye"),
])
def test_no_camera_is_none(arguments, text):
    with pytest.raises(sl.InputError) as refusal:
        sl.Camera(*arguments)
    assert text in str(refusal.value)


@pytest.mark.parametrize("method", sl.methods())
def test_every_method_aligns_exact_points(method):
    moved = CUBE @ TRUTH[:3, :3].T + TRUTH[:3, 3]
    alignment = sl.align(CUBE, moved, method)
    assert alignment.is_ok
    assert np.abs(alignment.b_from_a - TRUTH).max() < EXACT
    assert alignment.scale == pytest.approx(1)
    assert np.array_equal(alignment.translation, alignment.b_from_a[:3, 3])


def test_align_weighs_scales_and_refuses():
    moved = CUBE @ TRUTH[:3, :3].T + TRUTH[:3, 3]
    assert sl.align(CUBE, 3 * moved, "umeyama_scaled").scale == pytest.approx(3)
    wrong = moved.copy()
    wrong[5] += 1
    weights = np.ones(8)
    assert np.abs(sl.align(CUBE, wrong, weights=weights).b_from_a - TRUTH).max() > 0.01
    weights[5] = 0
    assert np.abs(sl.align(CUBE, wrong, weights=weights).b_from_a - TRUTH).max() < EXACT
    assert sl.align(CUBE[:2], moved[:2]).status == "too_few_points"
    assert sl.align(np.full((4, 3), np.nan), moved[:4]).status == "not_finite"
    assert sl.align(CUBE[:2], moved[:2]).b_from_a is None
    with pytest.raises(sl.InputError, match="align: method 'fats' is not known"):
        sl.align(CUBE, moved, "fats")
    with pytest.raises(sl.InputError, match=r"align: b: has shape \(7, 3\), must be \(8, 3\)"):
        sl.align(CUBE, moved[:7])
