// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/modes.h"

#include <algorithm>
#include <utility>

#include <Eigen/Eigenvalues>

#include "pose/pose.h"

namespace sightline::consensus {
namespace {

/// Modes nearer than this turn, or than this squared distance as either sees it, are one.
constexpr double kSameTurnRad = 1e-3;
constexpr double kSameDistance2 = 4;
/// Variance across the plane over that along its shorter axis.
constexpr double kNearlyPlanar = 0.04;

bool are_same(const Mode& a, const Mode& b) {
  if (geodesic_angle_rad(a.cam_from_centred.rotation, b.cam_from_centred.rotation) < kSameTurnRad) {
    return true;
  }
  return std::min(squared_distance(a, b.cam_from_centred),
                  squared_distance(b, a.cam_from_centred)) < kSameDistance2;
}

}  // namespace

double squared_distance(const Mode& mode, const Pose& pose) {
  const Vector6d step = change_between(mode.cam_from_centred, pose);
  return step.dot(mode.information * step) / mode.variance;
}

void ModeList::add(Mode mode) {
  for (Mode& other : modes_) {
    if (!are_same(other, mode)) continue;
    if (mode.log_likelihood > other.log_likelihood) other = std::move(mode);
    return;
  }
  modes_.push_back(std::move(mode));
  std::ranges::stable_sort(
      modes_, [](const Mode& a, const Mode& b) { return a.log_likelihood > b.log_likelihood; });
  if (modes_.size() > kMostModes) modes_.pop_back();
}

std::optional<Pose> mirrored(const Cloud& cloud, const Mode& mode) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 0;
  for (std::size_t i = 0; i < mode.weights.size(); ++i) {
    if (mode.weights[i] == 0) continue;
    sum += mode.weights[i] * cloud.points_in_centred[i];
    weight += mode.weights[i];
  }
  const Eigen::Vector3d mean = sum / weight;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < mode.weights.size(); ++i) {
    if (mode.weights[i] == 0) continue;
    const Eigen::Vector3d d = cloud.points_in_centred[i] - mean;
    scatter += mode.weights[i] * d * d.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(scatter);
  if (!(eigen.eigenvalues()[0] < kNearlyPlanar * eigen.eigenvalues()[1])) return std::nullopt;
  const auto reflection = [](const Eigen::Vector3d& unit) -> Eigen::Matrix3d {
    return Eigen::Matrix3d::Identity() - 2 * unit * unit.transpose();
  };
  const Eigen::Vector3d mean_in_cam = mode.cam_from_centred * mean;
  Pose mirror;
  mirror.rotation = reflection(mean_in_cam.normalized()) * mode.cam_from_centred.rotation *
                    reflection(eigen.eigenvectors().col(0));
  mirror.translation = mean_in_cam - mirror.rotation * mean;
  return mirror;
}

}  // namespace sightline::consensus
