// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every solver whatever it is given: problems are put together at random from
// degenerate shapes, scales, pixels and starts. RC_PARAMS="seed=..., max_success=..." in the
// environment tries others.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

enum class Shape {
  kGeneral,
  kCoplanar,
  kNearlyCoplanar,
  kCollinear,
  kNearlyCollinear,
  kCoincident
};
enum class Pixels { kExact, kNoisy, kOutliers, kRandom, kOnePixel, kNotFinite, kHuge };
enum class Start { kFree, kTruth, kFar, kBehind };
enum class Noise { kUnknown, kSigma, kTinySigma, kHugeSigma, kCovariances };

/// A problem, and what it was made from, for the message when it fails.
struct Recipe {
  int points = 8;
  Shape shape = Shape::kGeneral;
  Pixels pixels = Pixels::kNoisy;
  Start start = Start::kFree;
  Noise noise = Noise::kUnknown;
  int scale_exponent = 0;  ///< of the unit of length, powers of ten
  double range = 20;       ///< in extents of the target; below 1 it surrounds the camera
  unsigned seed = 0;
};

std::ostream& operator<<(std::ostream& out, const Recipe& r) {
  return out << r.points << " points, shape " << static_cast<int>(r.shape) << ", pixels "
             << static_cast<int>(r.pixels) << ", start " << static_cast<int>(r.start) << ", noise "
             << static_cast<int>(r.noise) << ", scale 1e" << r.scale_exponent << ", range "
             << r.range << ", seed " << r.seed;
}

template <typename Enum>
Enum one_of(int count) {
  return static_cast<Enum>(*rc::gen::inRange(0, count));
}

Recipe draw_recipe() {
  Recipe r;
  r.points = *rc::gen::inRange(0, 13);
  r.shape = one_of<Shape>(6);
  r.pixels = one_of<Pixels>(7);
  r.start = one_of<Start>(4);
  r.noise = one_of<Noise>(5);
  r.scale_exponent = *rc::gen::element(-100, -20, -6, -3, 0, 0, 0, 3, 6, 20, 100);
  r.range = *rc::gen::element(0.3, 2.0, 10.0, 100.0, 1e4);
  r.seed = static_cast<unsigned>(*rc::gen::inRange(0, 1 << 20));
  return r;
}

Eigen::Vector3d point_of(Shape shape, Draw& draw) {
  const Eigen::Vector3d p = draw.in_box(1);
  switch (shape) {
    case Shape::kGeneral:
      return p;
    case Shape::kCoplanar:
      return {p.x(), p.y(), 0};
    case Shape::kNearlyCoplanar:
      return {p.x(), p.y(), 1e-6 * p.z()};
    case Shape::kCollinear:
      return p.x() * Eigen::Vector3d(1, 2, 3);
    case Shape::kNearlyCollinear:
      return p.x() * Eigen::Vector3d(1, 2, 3) + 1e-9 * p;
    case Shape::kCoincident:
      return {0.1, 0.2, 0.3};
  }
  return p;
}

void spoil(Pixels kind, PoseProblem& problem, Draw& draw) {
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    Eigen::Vector2d& u = problem.pixels[i];
    if (kind == Pixels::kNoisy) u += draw.pixel_noise(1);
    if (kind == Pixels::kOutliers) u += draw.pixel_noise(i % 2 ? 50 : 0.5);
    if (kind == Pixels::kRandom) u = {draw.uniform(0, 511), draw.uniform(0, 511)};
    if (kind == Pixels::kOnePixel) u = {255.5, 255.5};
    if (kind == Pixels::kHuge) u *= 1e200;
  }
  if (kind == Pixels::kNotFinite && !problem.pixels.empty()) {
    problem.pixels[draw.index(static_cast<int>(problem.pixels.size()))].x() =
        draw.index(2) ? kNaN : kInfinity;
  }
}

PoseProblem make(const Recipe& r) {
  Draw draw(r.seed);
  const double scale = std::pow(10.0, r.scale_exponent);
  PoseProblem problem;
  problem.camera = centred_camera(512, 512, 1000);
  const Pose truth = {draw.rotation(), scale * r.range * Eigen::Vector3d(0.05, -0.03, 1)};
  for (int i = 0; i < r.points; ++i) {
    problem.points_in_target.push_back(scale * point_of(r.shape, draw));
    const Eigen::Vector3d x = truth * problem.points_in_target.back();
    problem.pixels.emplace_back(1000 * x.x() / x.z() + 255.5, 1000 * x.y() / x.z() + 255.5);
  }
  spoil(r.pixels, problem, draw);
  problem.true_inliers.assign(r.points, true);
  if (r.pixels == Pixels::kOutliers) {
    for (int i = 1; i < r.points; i += 2) problem.true_inliers[i] = false;
  }
  if (r.noise == Noise::kSigma) problem.sigma_px = 1;
  if (r.noise == Noise::kTinySigma) problem.sigma_px = 1e-12;
  if (r.noise == Noise::kHugeSigma) problem.sigma_px = 1e12;
  if (r.noise == Noise::kCovariances) {
    for (int i = 0; i < r.points; ++i) {
      problem.covariances_px2.push_back(
          Eigen::Vector2d(std::pow(10, draw.uniform(-3, 3)), 1).asDiagonal());
    }
  }
  if (r.start == Start::kTruth) problem.initial_cam_from_target = truth;
  if (r.start == Start::kFar) {
    problem.initial_cam_from_target = {draw.rotation(), 3 * truth.translation};
  }
  if (r.start == Start::kBehind) {
    problem.initial_cam_from_target = {truth.rotation, -truth.translation};
  }
  return problem;
}

