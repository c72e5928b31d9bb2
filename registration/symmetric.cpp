// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/symmetric.h"

#include <Eigen/Cholesky>

namespace sightline {

std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& matrix) {
  constexpr double kLeastPivot = 1e-11;
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt();
  if (!(scale.minCoeff() > 0) || !matrix.allFinite()) return std::nullopt;
  const Eigen::VectorXd unscale = scale.cwiseInverse();
  const Eigen::MatrixXd scaled = unscale.asDiagonal() * matrix * unscale.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  if (!(factor.vectorD().minCoeff() > kLeastPivot)) return std::nullopt;
  const Eigen::MatrixXd inverse =
      factor.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
  return Eigen::MatrixXd(unscale.asDiagonal() * inverse * unscale.asDiagonal());
}

Eigen::VectorXd solved(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  const Eigen::VectorXd unscale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unscale.asDiagonal() * matrix * unscale.asDiagonal();
  const Eigen::VectorXd scaled_right = unscale.cwiseProduct(right);
  const Eigen::VectorXd scaled_x = Eigen::LDLT<Eigen::MatrixXd>(scaled).solve(scaled_right);
  return unscale.cwiseProduct(scaled_x);
}

double mahalanobis2(const Eigen::VectorXd& e, const Eigen::MatrixXd& matrix) {
  return e.dot(solved(matrix, e));
}

}  // namespace sightline
