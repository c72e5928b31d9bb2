// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <numbers>
#include <ostream>

#include <Eigen/Core>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A short product of rotations rounds to a few units in the last place.
inline constexpr double kRotationRounding = 16 * kEpsilon;

// The comparisons are written !(a <= b), so that NaN fails.

inline testing::AssertionResult is_rotation_near(const Eigen::Matrix3d& actual,
                                                 const Eigen::Matrix3d& expected,
                                                 double tolerance_rad) {
  const double angle_rad = geodesic_angle_rad(actual, expected);
  if (!(angle_rad <= tolerance_rad)) {
    return testing::AssertionFailure()
           << "rotations differ by " << angle_rad / kDegree << " deg, allowed "
           << tolerance_rad / kDegree << " deg\nactual\n"
           << actual << "\nexpected\n"
           << expected;
  }
  return testing::AssertionSuccess();
}

inline testing::AssertionResult is_pose_near(const Pose& actual, const Pose& expected,
                                             double tolerance_rad, double tolerance_m) {
  if (!is_valid(actual)) return testing::AssertionFailure() << "not a rigid pose";
  const auto rotation = is_rotation_near(actual.rotation, expected.rotation, tolerance_rad);
  if (!rotation) return rotation;
  const double distance_m = (actual.translation - expected.translation).norm();
  if (!(distance_m <= tolerance_m)) {
    return testing::AssertionFailure()
           << "translations differ by " << distance_m << " m, allowed " << tolerance_m
           << " m; actual " << actual.translation.transpose() << ", expected "
           << expected.translation.transpose();
  }
  return testing::AssertionSuccess();
}

template <typename A, typename B>
testing::AssertionResult is_matrix_near(const A& actual, const B& expected, double tolerance) {
  const double difference = (actual - expected).cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
  if (!(difference <= tolerance)) {
    return testing::AssertionFailure()
           << "largest difference " << difference << ", allowed " << tolerance << "\nactual\n"
           << actual << "\nexpected\n"
           << expected;
  }
  return testing::AssertionSuccess();
}

/// Nothing in an estimate may be NaN, whatever its status.
inline testing::AssertionResult is_free_of_nan(const PoseEstimate& e) {
  const bool is_finite = e.cam_from_target.rotation.allFinite() &&
                         e.cam_from_target.translation.allFinite() && e.unit_covariance.allFinite();
  if (!is_finite)
    return testing::AssertionFailure() << "estimate holds a number that is not finite";
  return testing::AssertionSuccess();
}

inline void PrintTo(PoseStatus status, std::ostream* out) {
  *out << to_string(status);
}

/// Beside the name of a test that is made for every solver, instead of the bytes of its entry.
inline void PrintTo(const PoseSolver& solver, std::ostream* out) {
  *out << solver.name;
}

}  // namespace sightline
