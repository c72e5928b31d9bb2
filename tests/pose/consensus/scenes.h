// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Random problems with outliers, and how good an answer to one is.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>

#include "pose/fit_points.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {

struct DrawLaw {
  int points = 20;
  int outliers = 10;
  bool is_planar = false;
  double sigma_px = 1;
};

/// Points in view of a camera of 640 x 480 pixels, four to eight metres away, solid or in a plane
/// that is tilted at random; pixels with noise; the first `outliers` of them anywhere in the image,
/// 15 px and more from where they belong.
inline Synthetic scene(const DrawLaw& law, Draw& draw) {
  const Camera camera = centred_camera(640, 480, 800);
  Synthetic s;
  s.cam_from_target = {draw.rotation(), Eigen::Vector3d(0, 0, 6)};
  const Eigen::Matrix3d tilt = draw.rotation();
  std::vector<Eigen::Vector3d> points;
  for (int tries = 0; static_cast<int>(points.size()) < law.points; ++tries) {
    // A plane that is seen from the edge fills no image.
    if (tries > 1000 * law.points) return scene(law, draw);
    Eigen::Vector3d x_in_cam = draw.in_box(2);
    if (law.is_planar) x_in_cam = tilt * Eigen::Vector3d(x_in_cam.x(), x_in_cam.y(), 0);
    x_in_cam.z() += 6;
    if (x_in_cam.z() < 1 || !is_inside(camera, project(camera, x_in_cam).value())) continue;
    points.push_back(inverse(s.cam_from_target) * x_in_cam);
  }
  s = exact_problem(camera, points, s.cam_from_target);
  add_noise(s.problem, law.sigma_px, draw);
  for (int i = 0; i < law.outliers; ++i) {
    const Eigen::Vector2d seen = s.problem.pixels[i];
    while ((s.problem.pixels[i] - seen).norm() < 15) {
      s.problem.pixels[i].x() = draw.uniform(0, 639);
      s.problem.pixels[i].y() = draw.uniform(0, 479);
    }
    s.problem.true_inliers[i] = false;
  }
  return s;
}

/// e^T H e, e the pose's error and H what the true inliers say of it: six on average for least
/// squares on them, whose answer beats 60 in one of 1e10 draws.
inline double squared_distance_from_truth(const Pose& pose, const Synthetic& s, double sigma_px) {
  const Correspondences c = prepare(s.problem).correspondences;
  std::vector<int> kept;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (s.problem.true_inliers[i]) kept.push_back(static_cast<int>(i));
  }
  const FitPoints points = {c, kept, {}};
  const Matrix6d covariance =
      unit_covariance(points, to_centred(s.cam_from_target, c)).value() * sigma_px * sigma_px;
  const Vector6d error = change_between(to_centred(s.cam_from_target, c), to_centred(pose, c));
  return error.dot(covariance.ldlt().solve(error));
}

}  // namespace sightline
