// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The algebra of the interior point method of pose/minimax.cpp, which minimises the largest f_i,
// the squared residual of point i, over poses: one Newton step on the conditions
//
//   min t subject to f_i(x) + s_i = t, s_i >= 0, x a pose, f_i = |r_i|^2.
//
// With multipliers l_i > 0, slopes g_i = 2 J_i^T r_i, w_i = l_i / s_i, misses m_i = f_i + s_i - t
// and p_i = (mu - correction_i + l_i m_i) / s_i, Newton's step for  sum l_i g_i = 0,  sum l_i = 1,
// l_i s_i = mu,  m_i = 0  is, ds_i and dl_i eliminated,
//
//   [H + sum w_i g_i g_i^T   -sum w_i g_i] [dx]   [-sum p_i g_i]
//   [-sum w_i g_i^T           sum w_i    ] [dt] = [ sum p_i - 1 ]
//   ds_i = dt - g_i . dx - m_i,   dl_i = (mu - correction_i - l_i ds_i) / s_i - l_i,
//   H = sum 2 l_i J_i^T J_i, and after a few iterations the second derivatives of r_i as well.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/pose.h"

namespace sightline::interior_point {

/// One constraint f + slack = t: its residual, derivative and slope at the pose, and the unknowns
/// that are its own.
struct Constraint {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> jacobian;
  Vector6d slope;
  double f = 0;
  double slack = 0;
  double multiplier = 0;
  double miss = 0;        ///< f + slack - t
  double correction = 0;  ///< of second order: of l s
  double slack_change = 0;
  double multiplier_change = 0;
};

/// A positive definite matrix, its rows scaled to a unit diagonal, factored for solving. A part of
/// the pose that is fixed has a zero row, and its solution is zero.
class ScaledCholesky {
 public:
  ScaledCholesky(const Matrix6d& matrix, double ridge) {
    for (int i = 0; i < 6; ++i) scale_[i] = matrix(i, i) > 0 ? 1 / std::sqrt(matrix(i, i)) : 0;
    Matrix6d scaled = scale_.asDiagonal() * matrix * scale_.asDiagonal();
    for (int i = 0; i < 6; ++i) scaled(i, i) = 1 + ridge;
    cholesky_.compute(scaled);
  }
  bool is_ok() const { return cholesky_.info() == Eigen::Success; }
  Vector6d solve(const Vector6d& right) const {
    return scale_.cwiseProduct(cholesky_.solve(scale_.cwiseProduct(right)));
  }

 private:
  Vector6d scale_;
  Eigen::LLT<Matrix6d> cholesky_;
};

/// The factored Newton matrix, from which the changes of t, slacks and multipliers are eliminated.
struct NewtonSystem {
  std::optional<ScaledCholesky> matrix;
  Vector6d coupling = Vector6d::Zero();  ///< sum w g
  double weight_sum = 0;
  double ridge = 0;
};

/// A Newton step: the change (w, dt) of the pose and that of the bound t.
struct Step {
  Vector6d delta;
  double bound_change = 0;
};

/// Which parts of a step are taken: of pose, bound and slacks, and of the multipliers.
struct StepLengths {
  double primal = 1;
  double dual = 1;
};

/// Fills residuals, derivatives, slopes and f of the constraints, one a fitted point, at a pose.
/// False where a point is behind the camera or a number is not finite.
bool evaluate(const FitPoints& points, const Pose& pose, FreePart free,
              std::vector<Constraint>& constraints);

/// max f_i.
double largest_of(const std::vector<Constraint>& constraints);

/// The mean of l_i s_i, which is mu where all products are equal.
double mean_product(const std::vector<Constraint>& constraints);

/// Sum of l_i times the part of the second derivative of f_i that Gauss and Newton leave out,
/// 2 r_i . (second derivative of r_i), by (w, dt) in (Exp(w) R, t + dt).
Matrix6d residual_curvature(const FitPoints& points, const Pose& pose, FreePart free,
                            const std::vector<Constraint>& constraints);

/// The system of the constraints as they stand. `curvature` is residual_curvature or zero; where it
/// makes the matrix indefinite the diagonal is raised by a ridge, a part of itself, and by
/// `least_ridge` in any case. None where no ridge helps.
std::optional<NewtonSystem> newton_system(const std::vector<Constraint>& constraints,
                                          const Matrix6d& curvature, double least_ridge);

/// The larger of a step's turn in radians and its move as a part of the range.
double length(const Step& step, const Pose& pose);

/// Solves for the step towards l s = mu - correction and f + s = t, and stores the constraints' own
/// changes with them.
Step newton_step(const NewtonSystem& system, std::vector<Constraint>& constraints, double mu);

/// The longest steps, at most 1, that keep slacks and multipliers at 1 - `part` of themselves.
StepLengths longest_steps(const std::vector<Constraint>& constraints, double part);

/// Mehrotra's predictor: how far mu may fall now, from where a step straight to mu = 0 would bring
/// the products, whose mean is `products`. Stores in the constraints what the step's second order
/// is.
double predict(std::vector<Constraint>& constraints, const Step& step, double products);

/// (max f - lower bound) / max f, the bound being the minimum of sum l f for residuals that are
/// linear in the pose.
double relative_gap(const std::vector<Constraint>& constraints);

}  // namespace sightline::interior_point
