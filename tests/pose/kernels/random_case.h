// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Problems drawn for the tests of the kernels, and the plain sums that the kernels are held to.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "pose/minimise.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "tests/pose/synthetic.h"

namespace sightline {

/// Correspondences, a pose near theirs, and a weight for each point.
struct Case {
  Correspondences c;
  Pose pose;
  std::vector<Eigen::Matrix2d> weights;
};

/// A drawn case of n points.
inline Case random_case(int n, Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(draw.in_box(1));
  Camera camera = centred_camera(640, 480, 800);
  camera.fy_px = 750;
  Synthetic s = exact_problem(camera, points, {draw.rotation(), {0.3, -0.2, draw.uniform(4, 20)}});
  add_noise(s.problem, 2, draw);
  Case result = {prepare(s.problem).correspondences, {}, {}};
  result.pose = to_centred(s.cam_from_target, result.c);
  result.pose.rotation = draw.rotation_by(0.05) * result.pose.rotation;
  for (int i = 0; i < n; ++i) {
    Eigen::Matrix2d root;
    root << draw.normal(), draw.normal(), draw.normal(), draw.normal();
    result.weights.push_back(root * root.transpose() + 0.1 * Eigen::Matrix2d::Identity());
  }
  return result;
}

/// Cost, gradient and Hessian of the weighed squares, summed point by point.
inline LocalModel plain_model(const Case& k) {
  LocalModel model;
  for (std::size_t i = 0; i < k.c.size(); ++i) {
    const Reprojection r = reproject(k.c, i, k.pose).value();
    model.cost += 0.5 * r.residual_px.dot(k.weights[i] * r.residual_px);
    model.gradient += r.jacobian.transpose() * k.weights[i] * r.residual_px;
    model.hessian += r.jacobian.transpose() * k.weights[i] * r.jacobian;
  }
  return model;
}

}  // namespace sightline
