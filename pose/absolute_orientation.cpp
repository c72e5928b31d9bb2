// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/absolute_orientation.h"

#include <array>

#include "pose/orientation/methods.h"
#include "pose/pair_moments.h"

namespace sightline {
namespace {

template <typename Scalar>
using Points = std::span<const Eigen::Matrix<Scalar, 3, 1>>;

/// What of the moments a method reads.
enum class Reads { kCross, kCrossAndSpread };

template <typename Scalar, auto kFromMoments, int kMinimumPoints, Reads kReads>
OrientationEstimate estimate_by_moments(Points<Scalar> points_in_a, Points<Scalar> points_in_b,
                                        std::span<const double> weights) {
  const PairMoments moments =
      pair_moments<Scalar>(points_in_a, points_in_b, weights, kReads == Reads::kCrossAndSpread);
  if (moments.status != OrientationStatus::kOk) return {moments.status, {}};
  if (moments.positive_weights < kMinimumPoints) return {OrientationStatus::kTooFewPoints, {}};
  return kFromMoments(moments);
}

template <auto kFromMoments, int kMinimumPoints, Reads kReads>
constexpr OrientationMethod method(std::string_view name, std::string_view summary,
                                   OrientationFit fits = OrientationFit::kRigid) {
  return {name, summary, estimate_by_moments<double, kFromMoments, kMinimumPoints, kReads>,
          estimate_by_moments<float, kFromMoments, kMinimumPoints, kReads>, fits};
}

constexpr std::array kCatalogue = {
    OrientationMethod{"fast", "closed form without decomposition (Li et al. 2012), made safe",
                      fast_absolute_orientation, fast_absolute_orientation},
    method<orient_by_umeyama, 3, Reads::kCross>(
        "umeyama", "singular value decomposition, always a rotation (Umeyama 1991)"),
    method<orient_by_umeyama_scaled, 3, Reads::kCrossAndSpread>(
        "umeyama_scaled", "the same with a scale (Umeyama 1991)", OrientationFit::kSimilarity),
    method<orient_by_arun, 3, Reads::kCross>(
        "arun", "singular value decomposition, may find a reflection (Arun et al. 1987)"),
    method<orient_by_horn_quaternion, 3, Reads::kCross>("horn_quaternion",
                                                        "eigenvector of a 4x4 matrix (Horn 1987)"),
    method<orient_by_horn_orthonormal, 3, Reads::kCross>(
        "horn_orthonormal", "square root of a 3x3 matrix (Horn et al. 1988)"),
    method<orient_by_walker_dual_quaternion, 3, Reads::kCross>(
        "walker_dual_quaternion", "rotation and translation as a dual quaternion (Walker 1991)"),
    method<orient_by_gauss_newton, 3, Reads::kCrossAndSpread>(
        "gauss_newton", "iterative least squares on the rotations"),
    method<orient_by_direct_linear, 4, Reads::kCrossAndSpread>(
        "direct_linear", "affine least squares, then the nearest rotation",
        OrientationFit::kAffine),
};

}  // namespace

std::string_view to_string(OrientationStatus status) {
  switch (status) {
    case OrientationStatus::kOk:
      return "ok";
    case OrientationStatus::kTooFewPoints:
      return "too_few_points";
    case OrientationStatus::kDegenerate:
      return "degenerate";
    case OrientationStatus::kNotFinite:
      return "not_finite";
    case OrientationStatus::kBadWeights:
      return "bad_weights";
    case OrientationStatus::kReflection:
      return "reflection";
    case OrientationStatus::kNotConverged:
      return "not_converged";
  }
  return "unknown";
}

std::span<const OrientationMethod> orientation_methods() {
  return kCatalogue;
}

const OrientationMethod* find_orientation_method(std::string_view name) {
  for (const OrientationMethod& method : kCatalogue) {
    if (method.name == name) return &method;
  }
  return nullptr;
}

}  // namespace sightline
