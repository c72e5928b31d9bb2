// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The fast closed form of Li, Deng, Li, Wu 2012 (Markley's FOAM). With |.| Frobenius norms, det and
// adj those of B, lambda = s1 + s2 + s3 (s3 with the sign of det B), equations (16), (20), (21):
//
//   A = ((kappa + |B|^2) B + lambda adj(B)^T - B B^T B) / xi,
//   kappa = (lambda^2 - |B|^2) / 2,   xi = kappa lambda - det,
//
// lambda the largest root of (23), (lambda^2 - |B|^2)^2 - 8 lambda det - 4 |adj|^2 = 0.
// ((15) prints s^2 where s^3 belongs.) Nothing is decomposed. Needs points that are not collinear.
//
// Deviations. (a) The unknown is mu = lambda - |B|, kappa = mu (|B| + mu/2): solved for lambda,
// (23) cancels where B is nearly of rank one and A errs with the inverse square of the gap g = (s2
// + s3)/s1, for mu with its inverse, as the SVD does. The root is found from above by Householder's
// third-order method, to 1e-8 of the gap, for its error only stretches A along its axes. (b) A step
// of Newton and Schulz makes the result orthonormal; it squares that error. (c) Where s3 nearly
// cancels s2 (mirrored clouds) the square is back: a Newton step on SO(3) restores the digits. (d)
// Where xi / lambda^3, about g, is below 1e-4, or the root is double, the SVD takes over. (e) What
// the rounding of the coordinates could have made is no gap: kDegenerate.
//
// The arithmetic is in pose/kernels/orientation_kernels_body.h.

#include <cmath>
#include <limits>

#include "pose/kernels/orientation_kernels.h"
#include "pose/orientation/methods.h"

namespace sightline {
namespace {

template <typename Scalar>
using Points = std::span<const Eigen::Matrix<Scalar, 3, 1>>;

SvdRotation rotation_by_closed_form_or_svd(const Eigen::Matrix3d& b, double smallest_gap) {
  const ClosedForm closed = closed_form_rotation(b.data());
  if (!closed.is_precise || !(closed.smallest_gap > smallest_gap)) {
    return rotation_by_svd(b, smallest_gap);
  }
  return {OrientationStatus::kOk, Eigen::Matrix3d(closed.rotation)};
}

template <typename Scalar>
OrientationEstimate estimate_with_care(Points<Scalar> points_in_a, Points<Scalar> points_in_b,
                                       std::span<const double> weights) {
  const PairMoments moments = pair_moments<Scalar>(points_in_a, points_in_b, weights, false);
  if (moments.status != OrientationStatus::kOk) return {moments.status, {}};
  const SvdRotation best = rotation_by_closed_form_or_svd(moments.cross, moments.rounding);
  if (best.status != OrientationStatus::kOk) return {best.status, {}};
  return estimate_about_means(moments, best.rotation);
}

template <typename Scalar>
OrientationEstimate estimate_fast(Points<Scalar> points_in_a, Points<Scalar> points_in_b,
                                  std::span<const double> weights) {
  const std::size_t n = points_in_a.size();
  if (n < 3 || points_in_b.size() != n || !weights.empty()) {
    return estimate_with_care<Scalar>(points_in_a, points_in_b, weights);
  }
  const Scalar* a = points_in_a.data()->data();
  const Scalar* b = points_in_b.data()->data();
  const PairArrays<Scalar> arrays = {a, b, nullptr, n, {a[0], a[1], a[2]}, {b[0], b[1], b[2]}};
  // Not set to the identity first.
  OrientationEstimate estimate{OrientationStatus::kOk, {Eigen::Matrix3d(), Eigen::Vector3d()}};
  Pose& pose = estimate.b_from_a;
  if (!closed_form_pose(arrays, std::numeric_limits<Scalar>::epsilon(), pose.rotation.data(),
                        pose.translation.data())) {
    return estimate_with_care<Scalar>(points_in_a, points_in_b, weights);
  }
  return estimate;
}

double power_of_two_near_inverse(double x) {
  // Clamped so that it is finite for the smallest numbers too.
  return std::ldexp(1.0, std::min(-std::ilogb(x), 1000));
}

}  // namespace

OrientationEstimate fast_absolute_orientation(std::span<const Eigen::Vector3d> points_in_a,
                                              std::span<const Eigen::Vector3d> points_in_b,
                                              std::span<const double> weights) {
  return estimate_fast<double>(points_in_a, points_in_b, weights);
}

OrientationEstimate fast_absolute_orientation(std::span<const Eigen::Vector3f> points_in_a,
                                              std::span<const Eigen::Vector3f> points_in_b,
                                              std::span<const double> weights) {
  return estimate_fast<float>(points_in_a, points_in_b, weights);
}

OrientationEstimate fast_rotation(const Eigen::Matrix3d& b) {
  const ClosedForm closed = closed_form_rotation(b.data());
  if (closed.is_precise) {
    return {OrientationStatus::kOk, {Eigen::Matrix3d(closed.rotation), Eigen::Vector3d::Zero()}};
  }
  const double largest = b.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
  if (!std::isfinite(largest)) return {OrientationStatus::kNotFinite, {}};
  if (largest == 0) return {OrientationStatus::kDegenerate, {}};
  const SvdRotation best =
      rotation_by_closed_form_or_svd(b * power_of_two_near_inverse(largest), 0);
  if (best.status != OrientationStatus::kOk) return {best.status, {}};
  return {OrientationStatus::kOk, {best.rotation, Eigen::Vector3d::Zero()}};
}

}  // namespace sightline
