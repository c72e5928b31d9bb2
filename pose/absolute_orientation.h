// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

enum class OrientationStatus {
  kOk,
  kTooFewPoints,  ///< fewer than the method needs (three but for direct_linear), or lists of
                  ///< different lengths; points of weight zero do not count
  kDegenerate,    ///< collinear or coincident points: the rotation is not determined
  kNotFinite,     ///< a coordinate of a point that counts is NaN or infinite
  kBadWeights,    ///< not one a point, negative, NaN or infinite
  kReflection,    ///< the method fits the points best by a reflection and has no rotation to offer
  kNotConverged,  ///< an iterative method ran out of iterations
};

std::string_view to_string(OrientationStatus status);

struct OrientationEstimate {
  OrientationStatus status = OrientationStatus::kTooFewPoints;
  Pose b_from_a;     ///< meaningful only with status kOk
  double scale = 1;  ///< x_b = scale R x_a + t; other than 1 only from methods that estimate it
};

/// The rotation A that maximises tr(A^T B), B any 3x3 matrix, without a singular value
/// decomposition: the fast closed form of Li et al. 2012, equations (16) to (22) (Markley's FOAM).
/// How it is made safe is said in pose/orientation/fast.cpp. With g = (s2 + sign(det B) s3)/s1 the
/// gap between B's singular values, the error is of order epsilon/g, as that of the SVD.
/// Status kDegenerate when g is below 1e-12 (the maximiser is not unique), kNotFinite, or kOk.
OrientationEstimate fast_rotation(const Eigen::Matrix3d& b);

/// The least-squares pose b_from_a of matched points, sum w |x_b - (R x_a + t)|^2 -> min, by
/// fast_rotation. Needs three points that are not collinear. Points in metres, any offset. Weights:
/// none (all 1), or one a point, finite and not negative.
/// Points in float are summed in double, and the pose is double: the memory is halved, and no digit
/// that the coordinates hold is lost. (In float arithmetic the closed form is useless below gaps of
/// 1e-4, and an offset of 1e6 m leaves nothing.)
OrientationEstimate fast_absolute_orientation(std::span<const Eigen::Vector3d> points_in_a,
                                              std::span<const Eigen::Vector3d> points_in_b,
                                              std::span<const double> weights = {});
OrientationEstimate fast_absolute_orientation(std::span<const Eigen::Vector3f> points_in_a,
                                              std::span<const Eigen::Vector3f> points_in_b,
                                              std::span<const double> weights = {});

/// What a method fits, on which the covariance of its pose depends (pose/alignment.h).
enum class OrientationFit {
  kRigid,       ///< least squares over rotations and translations
  kSimilarity,  ///< the same with a scale
  kAffine,      ///< least squares over affine maps, then the nearest rotation
};

/// One way to the absolute orientation. In the catalogue for comparison; whoever wants a pose calls
/// fast_absolute_orientation. To add a method: write pose/orientation/<name>.cpp with one function
/// of moments, declare it in pose/orientation/methods.h, and give it a line in the catalogue
/// (pose/absolute_orientation.cpp).
struct OrientationMethod {
  template <typename Scalar>
  using Estimator = OrientationEstimate (*)(
      std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_a,
      std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_b, std::span<const double> weights);

  std::string_view name;
  std::string_view summary;
  Estimator<double> estimate_double;
  Estimator<float> estimate_float;
  OrientationFit fits = OrientationFit::kRigid;

  /// As fast_absolute_orientation, by this method.
  OrientationEstimate estimate(std::span<const Eigen::Vector3d> points_in_a,
                               std::span<const Eigen::Vector3d> points_in_b,
                               std::span<const double> weights = {}) const {
    return estimate_double(points_in_a, points_in_b, weights);
  }
  OrientationEstimate estimate(std::span<const Eigen::Vector3f> points_in_a,
                               std::span<const Eigen::Vector3f> points_in_b,
                               std::span<const double> weights = {}) const {
    return estimate_float(points_in_a, points_in_b, weights);
  }
};

/// The catalogue, in the order in which it is listed. What holds for every method: an estimate with
/// status kOk is a proper rotation and finite; no number is ever NaN; what does not determine a
/// rotation gets a status.
std::span<const OrientationMethod> orientation_methods();

/// The method of that name, or null.
const OrientationMethod* find_orientation_method(std::string_view name);

}  // namespace sightline
