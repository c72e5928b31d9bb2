// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Marquardt's iteration on problems of one number, on which every step can be foretold.
#include "pose/kernels/marquardt.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/pose/matchers.h"

namespace sightline {
namespace {

/// Minimises |x|^power / power from a start, where `is_defined`; the Hessian may be said to be
/// `hessian_factor` times what it is.
struct PowerProblem {
  double x;
  double power = 2;
  double hessian_factor = 1;
  double tolerance = 1e-8;
  bool (*is_defined)(double) = [](double) { return true; };
  double delta = 0;
  int evaluations = 0;
  int last_steps = 0;

  double cost_at(double at) const { return std::pow(std::abs(at), power) / power; }
  double gradient() const { return std::copysign(std::pow(std::abs(x), power - 1), x); }
  double hessian() const { return hessian_factor * (power - 1) * std::pow(std::abs(x), power - 2); }

  bool evaluate_start() { return is_defined(x); }
  bool propose(double damping) {
    const double damped = hessian() * (1 + damping);
    if (!(damped > 0)) return false;
    delta = -gradient() / damped;
    return true;
  }
  bool is_short_step() const { return std::abs(delta) < tolerance; }
  double promise(double) const { return -0.5 * delta * gradient(); }
  double cost() const { return cost_at(x); }
  bool evaluate_candidate() {
    ++evaluations;
    return is_defined(x + delta);
  }
  double candidate_cost() const { return cost_at(x + delta); }
  void accept() { x += delta; }
  void take_last_step() {
    ++last_steps;
    x += delta;
  }
};

TEST(Marquardt, MeetsTheMinimumOfASquareAtOnce) {
  PowerProblem problem{.x = 3};
  int iterations = 0;
  EXPECT_EQ(kernel::marquardt(problem, 100, iterations), kernel::FitStatus::kConverged);
  // The first step falls short by the initial damping, the second by a tenth of it.
  EXPECT_LE(iterations, 4);
  EXPECT_NEAR(problem.x, 0, 1e-12);
  EXPECT_EQ(problem.evaluations, iterations - 1) << "the last step is the problem's to look at";
  EXPECT_EQ(problem.last_steps, 1);
}

TEST(Marquardt, DampsStepsThatOvershoot) {
  // Twenty times too long, and each step across the minimum and up the other side.
  PowerProblem problem{.x = 3, .hessian_factor = 0.05};
  int iterations = 0;
  EXPECT_EQ(kernel::marquardt(problem, 1000, iterations), kernel::FitStatus::kConverged);
  EXPECT_NEAR(problem.x, 0, 1e-6);
  EXPECT_GT(problem.evaluations, 5);
}

TEST(Marquardt, StopsAtItsLimitAndSaysSo) {
  PowerProblem problem{.x = 3, .power = 4};
  int iterations = 0;
  EXPECT_EQ(kernel::marquardt(problem, 2, iterations), kernel::FitStatus::kNotConverged);
  EXPECT_EQ(iterations, 2);
  PowerProblem again{.x = 3, .power = 4};
  EXPECT_EQ(kernel::marquardt(again, 1000, iterations), kernel::FitStatus::kConverged);
}

TEST(Marquardt, NeedsACostAtTheStart) {
  PowerProblem problem{.x = 3};
  problem.is_defined = [](double x) { return x < 2; };
  int iterations = 7;
  EXPECT_EQ(kernel::marquardt(problem, 100, iterations), kernel::FitStatus::kStartBehindCamera);
  EXPECT_EQ(iterations, 0);
}

TEST(Marquardt, DoesNotGoWhereThereIsNoCost) {
  PowerProblem problem{.x = 3};
  problem.is_defined = [](double x) { return x > 1; };
  int iterations = 0;
  kernel::marquardt(problem, 200, iterations);
  EXPECT_GT(problem.x, 1);
  EXPECT_LT(problem.x, 1.5);
}

TEST(Marquardt, AToleranceThatIsNoneIsTheFinestThereIs) {
  EXPECT_EQ(kernel::usable_tolerance(1e-6), 1e-6);
  for (const double none : {0.0, -1.0, kNaN}) {
    EXPECT_GT(kernel::usable_tolerance(none), 0);
    EXPECT_LT(kernel::usable_tolerance(none), 1e-12);
  }
}

TEST(Marquardt, DampingFallsToItsLeast) {
  double damping = kernel::kInitialDamping;
  for (int i = 0; i < 3; ++i) damping = kernel::lowered_damping(damping);
  EXPECT_NEAR(damping, 1e-8, 1e-20);
  for (int i = 0; i < 30; ++i) damping = kernel::lowered_damping(damping);
  EXPECT_EQ(damping, kernel::kSmallestDamping);
}

}  // namespace
}  // namespace sightline
