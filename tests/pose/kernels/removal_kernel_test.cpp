// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernel of removal sets against dense algebra. Which of its versions runs is the processor's
// choice.
#include "pose/kernels/removal_kernel.h"

#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/packed_points.h"
#include "tests/pose/kernels/random_case.h"
#include "tests/pose/matchers.h"

namespace sightline {
namespace {

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
    std::vector<double> basis(12 * stride), residuals(2 * stride), gamma, log_odds;
    for (int i = 0; i < n; ++i) {
      gamma.push_back(draw.uniform(0.001, 0.1));
      log_odds.push_back(draw.uniform(-10, 1));
    }
    kernel::LinearModel model;
    ASSERT_TRUE(kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(k.pose),
                                  basis.data(), residuals.data(), model));
    std::vector<double> workspace(kernel::sweep_workspace(n, 4));
    int before = 0;
    for (const int max_size : {1, 2, 3, 4}) {
      const auto sets = sets_in_order(n, max_size);
      ASSERT_EQ(kernel::set_count(n, max_size), sets.size());
      const std::size_t room = kernel::swept_room(n, max_size);
      std::vector<double> q(room), det(room), weight(room);
      kernel::sweep_sets(
          {k.c.size(), basis.data(), residuals.data(), gamma.data(), log_odds.data()}, max_size,
          before, workspace.data(), {q.data(), det.data(), weight.data()});
      before = max_size;
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
        double exact = q[i] - std::log(det[i]);
        for (const int point : sets[i]) exact += 2 * log_odds[point];
        EXPECT_GE(weight[i], exact - 1e-9);
        EXPECT_LE(weight[i], exact + kernel::kRoughLog);
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
