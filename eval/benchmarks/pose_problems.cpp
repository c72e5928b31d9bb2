// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/pose_problems.h"

#include <cmath>
#include <numbers>
#include <random>

namespace sightline {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}

  double normal() { return normal_(engine_); }
  double uniform(double low, double high) { return low + (high - low) * uniform_(engine_); }
  Eigen::Vector3d vector() {
    Eigen::Vector3d v;
    for (double& x : v) x = normal();
    return v;
  }
  Eigen::Matrix3d rotation() {
    Eigen::Vector4d q;
    for (double& x : q) x = normal();
    return rotation_from_quaternion_wxyz(q);
  }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

std::vector<Eigen::Vector3d> cube_points(int count, Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) points.emplace_back(x, y, z);
    }
  }
  while (static_cast<int>(points.size()) < count) {
    Eigen::Vector3d p;
    for (double& x : p) x = draw.uniform(-0.5, 0.5);
    points.push_back(p);
  }
  points.resize(count);
  return points;
}

PoseCase draw_case(const ProblemLaw& law, Draw& draw) {
  PoseCase c;
  PoseProblem& problem = c.problem;
  problem.camera = centred_camera(512, 512, 15000);
  problem.points_in_target = cube_points(law.points, draw);
  problem.sigma_px = law.sigma_px;
  problem.true_inliers.assign(law.points, true);
  Pose& pose = c.true_cam_from_target;
  pose.rotation = draw.rotation();
  for (const int i : {0, 1}) pose.translation[i] = draw.uniform(-0.3, 0.3);
  pose.translation.z() = draw.uniform(50, 150);
  for (const Eigen::Vector3d& p : problem.points_in_target) {
    const Eigen::Vector2d noise = law.sigma_px * draw.vector().head<2>();
    problem.pixels.push_back(*project(problem.camera, pose * p) + noise);
  }
  for (int k = 0; k < law.outliers;) {
    const int i = static_cast<int>(draw.uniform(0, law.points));
    if (!problem.true_inliers[i]) continue;
    const double direction = draw.uniform(0, 2 * std::numbers::pi);
    const double size_px = draw.uniform(15, 30);
    problem.pixels[i] += size_px * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    problem.true_inliers[i] = false;
    ++k;
  }
  if (law.has_start) {
    constexpr double kTurnRad = 10 * std::numbers::pi / 180;
    const Eigen::Vector3d axis = draw.vector().normalized();
    problem.initial_cam_from_target = {rotation_from_vector(kTurnRad * axis) * pose.rotation,
                                       1.05 * pose.translation};
  }
  return c;
}

}  // namespace

std::vector<PoseCase> draw_pose_cases(const ProblemLaw& law, std::size_t count) {
  Draw draw(1);
  std::vector<PoseCase> cases;
  while (cases.size() < count) cases.push_back(draw_case(law, draw));
  return cases;
}

}  // namespace sightline
