// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels against plain arithmetic. Which of its versions runs is the processor's choice.
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/kernels/removal_kernel.h"
#include "pose/kernels/reprojection_kernel.h"
#include "pose/reprojection.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

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

struct Case {
  Correspondences c;
  Pose pose;
  std::vector<Eigen::Matrix2d> weights;
};

Case random_case(int n, Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < n; ++i) points.push_back(draw.in_box(1));
  Camera camera = centred_camera(640, 480, 800);
  camera.fy_px = 750;
  Synthetic s = exact_problem(camera, points, {draw.rotation(), {0.3, -0.2, draw.uniform(4, 20)}});
  add_noise(s.problem, 2, draw);
  Case result = {prepare(s.problem).correspondences, {}, {}};
  result.pose = to_centred(s.cam_from_target, result.c);
  result.pose.rotation = draw.rotation_by(0.05) * result.pose.rotation;
  for (int i = 0; i < n; ++i) {
    Eigen::Matrix2d root;
    root << draw.normal(), draw.normal(), draw.normal(), draw.normal();
    result.weights.push_back(root * root.transpose() + 0.1 * Eigen::Matrix2d::Identity());
  }
  return result;
}

/// The plain sums.
LocalModel plain_model(const Case& k) {
  LocalModel model;
  for (std::size_t i = 0; i < k.c.size(); ++i) {
    const Reprojection r = reproject(k.c, i, k.pose).value();
    model.cost += 0.5 * r.residual_px.dot(k.weights[i] * r.residual_px);
    model.gradient += r.jacobian.transpose() * k.weights[i] * r.residual_px;
    model.hessian += r.jacobian.transpose() * k.weights[i] * r.jacobian;
  }
  return model;
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

TEST(RemovalKernel, BasisIsOrthonormalAndResidualsAreOfLeastSquares) {
  Draw draw(55);
  for (const int n : {4, 7, 8, 13}) {
    const Case k = random_case(n, draw);
    const PackedPoints points(k.c, k.weights);
    const std::size_t stride = kernel::padded(n);
    std::vector<double> basis(12 * stride), residuals(2 * stride);
    kernel::LinearModel model;
    ASSERT_TRUE(kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(k.pose),
                                  basis.data(), residuals.data(), model));
    for (int a = 0; a < 6; ++a) {
      double along = 0;
      for (int b = 0; b <= a; ++b) {
        double dot = 0;
        for (std::size_t i = 0; i < stride; ++i) {
          dot += basis[a * stride + i] * basis[b * stride + i] +
                 basis[(6 + a) * stride + i] * basis[(6 + b) * stride + i];
        }
        EXPECT_NEAR(dot, a == b, 1e-8);
      }
      for (std::size_t i = 0; i < stride; ++i) {
        along += basis[a * stride + i] * residuals[i] +
                 basis[(6 + a) * stride + i] * residuals[stride + i];
      }
      EXPECT_NEAR(along, 0, 1e-8 * std::sqrt(model.rss));
    }
    const LocalModel plain = plain_model(k);
    const Vector6d step = -plain.hessian.ldlt().solve(plain.gradient);
    EXPECT_TRUE(is_matrix_near(Vector6d(Eigen::Map<const Vector6d>(model.step)), step, 1e-8));
    // What the linear model says that least squares leaves.
    EXPECT_NEAR(model.rss, 2 * plain.cost + plain.gradient.dot(step), 1e-8 * plain.cost);
    EXPECT_NEAR(model.log_det, std::log(plain.hessian.determinant()), 1e-8);
  }
}

std::vector<std::vector<int>> sets_in_order(int n, int max_size) {
  std::vector<std::vector<int>> sets;
  const auto extend = [&](const auto& self, std::vector<int> set, int next) -> void {
    for (int i = next; i < n; ++i) {
      std::vector<int> larger = set;
      larger.push_back(i);
      sets.push_back(larger);
      if (static_cast<int>(larger.size()) < max_size) self(self, larger, i + 1);
    }
  };
  extend(extend, {}, 0);
  return sets;
}

TEST(RemovalKernel, SweepEqualsDenseAlgebraForEverySet) {
  Draw draw(56);
  for (const int n : {4, 5, 8, 11}) {
    const Case k = random_case(n, draw);
    const PackedPoints points(k.c, k.weights);
    const std::size_t stride = kernel::padded(n);
    std::vector<double> basis(12 * stride), residuals(2 * stride), gamma;
    for (int i = 0; i < n; ++i) gamma.push_back(draw.uniform(0.001, 0.1));
    kernel::LinearModel model;
    ASSERT_TRUE(kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(k.pose),
                                  basis.data(), residuals.data(), model));
    for (const int max_size : {1, 2, 3, 4}) {
      const auto sets = sets_in_order(n, max_size);
      ASSERT_EQ(kernel::set_count(n, max_size), sets.size());
      std::vector<double> q(sets.size()), det(sets.size());
      std::vector<double> workspace(kernel::sweep_workspace(n, max_size));
      kernel::sweep_sets(n, basis.data(), residuals.data(), gamma.data(), max_size,
                         workspace.data(), q.data(), det.data());
      for (std::size_t i = 0; i < sets.size(); ++i) {
        const int size = static_cast<int>(2 * sets[i].size());
        Eigen::MatrixXd m(size, size);
        Eigen::VectorXd r(size);
        for (int a = 0; a < size; ++a) {
          const int point_a = sets[i][a / 2];
          r[a] = residuals[(a % 2) * stride + point_a];
          for (int b = 0; b < size; ++b) {
            const int point_b = sets[i][b / 2];
            m(a, b) = a == b ? 1 + gamma[point_a] : 0;
            for (int c = 0; c < 6; ++c) {
              m(a, b) -= basis[(6 * (a % 2) + c) * stride + point_a] *
                         basis[(6 * (b % 2) + c) * stride + point_b];
            }
          }
        }
        // Sets that leave too few points to fix a pose have pivots near gamma.
        EXPECT_NEAR(q[i], r.dot(m.lu().solve(r)), 1e-7 * (1 + q[i]));
        EXPECT_NEAR(det[i], m.determinant(), 1e-9);
      }
    }
  }
}

TEST(RemovalKernel, RefusesPointsBehindTheCameraAndNoPoints) {
  Draw draw(57);
  Case k = random_case(6, draw);
  k.c.points_in_centred[2] = k.pose.rotation.transpose() * Eigen::Vector3d(0, 0, -1000);
  std::vector<double> basis(12 * 8), residuals(2 * 8);
  kernel::LinearModel model;
  const PackedPoints points(k.c, k.weights);
  EXPECT_FALSE(kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(k.pose),
                                 basis.data(), residuals.data(), model));
  EXPECT_FALSE(kernel::linearise(points.lanes().data(), 0, rigid_from(k.pose), basis.data(),
                                 residuals.data(), model));
}

}  // namespace
}  // namespace sightline
