// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Problems with known truth. The paper's cube setting: a 1 m cube, f = 15000 px, 50..150 m away.
#pragma once

#include <random>
#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double normal() { return normal_(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform_(engine_); }
  int index(int count) { return static_cast<int>(uniform(0, count)); }

  Eigen::Vector3d vector() {
    // One statement a number: the order in which arguments are evaluated is not defined.
    Eigen::Vector3d v;
    for (double& x : v) x = normal();
    return v;
  }
  Eigen::Vector3d in_box(double half_width) {
    Eigen::Vector3d v;
    for (double& x : v) x = uniform(-half_width, half_width);
    return v;
  }
  Eigen::Vector2d pixel_noise(double sigma_px) { return sigma_px * vector().head<2>(); }
  Eigen::Matrix3d rotation() {
    Eigen::Vector4d q;
    for (double& x : q) x = normal();
    return rotation_from_quaternion_wxyz(q);
  }
  Eigen::Matrix3d rotation_by(double angle_rad) {
    return rotation_from_vector(angle_rad * vector().normalized());
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

inline std::vector<Eigen::Vector3d> cube_vertices() {
  std::vector<Eigen::Vector3d> vertices;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) vertices.emplace_back(x, y, z);
    }
  }
  return vertices;
}

struct Synthetic {
  PoseProblem problem;
  Pose cam_from_target;  ///< the truth
};

/// Exact pixels of points that must all be in front of the camera.
inline Synthetic exact_problem(const Camera& camera, const std::vector<Eigen::Vector3d>& points,
                               const Pose& cam_from_target) {
  Synthetic s;
  s.cam_from_target = cam_from_target;
  s.problem.camera = camera;
  s.problem.points_in_target = points;
  s.problem.true_inliers.assign(points.size(), true);
  for (const Eigen::Vector3d& x_in_target : points) {
    s.problem.pixels.push_back(project(camera, cam_from_target * x_in_target).value());
  }
  return s;
}

inline void add_noise(PoseProblem& problem, double sigma_px, Draw& draw) {
  for (Eigen::Vector2d& pixel : problem.pixels) pixel += draw.pixel_noise(sigma_px);
}

inline void add_outlier(PoseProblem& problem, int index, double size_px, Draw& draw) {
  const double direction_rad = draw.uniform(0, 6.283185307179586);
  problem.pixels[index] +=
      size_px * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
  problem.true_inliers[index] = false;
}

inline Pose cube_pose(Draw& draw) {
  Pose cam_from_target;
  cam_from_target.rotation = draw.rotation();
  for (int i : {0, 1}) cam_from_target.translation[i] = draw.uniform(-0.3, 0.3);
  cam_from_target.translation.z() = draw.uniform(50, 150);
  return cam_from_target;
}

inline Synthetic cube_problem(double sigma_px, Draw& draw) {
  Synthetic s = exact_problem(centred_camera(512, 512, 15000), cube_vertices(), cube_pose(draw));
  add_noise(s.problem, sigma_px, draw);
  return s;
}

}  // namespace sightline
