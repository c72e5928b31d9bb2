// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/removal_hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "pose/pose.h"
#include "pose/reprojection.h"

namespace sightline {
namespace {

/// Turns beyond which the linear model is moved, or not trusted at all.
constexpr double kLongTurnRad = 0.02;
constexpr double kLongTurnOfSameSetRad = 0.03;
constexpr double kTooLongTurnRad = 0.1;
constexpr int kMaxMoves = 5;
/// Of the largest weight: sets below it are not fitted.
constexpr double kProbable = 1e-2;
constexpr std::size_t kMaxFitted = 5;
constexpr std::size_t kMaxFittedInNeed = 1000;
/// What is kept does not look like noise when a sum of squares as large is less probable than this.
constexpr double kTestLevel = 1e-3;
/// Squared error over the slab's: outliers beyond it, of 80 px by default, are looked at again.
constexpr double kFarBeyondSlab2 = 16;
/// Other poses this probable, and this far away, make the answer ambiguous.
constexpr double kAmbiguousShare = 0.05;
constexpr double kAmbiguousDistance2 = 22.46;  // chi-square of six degrees, 99.9 %

constexpr double kCoarseStep = 1e-3;
constexpr double kFineStep = 1e-6;
constexpr int kMaxIterations = 50;

double turn_rad(const Vector6d& delta) {
  return delta.head<3>().norm();
}

// Sets fitted without linearisation

/// None where the points kept do not determine a pose.
std::optional<RemovalHypothesis> with_finite_weight(RemovalHypothesis h) {
  h.log_weight -= 0.5 * (h.rss + kernel::log_determinant(h.model.hessian));
  return std::isfinite(h.log_weight) ? std::optional(h) : std::nullopt;
}

/// Least squares on all points.
std::optional<RemovalHypothesis> fitted(const PackedPoints& points, const Pose& start,
                                        int& iterations) {
  const kernel::Fit fit = points.fit(start, kMaxIterations, kFineStep);
  iterations += fit.iterations;
  if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
  return with_finite_weight({{}, pose_from(fit.pose), fit.model, 0, 2 * fit.model.cost});
}

/// Least squares with the removed points at the slab's weight. None where that fails.
std::optional<RemovalHypothesis> fitted(const RemovalModel& s, const PackedPoints& points,
                                        const Linearisation& linear, const RemovalSet& set,
                                        int& iterations) {
  const SetStep step = step_of(s, linear, set);
  std::array<double, kernel::kMaxRemoved> weight;
  PackedPoints weighed = points;
  for (int i = 0; i < set.size; ++i) {
    weight[i] = step.slab[i] / (1 + step.slab[i]);
    weighed.scale_weight(set.points[i], weight[i]);
  }
  std::optional<RemovalHypothesis> h =
      fitted(weighed, retract(linear.pose, step.delta), iterations);
  if (!h) h = fitted(weighed, linear.pose, iterations);
  if (!h) return std::nullopt;
  h->set = set;
  for (int i = 0; i < set.size; ++i) {
    const int point = set.points[i];
    const std::optional<Eigen::Vector2d> r = residual_px(*s.c, point, h->pose);
    if (!r) return std::nullopt;
    const double f = s.squared(point, *r);
    h->rss -= weight[i] * f;
    h->log_weight += 0.5 * weight[i] * f;
    h->log_weight += s.log_odds[point] - 2 * std::log1p(0.5 * f * s.gamma[point]);
  }
  return h;
}

std::vector<RemovalHypothesis> fit_all(const RemovalModel& s, const PackedPoints& points,
                                       const Linearisation& linear,
                                       std::span<const RemovalSet> sets, int& iterations) {
  std::vector<RemovalHypothesis> hypotheses;
  hypotheses.reserve(sets.size());
  for (const RemovalSet& set : sets) {
    const std::optional<RemovalHypothesis> h = fitted(s, points, linear, set, iterations);
    if (h) hypotheses.push_back(*h);
  }
  return hypotheses;
}

/// Of whitened residuals.
double noise_variance(const RemovalModel& s, const RemovalHypothesis& h) {
  if (s.is_sigma_known) return 1;
  return (h.rss + kPriorDegrees * kPriorSigmaPx * kPriorSigmaPx) /
         (s.degrees(h.set.size) + kPriorDegrees);
}

/// P(chi-square > x) for an even number of degrees of freedom.
double chi_square_survival(double x, int degrees) {
  constexpr int kManyDegrees = 300;
  if (degrees > kManyDegrees) {  // Wilson and Hilferty (1931)
    const double variance = 2.0 / (9.0 * degrees);
    const double z = (std::cbrt(x / degrees) - 1 + variance) / std::sqrt(variance);
    return 0.5 * std::erfc(z / std::numbers::sqrt2);
  }
  double term = std::exp(-0.5 * x);
  double sum = 0;
  for (int i = 0; i < degrees / 2; ++i) {
    sum += term;
    term *= 0.5 * x / (i + 1);
  }
  return sum;
}

/// Gives every hypothesis the weight of its set in the linear model; those that fitting led away
/// from the linear model's pose, to another minimum, have none there and are left out.
void use_linear_weights(const RemovalModel& s, const Linearisation& linear,
                        std::vector<RemovalHypothesis>& hypotheses) {
  std::erase_if(hypotheses, [&](const RemovalHypothesis& h) {
    const Pose expected = retract(linear.pose, step_of(s, linear, h.set).delta);
    return geodesic_angle_rad(expected.rotation, h.pose.rotation) > kTooLongTurnRad;
  });
  for (RemovalHypothesis& h : hypotheses) {
    const auto same =
        std::ranges::find_if(linear.sets, [&h](const WeighedSet& w) { return w.set == h.set; });
    h.log_weight = same->log_weight;
  }
}

// From one start to its hypotheses

/// The linear model where it can be trusted, its sets weighed: it moves to the pose of the heaviest
/// set as long as that is far. False when it cannot be built at the start.
bool settle(const RemovalModel& s, const PackedPoints& points, const Pose& start,
            Linearisation& linear, int& iterations) {
  if (!linearise(s, points, start, linear)) return false;
  weigh_explaining_sets(s, 0, kProbable, linear);
  for (int move = 0; move < kMaxMoves; ++move) {
    const RemovalSet set = heaviest(linear.sets).set;
    const Vector6d delta = step_of(s, linear, set).delta;
    const Pose before = linear.pose;
    Pose next = retract(before, delta);
    if (move == 0 && turn_rad(delta) > kTooLongTurnRad) {
      weigh_swept_sets(s, linear);
      const auto sets = least_residual_sets(linear.sets, s.max_removed);
      const auto hypotheses = fit_all(s, points, linear, sets, iterations);
      if (hypotheses.empty()) return true;
      next = best_of(hypotheses).pose;
    } else if (turn_rad(delta) <= kLongTurnRad) {
      return true;
    }
    if (!linearise(s, points, next, linear) && !linearise(s, points, before, linear)) return false;
    weigh_explaining_sets(s, set.size, kProbable, linear);
    const bool is_same = heaviest(linear.sets).set == set;
    if (is_same && turn_rad(delta) <= kLongTurnOfSameSetRad) return true;
  }
  return true;
}

/// The sets within a set.
std::vector<RemovalSet> proper_subsets(const RemovalSet& set) {
  std::vector<RemovalSet> subsets;
  for (unsigned chosen = 0; chosen + 1 < 1u << set.size; ++chosen) {
    RemovalSet& subset = subsets.emplace_back();
    for (int i = 0; i < set.size; ++i) {
      if (chosen >> i & 1) subset.points[subset.size++] = set.points[i];
    }
  }
  return subsets;
}

bool has_far_outlier(const RemovalModel& s, const RemovalHypothesis& h) {
  return std::ranges::any_of(h.set.span(), [&](int i) {
    const std::optional<Eigen::Vector2d> r = residual_px(*s.c, i, h.pose);
    return !r || s.squared(i, *r) * s.gamma[i] > kFarBeyondSlab2;
  });
}

/// Beside an outlier far beyond the slab the linear weights, whose slab is Gaussian, prefer sets
/// with good points in them. So the sets within the best one are fitted and weighed too.
void add_smaller_sets(const RemovalModel& s, const PackedPoints& points, Linearisation& linear,
                      RemovalBranch& branch) {
  if (!s.is_sigma_known || branch.hypotheses.empty()) return;
  if (const RemovalHypothesis& h = best_of(branch.hypotheses);
      h.set.size < 2 || !has_far_outlier(s, h)) {
    return;
  }
  const RemovalHypothesis best = best_of(branch.hypotheses);
  if (!linearise(s, points, best.pose, linear)) return;
  std::vector<RemovalSet> subsets = proper_subsets(best.set);
  std::erase_if(subsets, [&branch](const RemovalSet& subset) {
    return std::ranges::any_of(branch.hypotheses,
                               [&subset](const RemovalHypothesis& h) { return h.set == subset; });
  });
  for (RemovalHypothesis& h : fit_all(s, points, linear, subsets, branch.iterations)) {
    branch.hypotheses.push_back(h);
  }
}

// From the hypotheses of all starts to an answer

/// delta^T H delta, H by its upper triangle.
double quadratic_form(const double (&hessian)[21], const Vector6d& delta) {
  double sum = 0;
  const double* next = hessian;
  for (int i = 0; i < 6; ++i) {
    sum += *next++ * delta[i] * delta[i];
    for (int j = i + 1; j < 6; ++j) sum += 2 * *next++ * delta[i] * delta[j];
  }
  return sum;
}

/// Of the best hypotheses of two starts. Where the noise is not known, its prior would call
/// residuals far below kPriorSigmaPx equal: with the same points kept the smaller wins.
bool is_preferable(const RemovalModel& s, const RemovalHypothesis& a, const RemovalHypothesis& b) {
  if (!s.is_sigma_known && a.set == b.set) return a.rss < b.rss;
  return a.log_weight > b.log_weight;
}

}  // namespace

const RemovalHypothesis& best_of(const std::vector<RemovalHypothesis>& hypotheses) {
  return *std::max_element(hypotheses.begin(), hypotheses.end(),
                           [](const RemovalHypothesis& a, const RemovalHypothesis& b) {
                             return a.log_weight < b.log_weight;
                           });
}

bool is_explained(const RemovalModel& s, const RemovalHypothesis& h) {
  const int degrees = s.degrees(h.set.size);
  // Two deviations above the mean the survival is above kTestLevel for any number of degrees.
  if (degrees <= 0 || h.rss <= degrees + 2 * std::sqrt(2.0 * degrees)) return true;
  return chi_square_survival(h.rss, degrees) >= kTestLevel;
}

RemovalBranch removals_from(const RemovalModel& s, const PackedPoints& points, const Pose& start,
                            RemovalEffort effort, Linearisation& linear) {
  RemovalBranch branch;
  const kernel::Fit fit = points.fit(start, kMaxIterations, kCoarseStep);
  branch.iterations = fit.iterations;
  if (fit.status == kernel::FitStatus::kStartBehindCamera) {
    branch.status = PoseStatus::kBehindCamera;
    return branch;
  }
  if (s.is_sigma_known && 2 * fit.model.cost <= noise_like_rss(s.degrees(0))) {
    const auto all_kept = fitted(points, pose_from(fit.pose), branch.iterations);
    if (all_kept) branch.hypotheses.push_back(*all_kept);
    branch.status = all_kept ? PoseStatus::kOk : PoseStatus::kDiverged;
    return branch;
  }
  if (!settle(s, points, pose_from(fit.pose), linear, branch.iterations)) {
    branch.status = PoseStatus::kDegenerate;
    return branch;
  }
  branch.hypotheses = fit_all(s, points, linear, heaviest_sets(linear.sets, kMaxFitted, kProbable),
                              branch.iterations);
  add_smaller_sets(s, points, linear, branch);
  if (!s.is_sigma_known && !branch.hypotheses.empty()) {
    const RemovalHypothesis fitted_best = best_of(branch.hypotheses);
    use_linear_weights(s, linear, branch.hypotheses);
    if (branch.hypotheses.empty()) branch.hypotheses = {fitted_best};
  } else if (effort == RemovalEffort::kAll &&
             (branch.hypotheses.empty() || !is_explained(s, best_of(branch.hypotheses)))) {
    // Rare: far outliers drew the linear model to a wrong place that maintains itself.
    weigh_sets(s, s.max_removed, linear);
    branch.hypotheses = fit_all(s, points, linear, heaviest_sets(linear.sets, kMaxFittedInNeed, 0),
                                branch.iterations);
  }
  branch.status = branch.hypotheses.empty() ? PoseStatus::kDiverged : PoseStatus::kOk;
  return branch;
}

std::optional<MeanOverRemovals> mean_over_removals(std::span<const RemovalBranch> branches,
                                                   const RemovalModel& s) {
  const RemovalBranch* chosen = nullptr;
  for (const RemovalBranch& b : branches) {
    if (b.hypotheses.empty()) continue;
    if (!chosen || is_preferable(s, best_of(b.hypotheses), best_of(chosen->hypotheses))) {
      chosen = &b;
    }
  }
  const RemovalHypothesis& best = best_of(chosen->hypotheses);
  const std::optional<Matrix6d> unit_covariance = inverse_of(best.model);
  if (!unit_covariance) return std::nullopt;
  const double variance = noise_variance(s, best);
  const Matrix6d of_best = variance * *unit_covariance;
  MeanOverRemovals answer = {best, chosen, best.pose, of_best, of_best};
  if (branches.size() == 1 && chosen->hypotheses.size() == 1) return answer;

  double total = 0;
  double of_chosen = 0;
  double of_best_set = 0;
  double far = 0;
  Vector6d mean = Vector6d::Zero();
  Matrix6d squares = Matrix6d::Zero();  // about the best one
  for (const RemovalBranch& b : branches) {
    for (const RemovalHypothesis& h : b.hypotheses) {
      const double weight = std::exp(h.log_weight - best.log_weight);
      const bool is_of_best_set = h.set == best.set;
      const bool is_best = &b == chosen && is_of_best_set;
      const Vector6d delta =
          is_best ? Vector6d(Vector6d::Zero()) : change_between(best.pose, h.pose);
      // Another start may lead to the same minimum: it counts once.
      if (&b != chosen && is_of_best_set && turn_rad(delta) < kCoarseStep) continue;
      total += weight;
      if (is_of_best_set) of_best_set += weight;
      if (&b == chosen) of_chosen += weight;
      if (is_best) continue;
      if (quadratic_form(best.model.hessian, delta) > kAmbiguousDistance2 * variance) far += weight;
      if (&b != chosen) continue;
      mean += weight * delta;
      squares.noalias() += weight * delta * delta.transpose();
    }
  }
  mean /= of_chosen;
  answer.covariance /= of_chosen;
  for (const RemovalHypothesis& h : chosen->hypotheses) {
    const double share = std::exp(h.log_weight - best.log_weight) / of_chosen;
    const auto covariance = &h == &best ? std::nullopt : inverse_of(h.model);
    if (covariance) answer.covariance += share * noise_variance(s, h) * *covariance;
  }
  if (chosen->hypotheses.size() > 1) {
    answer.covariance += squares / of_chosen - mean * mean.transpose();
    answer.mean = retract(best.pose, mean);
  }
  answer.best_probability = of_best_set / total;
  answer.is_ambiguous = far > kAmbiguousShare * total;
  return answer;
}

bool has_kept_in_front(const Correspondences& c, const RemovalSet& removed, const Pose& pose) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    const bool is_removed = std::ranges::find(removed.span(), i) != removed.span().end();
    if (!is_removed && !residual_px(c, i, pose)) return false;
  }
  return true;
}

std::optional<FitOfKept> fit_kept(const RemovalModel& s, const PackedPoints& points,
                                  const RemovalHypothesis& best) {
  FitOfKept result = {best.pose, Matrix6d::Zero()};
  kernel::NormalEquations model = best.model;
  if (best.set.size > 0) {
    PackedPoints kept = points;
    for (const int i : best.set.span()) kept.scale_weight(i, 0);
    const kernel::Fit fit = kept.fit(best.pose, kMaxIterations, kFineStep);
    if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
    result.pose = pose_from(fit.pose);
    model = fit.model;
  }
  std::optional<Matrix6d> unit_covariance;
  if (s.common_variance) {
    unit_covariance = inverse_of(model);
    if (unit_covariance) *unit_covariance /= *s.common_variance;
  } else {
    std::vector<double> ones(s.c->size(), 1.0);
    for (const int i : best.set.span()) ones[i] = 0;
    const auto information = information_at(PackedPoints(*s.c, ones), result.pose);
    if (information) unit_covariance = inverse_information(*information);
  }
  if (!unit_covariance) return std::nullopt;
  result.unit_covariance = *unit_covariance;
  return result;
}

}  // namespace sightline
