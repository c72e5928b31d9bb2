// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Least squares; drop the point of the largest studentised residual; least squares again; until no
// residual is larger than noise explains. With M = I - J (J^T J)^-1 J^T, whose block M_ii makes
// sigma^2 M_ii the covariance of the least-squares residual r_i, and q_i = r_i^T M_ii^-1 r_i (what
// the sum of squares RSS falls by without point i):
//
//   sigma known:    drop when  P(chi2_2 > q_i / sigma^2)               < p,
//   not known:      drop when  P(F_{2, nu} > (q_i / 2) / ((RSS - q_i) / nu))
//                              = (1 - q_i / RSS)^(nu / 2)              < p,   nu = 2 m - 8,
//
// m the points left, p = 1 - (1 - false_alarm_rate)^(1/m). The test of a mean-shift outlier: Cook
// and Weisberg, "Residuals and influence in regression", 1982, section 2.2.2; in photogrammetry
// Baarda's data snooping, 1968, and Pope's tau test, 1976 (here for two coordinates at once).
//
// Needs four points that are not collinear, or three with an initial pose. Uses covariances_px2
// (they whiten the residuals), else sigma_px, else the second test. max_removed is the most that
// are dropped: who knows the number k of outliers passes k and a false_alarm_rate of 0.5, at which
// the test hardly ever stops before. Never leaves fewer than five points. From every start the
// whole sequence is run; the fewest drops win, then the lower sum of squares.
//
// It looks at one point at a time: of several outliers each may hide the other.

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "pose/removal_limits.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

struct Suspect {
  std::size_t index = 0;
  double fall = 0;  ///< q_i
};

/// The kept point of the largest q_i. A point that the others do not judge (M_ii singular) is none.
Suspect most_suspect(const WhitenedCorrespondences& c, const LeastSquares& solution,
                     std::span<const double> weights) {
  constexpr double kJudged = 1e-9;  // of det M_ii, which is 1 where the point has no leverage
  Suspect suspect;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (weights[i] == 0) continue;
    const std::optional<Reprojection> r = whitened_reprojection(c, i, solution.cam_from_centred);
    if (!r) continue;
    const Eigen::Matrix2d m = Eigen::Matrix2d::Identity() -
                              r->jacobian * solution.unit_covariance * r->jacobian.transpose();
    if (!(m.determinant() > kJudged)) continue;
    const double fall = r->residual_px.dot(m.inverse() * r->residual_px);
    if (fall > suspect.fall) suspect = {i, fall};
  }
  return suspect;
}

/// Whether noise explains the suspect's q_i among `kept` points only with a smaller probability
/// than p.
bool is_outlier(const Suspect& suspect, double sum_of_squares, double sigma, std::size_t kept,
                double false_alarm_rate) {
  if (sigma > 0) {
    return suspect.fall > sigma * sigma * squared_threshold(false_alarm_rate, kept);
  }
  const double rounding = kSmallestSigma * kSmallestSigma * static_cast<double>(kept);
  if (!(sum_of_squares > rounding)) return false;
  const double left = std::max(1 - suspect.fall / sum_of_squares, 0.0);
  const double half_degrees = static_cast<double>(kept) - 4;
  return std::pow(left, half_degrees) < tail_probability(false_alarm_rate, kept);
}

struct Reduced {
  LeastSquares solution;
  std::vector<int> removed;
};

Reduced reduce(const WhitenedCorrespondences& c, const Pose& start, const SolverOptions& options) {
  const std::size_t limit = removal_limit(options.outliers, c.size());
  std::vector<double> weights(c.size(), 1.0);
  Reduced current = {whitened_least_squares(c, std::span(&start, 1), options.lspe, weights), {}};
  while (current.solution.status == PoseStatus::kOk && current.removed.size() < limit) {
    const Suspect suspect = most_suspect(c, current.solution, weights);
    const std::size_t kept = c.size() - current.removed.size();
    if (!is_outlier(suspect, current.solution.cost_px2, c.sigma, kept,
                    options.outliers.false_alarm_rate)) {
      break;
    }
    weights[suspect.index] = 0;
    LeastSquares next = whitened_least_squares(c, std::span(&current.solution.cam_from_centred, 1),
                                               options.lspe, weights);
    if (next.status != PoseStatus::kOk) break;
    next.iterations += current.solution.iterations;
    current.solution = next;
    current.removed.push_back(static_cast<int>(suspect.index));
  }
  std::ranges::sort(current.removed);
  return current;
}

bool is_preferable(const Reduced& a, const Reduced& b) {
  if (a.solution.status != b.solution.status) return a.solution.status == PoseStatus::kOk;
  if (a.removed.size() != b.removed.size()) return a.removed.size() < b.removed.size();
  return a.solution.cost_px2 < b.solution.cost_px2;
}

}  // namespace

PoseEstimate solve_drop_largest(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  std::optional<Reduced> best;
  int iterations = 0;
  for (const Pose& start : starting_poses(c.points, problem.initial_cam_from_target)) {
    Reduced next = reduce(c, start, options);
    iterations += next.solution.iterations;
    if (!best || is_preferable(next, *best)) best = std::move(next);
  }
  if (!best) return estimate_of_failure(PoseStatus::kDegenerate);
  best->solution.iterations = iterations;
  return estimate_from_least_squares(best->solution, c.points, best->removed);
}

}  // namespace sightline
