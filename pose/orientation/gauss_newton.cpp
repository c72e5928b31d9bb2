// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Gauss-Newton on SO(3) from the identity for sum w |x_b - R x_a|^2 about the means, R <- R Exp(v):
// with S = sum w x_a x_a^T and N = R^T B the step is v = (tr(S) I - S)^-1 vee(N - N^T). A step that
// would lower tr(R^T B) is halved, so that it never falls.
//
// It converges from anywhere. tr(R^T B) has no local maximum but the global one; its other
// stationary points, such as the one half a turn away, are saddles and the minimum. There
// tr(N) I - sym(N) has a negative eigenvalue -c, and half a turn about its eigenvector leads to a
// stationary point that is higher by 2c. So the iterations end at the maximum, at the latest after
// three such turns, or with kNotConverged (points so noisy that hardly anything of x_b is explained
// converge slowly). Needs points that are not collinear.

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/orientation/methods.h"

namespace sightline {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMaxIterations = 1000;
constexpr int kMaxHalvings = 40;
constexpr double kLargestStep_rad = 1;
/// The squared thickness of the cloud over its squared length below which it is a line.
constexpr double kLeastSpread = 1e-14;

struct Problem {
  Eigen::Matrix3d cross;
  Eigen::Matrix3d step_from_gradient;
  double trace_rounding;
  double step_rounding_rad;
};

Eigen::Vector3d gradient(const Eigen::Matrix3d& n) {
  return {n(2, 1) - n(1, 2), n(0, 2) - n(2, 0), n(1, 0) - n(0, 1)};
}

double trace(const Problem& problem, const Eigen::Matrix3d& rotation) {
  return rotation.cwiseProduct(problem.cross).sum();
}

struct Step {
  Eigen::Matrix3d rotation;
  double size_rad;
};

Step take_step(const Problem& problem, const Eigen::Matrix3d& rotation) {
  Eigen::Vector3d v = problem.step_from_gradient * gradient(rotation.transpose() * problem.cross);
  if (const double size_rad = v.norm(); size_rad > kLargestStep_rad) {
    v *= kLargestStep_rad / size_rad;
  }
  const double least = trace(problem, rotation) - problem.trace_rounding;
  for (int i = 0; i < kMaxHalvings; ++i) {
    const Eigen::Matrix3d next = rotation * rotation_from_vector(v);
    if (trace(problem, next) >= least) return {next, v.norm()};
    v *= 0.5;
  }
  return {rotation, 0};
}

/// tr(N) I - sym(N): the negative of the Hessian.
Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> curvature(const Eigen::Matrix3d& n) {
  const Eigen::Matrix3d k = n.trace() * Eigen::Matrix3d::Identity() - 0.5 * (n + n.transpose());
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(k);
}

}  // namespace

OrientationEstimate orient_by_gauss_newton(const PairMoments& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(moments.spread_a);
  const Eigen::Vector3d& extents2 = spread.eigenvalues();  // ascending
  if (!(extents2[1] > kLeastSpread * extents2[2])) return {OrientationStatus::kDegenerate, {}};
  const Eigen::Vector3d inverse(1 / (extents2[1] + extents2[2]), 1 / (extents2[2] + extents2[0]),
                                1 / (extents2[0] + extents2[1]));
  const double norm = moments.cross.norm();
  if (!(norm > 0)) return {OrientationStatus::kDegenerate, {}};
  // As if both clouds were of one size: the maximum is where it was, and the steps are of the right
  // length.
  const double size = moments.spread_a.norm();
  const Problem problem = {
      moments.cross * (size / norm),
      spread.eigenvectors() * inverse.asDiagonal() * spread.eigenvectors().transpose(),
      16 * kEpsilon * size, 8 * kEpsilon * std::max(1.0, size * inverse.maxCoeff())};

  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  for (int i = 0; i < kMaxIterations; ++i) {
    const Step step = take_step(problem, rotation);
    rotation = step.rotation;
    if (step.size_rad > problem.step_rounding_rad) continue;
    const auto curved = curvature(rotation.transpose() * moments.cross);
    const double least = curved.eigenvalues()[0];
    const double nothing = smallest_gap(moments, norm);
    if (least > nothing) return estimate_about_means(moments, rotation);
    if (least >= -nothing) return {OrientationStatus::kDegenerate, {}};
    rotation = rotation * rotation_from_vector(EIGEN_PI * curved.eigenvectors().col(0));
  }
  return {OrientationStatus::kNotConverged, {}};
}

}  // namespace sightline
