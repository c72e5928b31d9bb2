# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
import gc
import json
import zlib

import numpy as np
import pytest

import sightline as sl

SUBPIXEL = 1e-9  # px, rounding alone


def test_a_target_has_its_features_and_mesh():
    cube = sl.target("cube")
    assert cube.name == "cube" and "cube" in sl.targets()
    assert cube.points.shape == (len(cube.features), 3) == (8, 3)
    assert cube.triangles.max() == len(cube.vertices) - 1
    spread = cube.vertices[:, None] - cube.vertices[None]
    assert cube.diameter_m == pytest.approx(np.linalg.norm(spread, axis=2).max())
    with pytest.raises(sl.InputError, match="target 'cub' is not known .did you mean 'cube'"):
        sl.target("cub")


def test_a_frame_is_the_one_that_the_program_renders(here, program):
    outcome = program("render", "cube", "--count", 3, "--seed", 5, "--out", "set", "--quiet")
    assert outcome.returncode == 0, outcome.stderr
    scene = sl.Scene("cube", seed=5)
    for index in range(3):
        frame = sl.render(scene, index)
        truth = json.loads((here / f"set/sightline/000000/{index:06}.json").read_text())
        pose = truth["bodies"][0]["cam_from_target"]
        assert pose["translation_m"] == frame.cam_from_target[:3, 3].tolist()
        assert pose["rotation"] == frame.cam_from_target[:3, :3].ravel().tolist()
        picture = read_png(here / f"set/test/000000/gray/{index:06}.png")
        assert np.array_equal(picture, frame.image)
    assert not np.array_equal(sl.render("cube", 2, seed=6).image, frame.image)
    assert np.array_equal(sl.render("cube", 2, seed=5).image, frame.image)


def read_png(path):
    """A grey PNG of 8 bits, by its standard."""
    data = path.read_bytes()
    at, packed, width, height = 8, b"", 0, 0
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = (int.from_bytes(body[i:i + 4], "big") for i in (0, 4))
            assert body[8:10] == b"\x08\x00"
        packed += body if kind == b"IDAT" else b""
        at += size + 12
    raw = zlib.decompress(packed)
    above, rows = [0] * (width + 1), []
    for y in range(height):
        kind, *line = raw[y * (width + 1):(y + 1) * (width + 1)]
        row = [0]  # a column before the first, of zeros
        for x, value in enumerate(line):
            row.append((value + guess(kind, row[x], above[x + 1], above[x])) % 256)
        rows.append(row[1:])
        above = row
    return np.array(rows, np.uint8)


def guess(kind, left, up, corner):
    if kind == 4:
        far = [abs(left + up - corner - near) for near in (left, up, corner)]
        return (left, up, corner)[far.index(min(far))]
    return (0, left, up, (left + up) // 2)[kind]


def test_a_frame_agrees_with_its_truth():
    frame = sl.render("cube", 0, seed=2)
    cube = sl.target("cube")
    in_cam = cube.points @ frame.cam_from_target[:3, :3].T + frame.cam_from_target[:3, 3]
    assert frame.features == cube.features
    assert np.abs(frame.camera.project(in_cam) - frame.pixels).max() < SUBPIXEL
    seen = frame.depth_m > 0
    assert np.array_equal(seen, frame.body_ids == 1) and np.array_equal(seen, frame.part_ids > 0)
    distance = frame.cam_from_target[2, 3]
    assert abs(frame.depth_m[seen] - distance).max() <= cube.diameter_m / 2 + 1e-9
    x, y, width, height = frame.bodies[0].box
    rows, columns = np.nonzero(seen)
    assert (x, y) == (columns.min(), rows.min())
    assert (width, height) == (np.ptp(columns) + 1, np.ptp(rows) + 1)
    assert 0 < frame.is_visible.sum() < 8  # a cube hides some of its vertices


def test_images_are_not_copies_and_outlive_their_frame():
    frame = sl.render("cube", 0, seed=2, set={"image.bits": 12})
    assert frame.image.dtype == np.uint16 and frame.bits == 12
    assert (frame.depth_m.dtype, frame.part_ids.dtype) == (np.float64, np.uint16)
    image = frame.image
    assert not image.flags.owndata and not image.flags.writeable
    with pytest.raises(ValueError):
        image[0, 0] = 1
    before = image.copy()
    del frame
    gc.collect()
    sl.render("cube", 1, seed=2)
    assert np.array_equal(image, before) and image.max() > 255


def test_a_scene_in_colour_has_red_green_and_blue():
    settings = {"image.colour": "rgb", "light.colour": [1.0, 0.5, 0.25], "light.ambient": 0.0}
    frame = sl.render("cube", 0, seed=2, set={**settings, "image.psf_sigma_px": 0.0})
    assert frame.colour.shape == (*frame.image.shape, 3) and frame.colour.dtype == frame.image.dtype
    assert not frame.colour.flags.owndata and not frame.colour.flags.writeable
    red, green, blue = (frame.colour[..., c][frame.body_ids == 1].mean() for c in range(3))
    assert red > 1.5 * green > 2 * blue > 0
    weighed = frame.colour @ np.array([0.299, 0.587, 0.114])  # as OpenCV makes grey
    assert np.abs(weighed - frame.image).max() <= 1
    assert sl.render("cube", 0, seed=2).colour is None


def test_a_pose_can_be_given():
    drawn = sl.render("cube", 0, seed=2)
    pose = drawn.cam_from_target.copy()
    pose[2, 3] *= 2
    farther = sl.render("cube", 0, seed=2, cam_from_target=pose)
    assert np.array_equal(farther.cam_from_target, pose)
    assert (farther.body_ids > 0).sum() < 0.5 * (drawn.body_ids > 0).sum()
    pose[:3, 3] = [0, 0, -5]
    with pytest.raises(sl.InputError, match="behind|camera"):
        sl.render("cube", 0, seed=2, cam_from_target=pose)
    with pytest.raises(sl.InputError, match="is no rigid transform"):
        sl.render("cube", 0, cam_from_target=2 * np.eye(4))
    with pytest.raises(sl.InputError, match="index: is -1, must be a whole number from 0"):
        sl.render("cube", -1)
    with pytest.raises(sl.InputError, match="'cubes' is neither a target nor a study"):
        sl.render("cubes")


def test_the_frames_of_a_study_are_those_of_its_run(here):
    study = sl.Study("boeing-random", trials=3, set={"solvers": ["lspe"]})
    observations = study.run("run").observations()
    frames = list(study.frames())
    assert [frame.trial for frame in frames] == [0, 1, 2]
    for frame in frames:
        of_trial = observations["trial"] == frame.trial
        assert observations["feature"][of_trial].tolist() == frame.observations.features
        assert observations["status"][of_trial].tolist() == frame.observations.status
        found = np.array(frame.observations.status) == "found"
        assert found.any()
        assert np.array_equal(observations["pixel_u"][of_trial][found],
                              frame.observations.pixels[found, 0])
        assert not np.array_equal(frame.prior_cam_from_target, frame.cam_from_target)
    assert [frame.trial for frame in study.frames(begin=1, end=2)] == [1]
    with pytest.raises(sl.InputError, match="the study cube-noise has no images"):
        next(sl.Study("cube-noise").frames())
