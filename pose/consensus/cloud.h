// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of a problem as the consensus search sees them: those that can be used, in units in
// which nothing depends on the unit of length, the size of the image, or the camera matrix.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pose/consensus/noise.h"
#include "pose/kernels/consensus_kernel.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline::consensus {

/// Points in a hashed order that depends on neither the order in which they were given nor on the
/// target's frame nor on any unit, so that every prefix is a fair sample of them.
///
/// The target's length unit is the median distance of its points from their middle. The image's
/// unit is the root of the area over which the pixels are spread, so that an outlier that may be
/// anywhere has the density 1: a circle of radius t is met by chance with probability pi t^2.
/// (The spread is taken from the pixels, not from the camera's size, which says nothing where the
/// pixels are normalised coordinates; `image_unit` in cloud.cpp.)
struct Cloud {
  std::vector<Eigen::Vector3d> points_in_centred;
  std::vector<Eigen::Vector2d> image;  ///< without lens, relative to the principal point
  Eigen::Vector2d focal = {1, 1};
  /// Where pixels have covariances: what makes a residual one of unit noise, and the area of the
  /// image in the units of each point's noise. Empty: identities and ones.
  std::vector<Eigen::Matrix2d> whitening;
  std::vector<double> areas;
  double sigma = 0;              ///< of a whitened residual's coordinate; 0: not known
  /// Where it is not known: about what it is, kTypicalNoise of the image's extent. The image is
  /// larger than the pixels' spread where the target fills a part of it: it holds the pixels, and
  /// as much on the other side of the principal point.
  double typical_noise = kTypicalNoise;
  std::vector<int> given_index;  ///< of the points in the problem
  std::vector<int> ignored;      ///< the problem's points that cannot be used, ascending
  std::optional<Pose> initial_cam_from_centred;

  Eigen::Vector3d centre_in_target = Eigen::Vector3d::Zero();
  double length_m = 1;
  double image_unit_px = 1;

  kernel::ScreenPoints screen;  ///< the same, in floats

  std::size_t size() const { return points_in_centred.size(); }
  double area(std::size_t i) const { return areas.empty() ? 1 : areas[i]; }
  bool is_sigma_known() const { return sigma > 0; }
};

/// A cloud, or why there is none.
struct PreparedCloud {
  PoseStatus status = PoseStatus::kDegenerate;  ///< kOk: the cloud may be used
  Cloud cloud;
};

/// The root of the area over which pixels are spread, those on a line being taken for an image of a
/// quarter of their length each way; at least some twenty deviations of the noise. 0 where all
/// pixels are one.
double image_unit_px(const std::vector<Eigen::Vector2d>& pixels, double typical_noise_px);

/// A point of a problem that can be used, in the problem's own units.
struct UsablePoint {
  int index = 0;  ///< in the problem
  Eigen::Vector3d x_in_target;
  Eigen::Vector2d pixel;  ///< without lens, relative to the principal point
  /// What makes its residual one of unit noise where pixels have covariances, else the identity.
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
};

/// None where the point cannot be used, as prepare_cloud leaves it out. The problem's lists must be
/// of one length.
std::optional<UsablePoint> usable_point(const PoseProblem& problem, std::size_t i);

/// The points that cannot be used, ascending.
std::vector<int> unusable_points(const PoseProblem& problem);

/// A pose that is rigid but for rounding, to four decimals, made so; none for anything else.
std::optional<Pose> rigid_pose(const std::optional<Pose>& pose);

/// Leaves out the points that cannot be used: those with a number that is not finite or too large
/// to be squared, with a pixel that the lens model cannot undo, or with a covariance that is not
/// positive definite. An initial pose that is not finite or far from a rigid one is left out as
/// well; one that is a rotation but for rounding is made orthonormal.
///
/// kTooFewPoints as `prepare` (pose/reprojection.h) and where there are covariances but not one a
/// point. kDegenerate where too few points can be used or are distinct, all of them are collinear
/// or seen at one pixel, the camera has no positive focal length, or the noise is not a number.
PreparedCloud prepare_cloud(const PoseProblem& problem);

/// The same points as if nothing were known of their noise.
Cloud with_unknown_noise(Cloud cloud);

/// From the cloud's frame and unit to the target's, and back.
Pose from_cloud(const Pose& cam_from_centred, const Cloud& cloud);
Pose to_cloud(const Pose& cam_from_target, const Cloud& cloud);

/// The covariance of (w, dt) of cam_from_target, given that of cam_from_centred in cloud's units.
Matrix6d covariance_from_cloud(const Matrix6d& covariance, const Pose& cam_from_centred,
                               const Cloud& cloud);

/// A whitened residual and its derivative by (w, dt) in (Exp(w) R, t + dt), each coordinate's six.
struct Row {
  double residual[2];
  double jacobian[2][6];

  double squared() const { return residual[0] * residual[0] + residual[1] * residual[1]; }
};

/// The whitened residual of a point; false for one at or behind the camera's plane.
inline bool residual_at(const Cloud& cloud, const Pose& pose, std::size_t i, double (&r)[2]) {
  const Eigen::Vector3d x = pose * cloud.points_in_centred[i];
  if (!(x.z() > 0)) return false;
  const double inverse_z = 1 / x.z();
  r[0] = cloud.focal[0] * x.x() * inverse_z - cloud.image[i][0];
  r[1] = cloud.focal[1] * x.y() * inverse_z - cloud.image[i][1];
  if (cloud.whitening.empty()) return true;
  const Eigen::Matrix2d& w = cloud.whitening[i];
  const double first = w(0, 0) * r[0] + w(0, 1) * r[1];
  r[1] = w(1, 0) * r[0] + w(1, 1) * r[1];
  r[0] = first;
  return true;
}

/// The same with its derivative.
inline bool row_at(const Cloud& cloud, const Pose& pose, std::size_t i, Row& row) {
  const Eigen::Vector3d q = pose.rotation * cloud.points_in_centred[i];
  const Eigen::Vector3d x = q + pose.translation;
  if (!(x.z() > 0)) return false;
  const double inverse_z = 1 / x.z();
  for (int k = 0; k < 2; ++k) {
    const double f = cloud.focal[k] * inverse_z;
    const double a = x[k] * inverse_z;
    row.residual[k] = cloud.focal[k] * a - cloud.image[i][k];
    double(&j)[6] = row.jacobian[k];
    j[0] = k == 0 ? -f * a * q.y() : f * (-q.z() - a * q.y());
    j[1] = k == 0 ? f * (q.z() + a * q.x()) : f * a * q.x();
    j[2] = k == 0 ? -f * q.y() : f * q.x();
    j[3] = k == 0 ? f : 0;
    j[4] = k == 0 ? 0 : f;
    j[5] = -f * a;
  }
  if (cloud.whitening.empty()) return true;
  const Eigen::Matrix2d& w = cloud.whitening[i];
  const auto whiten = [&w](double& first, double& second) {
    const double whitened = w(0, 0) * first + w(0, 1) * second;
    second = w(1, 0) * first + w(1, 1) * second;
    first = whitened;
  };
  whiten(row.residual[0], row.residual[1]);
  for (int k = 0; k < 6; ++k) whiten(row.jacobian[0][k], row.jacobian[1][k]);
  return true;
}

/// The pose in the form of the float kernel.
kernel::ScreenPose screen_pose(const Cloud& cloud, const Pose& pose);

}  // namespace sightline::consensus