bool is_surely_degenerate(const Recipe& r) {
  return r.shape == Shape::kCollinear || r.shape == Shape::kCoincident;
}

/// M-estimators use every point, and only report whose weight is small: that may be most of them.
bool only_weighs(const PoseSolver& solver) {
  return solver.name == "huber" || solver.name == "huber_tukey" || solver.name == "gnc";
}

void check_estimate(const Recipe& r, const PoseProblem& problem, const PoseSolver& solver,
                    const PoseEstimate& e) {
  RC_ASSERT(bool(is_free_of_nan(e)));
  // In brackets: the macro looks at both sides of an `||` that it sees.
  RC_ASSERT((!e.covariance || e.covariance->allFinite()));
  const double probability = e.diagnosis.value_or(Diagnosis{}).removed_probability.value_or(1);
  RC_ASSERT(probability >= 0 && probability <= 1);
  RC_ASSERT(std::ranges::is_sorted(e.removed));
  RC_ASSERT(std::ranges::all_of(e.removed, [&](int i) { return i >= 0 && i < r.points; }));
  if (e.status != PoseStatus::kOk) return;
  RC_ASSERT(!is_surely_degenerate(r));
  RC_ASSERT(r.points >= (r.start == Start::kFree ? 4 : 3));
  RC_ASSERT(is_valid(e.cam_from_target));
  RC_ASSERT(only_weighs(solver) || r.points - static_cast<int>(e.removed.size()) >= 3);
  for (int i = 0; i < r.points; ++i) {
    if (std::ranges::count(e.removed, i) + std::ranges::count(e.ignored, i) > 0) continue;
    RC_ASSERT((e.cam_from_target * problem.points_in_target[i]).z() > 0);
  }
}

class EverySolverWhatever : public testing::TestWithParam<PoseSolver> {
 protected:
  static void SetUpTestSuite() { setenv("RC_PARAMS", "seed=20261122 max_success=1500", 0); }
};

INSTANTIATE_TEST_SUITE_P(Solvers, EverySolverWhatever,
                         testing::ValuesIn(pose_solvers().begin(), pose_solvers().end()),
                         [](const auto& solver) { return std::string(solver.param.name); });

TEST_P(EverySolverWhatever, ReturnsARigidPoseOrSaysWhyNot) {
  const PoseSolver& solver = GetParam();
  int ok = 0;
  EXPECT_TRUE(rc::check(std::string(solver.name), [&] {
    const Recipe recipe = draw_recipe();
    RC_LOG() << recipe << '\n';
    const PoseProblem problem = make(recipe);
    const PoseEstimate estimate = solver.solve(problem, {});
    ok += estimate.status == PoseStatus::kOk;
    check_estimate(recipe, problem, solver, estimate);
  }));
  EXPECT_GT(ok, 100);  // otherwise the recipes prove nothing
}

TEST_P(EverySolverWhatever, FindsTheTruthOfWellPosedRecipes) {
  // The negative twin of the degenerate ones.
  EXPECT_TRUE(rc::check(std::string(GetParam().name), [&] {
    Recipe recipe;
    recipe.points = *rc::gen::inRange(6, 13);
    recipe.scale_exponent = *rc::gen::element(-20, -3, 0, 3, 20);
    recipe.range = *rc::gen::element(10.0, 100.0);
    recipe.pixels = Pixels::kExact;
    recipe.noise = one_of<Noise>(2);
    recipe.seed = static_cast<unsigned>(*rc::gen::inRange(0, 1 << 20));
    RC_LOG() << recipe << '\n';
    const PoseProblem problem = make(recipe);
    const PoseEstimate estimate = GetParam().solve(problem, {});
    RC_ASSERT(estimate.status == PoseStatus::kOk);
    RC_ASSERT(estimate.removed.empty());
    for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
      const auto pixel =
          project(problem.camera, estimate.cam_from_target * problem.points_in_target[i]);
      RC_ASSERT((*pixel - problem.pixels[i]).norm() < 1e-3);
    }
  }));
}

}  // namespace
}  // namespace sightline
