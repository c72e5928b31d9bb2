// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Symmetric matrices of any size, in one place: Eigen's decompositions take long to compile.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace sightline {

/// The inverse of a positive definite matrix. None where it is not, or is singular to rounding: its
/// unknowns may have any units.
std::optional<Eigen::MatrixXd> inverse_of(const Eigen::MatrixXd& matrix);

/// The x with matrix x = right, of a positive definite matrix.
Eigen::VectorXd solved(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right);

/// e' matrix^-1 e.
double mahalanobis2(const Eigen::VectorXd& e, const Eigen::MatrixXd& matrix);

}  // namespace sightline
