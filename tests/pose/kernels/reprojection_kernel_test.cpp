// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernel of least squares against plain arithmetic. Which of its versions runs is the
// processor's choice.
#include "pose/kernels/reprojection_kernel.h"

#include <cmath>
#include <optional>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/minimise.h"
#include "pose/packed_points.h"
#include "tests/pose/kernels/random_case.h"
#include "tests/pose/matchers.h"

namespace sightline {
namespace {

/// Sums of a few dozen products; the kernel may fuse and reorder them.
constexpr double kSumRounding = 1e-12;

Matrix6d full(const double (&upper)[21]) {
  Matrix6d m;
  const double* next = upper;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) m(i, j) = m(j, i) = *next++;
  }
  return m;
}

/// Relative to the size of the rows, whose units differ.
testing::AssertionResult is_information_near(const Matrix6d& actual, const Matrix6d& expected,
                                             double tolerance) {
  const Vector6d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  return is_matrix_near(Matrix6d(scale.asDiagonal() * actual * scale.asDiagonal()),
                        Matrix6d(scale.asDiagonal() * expected * scale.asDiagonal()), tolerance);
}

kernel::NormalEquations kernel_model(const PackedPoints& points, const Pose& pose) {
  kernel::NormalEquations model;
  EXPECT_TRUE(kernel::normal_equations(points.lanes().data(), points.lanes().size(),
                                       rigid_from(pose), model));
  return model;
}

TEST(ReprojectionKernel, NormalEquationsEqualThePlainSums) {
  Draw draw(50);
  for (const int n : {4, 5, 8, 15, 16, 17, 40}) {
    const Case k = random_case(n, draw);
    const kernel::NormalEquations model = kernel_model(PackedPoints(k.c, k.weights), k.pose);
    const LocalModel plain = plain_model(k);
    EXPECT_NEAR(model.cost, plain.cost, kSumRounding * plain.cost) << n;
    EXPECT_TRUE(is_information_near(full(model.hessian), plain.hessian, 10 * kSumRounding)) << n;
    const Vector6d scale = plain.hessian.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_TRUE(is_matrix_near(
        Vector6d(scale.asDiagonal() * Eigen::Map<const Vector6d>(model.gradient)),
        Vector6d(scale.asDiagonal() * plain.gradient), kSumRounding * (1 + plain.cost)))
        << n;
  }
}

TEST(ReprojectionKernel, JacobianIsTheDerivative) {
  // The gradient against central differences of the cost.
  Draw draw(51);
  const Case k = random_case(8, draw);
  const PackedPoints points(k.c, k.weights);
  const kernel::NormalEquations model = kernel_model(points, k.pose);
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 6; ++axis) {
    Vector6d delta = Vector6d::Zero();
    delta[axis] = kStep;
    const double difference = kernel_model(points, retract(k.pose, delta)).cost -
                              kernel_model(points, retract(k.pose, -delta)).cost;
    // Rounding of the cost over the step, and the third derivative times the step squared.
    EXPECT_NEAR(difference / (2 * kStep), model.gradient[axis],
                1e-15 * model.cost / kStep * 10 + 1e-6 * std::abs(model.gradient[axis]) + 1e-2)
        << axis;
  }
}

TEST(ReprojectionKernel, PointsOfWeightZeroAreNotLookedAt) {
  Draw draw(52);
  Case k = random_case(9, draw);
  PackedPoints points(k.c, k.weights);
  points.scale_weight(4, 0);
  Case rest = k;
  rest.weights[4].setZero();
  const LocalModel plain = plain_model(rest);
  EXPECT_NEAR(kernel_model(points, k.pose).cost, plain.cost, kSumRounding * plain.cost);

  k.c.points_in_centred[4] = k.pose.rotation.transpose() * Eigen::Vector3d(0, 0, -1000);
  PackedPoints behind(k.c, k.weights);
  kernel::NormalEquations model;
  EXPECT_FALSE(kernel::normal_equations(behind.lanes().data(), behind.lanes().size(),
                                        rigid_from(k.pose), model));
  behind.scale_weight(4, 0);
  EXPECT_NEAR(kernel_model(behind, k.pose).cost, plain.cost, kSumRounding * plain.cost);
}

TEST(ReprojectionKernel, FitFindsTheMinimumThatThePlainIterationFinds) {
  Draw draw(53);
  for (int i = 0; i < 100; ++i) {
    const Case k = random_case(4 + i % 10, draw);
    const auto evaluate = [&k](const Pose& pose) -> std::optional<LocalModel> {
      return plain_model({k.c, pose, k.weights});
    };
    const Minimum plain = minimise(k.pose, evaluate, 200, 1e-12);
    const kernel::Fit fit = PackedPoints(k.c, k.weights).fit(k.pose, 200, 1e-12);
    if (plain.status != PoseStatus::kOk) continue;
    ASSERT_EQ(fit.status, kernel::FitStatus::kConverged);
    EXPECT_LE(fit.model.cost, plain.model.cost * (1 + 1e-9)) << i;
    EXPECT_TRUE(is_valid(pose_from(fit.pose)));
  }
}

TEST(ReprojectionKernel, InverseAndDeterminant) {
  Draw draw(54);
  const Case k = random_case(8, draw);
  const kernel::NormalEquations model = kernel_model(PackedPoints(k.c, k.weights), k.pose);
  const Matrix6d hessian = full(model.hessian);
  const auto inverse = inverse_of(model);
  ASSERT_TRUE(inverse);
  const Matrix6d expected = hessian.inverse();
  EXPECT_TRUE(is_information_near(*inverse, expected, 1e-8));
  EXPECT_NEAR(kernel::log_determinant(model.hessian), std::log(hessian.determinant()), 1e-8);

  kernel::NormalEquations singular = {};
  EXPECT_FALSE(inverse_of(singular));
  EXPECT_TRUE(std::isnan(kernel::log_determinant(singular.hessian)));
}

}  // namespace
}  // namespace sightline
