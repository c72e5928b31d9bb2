// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Marquardt's method, written once for the kernel that fits reprojection errors
// (pose/kernels/reprojection_kernel.cpp) and for any other cost of a pose (pose/minimise.h). It
// knows neither Eigen nor what a step is: the problem that it is given holds all numbers.
//
// Each iteration solves (H + damping diag H) delta = -g for a step. A step that lowers the cost is
// taken and the damping falls, so that the next is more like Newton's; one that does not is given
// up and the damping rises, so that the next is shorter and more like the gradient's.
#pragma once

namespace sightline::kernel {

/// How an iteration ended.
enum class FitStatus {
  kConverged,
  kStartBehindCamera,  ///< the cost is not defined at the start: a point is behind the camera
  kNotConverged,       ///< the limit of iterations came first
};

/// The damping at the start, the least that there is, and what it changes by.
inline constexpr double kInitialDamping = 1e-5;
inline constexpr double kSmallestDamping = 1e-12;
inline constexpr double kDampingFactor = 10;
/// Damping from here on shortens steps noticeably: a short step then does not mean convergence.
inline constexpr double kHeavyDamping = 0.1;

/// The distance from 1 to the next larger double.
inline constexpr double kRounding = 0x1p-52;

/// The step tolerance to work with when `asked` for one. Steps shorter than the least one are
/// rounding; it also takes the place of a tolerance that is negative or NaN.
inline double usable_tolerance(double asked) {
  constexpr double kSmallestTolerance = 1e-14;
  return asked > kSmallestTolerance ? asked : kSmallestTolerance;
}

/// Whether a candidate of this cost may replace the best so far. Near the minimum costs differ by
/// rounding only, so that an equal one, to rounding, is as good.
inline bool is_no_worse(double cost, double best_cost) {
  return cost <= best_cost * (1 + 8 * kRounding);
}

/// The damping after a step that was taken.
inline double lowered_damping(double damping) {
  return damping > kSmallestDamping * kDampingFactor ? damping / kDampingFactor : kSmallestDamping;
}

/// The iteration from the problem's start, at most `max_iterations` steps, which are counted in
/// `iterations`. A problem has
///
///   bool evaluate_start()       cost, gradient and Hessian at the start, which is the best pose so
///                               far; false where the cost is not defined
///   bool propose(damping)       the step from the best pose; false where the damped Hessian is not
///                               positive definite
///   bool is_short_step()        whether the proposed step is within the tolerance
///   double promise(damping)     what the quadratic model says that the step lowers the cost by
///   double cost()               at the best pose
///   bool evaluate_candidate()   cost, gradient and Hessian at the candidate, the pose that the
///   step
///                               leads to; false where the cost is not defined
///   double candidate_cost()     after evaluate_candidate
///   void accept()               makes the evaluated candidate the best pose
///   void take_last_step()       ends with a step so short that the iteration has converged; the
///                               problem says whether the step is worth an evaluation
///
/// It has converged when a step that damping hardly shortens is short or promises less than
/// rounding, or when a step as small does not lower the cost however it is damped.
template <typename Problem>
FitStatus marquardt(Problem& problem, int max_iterations, int& iterations) {
  iterations = 0;
  if (!problem.evaluate_start()) return FitStatus::kStartBehindCamera;
  double damping = kInitialDamping;
  while (iterations < max_iterations) {
    ++iterations;
    if (!problem.propose(damping)) {
      damping *= kDampingFactor;
      continue;
    }
    const bool is_end =
        problem.is_short_step() || problem.promise(damping) < kRounding * problem.cost();
    if (is_end && damping < kHeavyDamping) {
      problem.take_last_step();
      return FitStatus::kConverged;
    }
    if (problem.evaluate_candidate() && is_no_worse(problem.candidate_cost(), problem.cost())) {
      problem.accept();
      damping = lowered_damping(damping);
      continue;
    }
    if (is_end) return FitStatus::kConverged;
    damping *= kDampingFactor;
  }
  return FitStatus::kNotConverged;
}

}  // namespace sightline::kernel
