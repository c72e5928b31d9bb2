#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose pipeline of somebody's own, which knows nothing of Sightline but its files.

It tracks a target through a BOP image set: around where the pose of before expects each feature it
takes OpenCV's nearest corner, refines it, and solves with OpenCV's solvePnPRansac. As the pose of
before serves the true one, off by what a tracker would be off.

    pipeline.py SET TARGET_TOML --keypoints keypoints.csv --poses poses.csv
"""
import argparse
import csv
import json
import pathlib
import tomllib

import cv2
import numpy as np

WINDOW_PX = 14  # half the side of the square in which a corner is looked for
SIGMA_PX = 0.5


def pose_of_before(truth, image):
    """The true pose, turned and moved by an error that depends on the image's number alone."""
    rng = np.random.default_rng(image)
    turn, _ = cv2.Rodrigues(np.radians(1.0) * rng.standard_normal(3))
    rotation = turn @ np.array(truth["cam_R_m2c"]).reshape(3, 3)
    translation = np.array(truth["cam_t_m2c"]) * (1 + 0.005 * rng.standard_normal())
    return cv2.Rodrigues(rotation)[0], translation / 1000


def corner_near(grey, expected, is_refined):
    """The corner nearest to a pixel, or none."""
    left, top = np.floor(expected - WINDOW_PX).astype(int).clip(0)
    right, bottom = np.ceil(expected + WINDOW_PX).astype(int) + 1
    window = grey[top:bottom, left:right]
    if min(window.shape) < WINDOW_PX:
        return None
    corners = cv2.goodFeaturesToTrack(window, 5, 0.05, 3)
    if corners is None:
        return None
    corners = corners.reshape(-1, 2) + (left, top)
    corner = corners[np.argmin(np.linalg.norm(corners - expected, axis=1))]
    if not is_refined:
        return corner
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
    refined = cv2.cornerSubPix(grey, corner.astype(np.float32).reshape(1, 1, 2), (4, 4), (-1, -1),
                               criteria)
    return refined.reshape(2)


def solve(points, pixels, camera, rotation, translation):
    """The pose of those pixels, or none."""
    if len(points) < 4:
        return None
    cv2.setRNGSeed(1)
    is_good, rotation, translation, _ = cv2.solvePnPRansac(
        np.array(points), np.array(pixels, dtype=float), camera, None, rotation.copy(),
        translation.reshape(3, 1).copy(), useExtrinsicGuess=True, reprojectionError=3.0)
    return (cv2.Rodrigues(rotation)[0], translation.ravel()) if is_good else None


def images_of(folder):
    for scene in sorted((folder / "test").iterdir()):
        cameras = json.loads((scene / "scene_camera.json").read_text())
        truths = json.loads((scene / "scene_gt.json").read_text())
        for image in sorted(cameras, key=int):
            grey = cv2.imread(str(scene / "gray" / f"{int(image):06}.png"), cv2.IMREAD_GRAYSCALE)
            camera = np.array(cameras[image]["cam_K"]).reshape(3, 3)
            yield int(scene.name), int(image), grey, camera, truths[image][0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("set", type=pathlib.Path)
    parser.add_argument("target", type=pathlib.Path)
    parser.add_argument("--keypoints", type=pathlib.Path, required=True)
    parser.add_argument("--poses", type=pathlib.Path, required=True)
    parser.add_argument("--unrefined", action="store_true", help="corners to whole pixels")
    arguments = parser.parse_args()
    target = tomllib.loads(arguments.target.read_text())
    features = {f["name"]: np.array(f["position_m"]) for f in target["feature"]}

    with arguments.keypoints.open("w") as keypoints, arguments.poses.open("w") as poses:
        keypoints = csv.writer(keypoints)
        poses = csv.writer(poses)
        keypoints.writerow(["scene_id", "im_id", "feature", "u", "v", "sigma"])
        poses.writerow(["scene_id", "im_id", "obj_id", "score", "R", "t", "time"])
        for scene, image, grey, camera, truth in images_of(arguments.set):
            rotation, translation = pose_of_before(truth, image)
            found = {}
            for name, point in features.items():
                expected, _ = cv2.projectPoints(point, rotation, translation, camera, None)
                corner = corner_near(grey, expected.reshape(2), not arguments.unrefined)
                if corner is not None:
                    found[name] = corner
                    keypoints.writerow([scene, image, name, *corner, SIGMA_PX])
            pose = solve([features[name] for name in found], list(found.values()), camera, rotation,
                         translation)
            if pose is not None:
                matrix = " ".join(str(number) for number in pose[0].ravel())
                millimetres = " ".join(str(1000 * number) for number in pose[1])
                poses.writerow([scene, image, truth["obj_id"], 1, matrix, millimetres, -1])


if __name__ == "__main__":
    main()
