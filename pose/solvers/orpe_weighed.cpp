// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Removal sets weighed: every small set S of points is tried as the set of outliers, in closed form
// on the linearised problem, and the poses are weighed by how probable their sets are.
//
// The model: an inlier errs by Gaussian noise of known (or common, unknown) size; a point is an
// outlier with probability p (odds o = p / (1 - p)), and then errs by the noise and a broad slab of
// scale tau. With whitened rows, J the Jacobian of all points, H = J^T J, M = I - J H^-1 J^T, r the
// residuals of least squares, and gamma = sigma^2 / tau^2 for each point,
//
//   Q_S = r_S^T (M_SS + gamma I)^-1 r_S,   D_S = det (M_SS + gamma I),
//   ln w_S = Q_S / 2 + sum_S ln (o gamma) - ln D_S / 2
//
// is exactly the Bayes factor of "S has the variance of noise and slab", the pose integrated out,
// and the pose of S is that of least squares plus H^-1 J_S^T (M_SS + Gamma)^-1 r_S. All sets of up
// to k points come from one depth-first sweep with 2x2 pivots (M_SS is a Schur complement).
//
//   1. Least squares on all points, from every start.
//   2. The linear model there; k = 0, 1, ... until some set leaves residuals that look like noise.
//   3. Move to the pose of the most probable set and repeat while the move is too long for the
//      linear model.
//   4. The few probable sets are fitted and weighed without linearisation, the slab being Student's
//      with two degrees of freedom (far outliers lose all influence).
//   5. The pose is the mean of the sets' poses, weighed; `removed` is the most probable set.
//
// This is ours, in the spirit of ORPE (Zhao et al. 2009, which removes one point at a time by a
// threshold) and of Bayesian outlier models (Box and Tiao 1968).
//
// Needs four points that are not collinear, or three with an initial pose. The noise is that of
// covariances_px2, else sigma_px; where neither is given it is unknown and integrated out under a
// scaled inverse chi-square prior (kPriorDegrees, kPriorSigmaPx), and the weights stay those of the
// linear model, which proved better there. Uses OutlierOptions::probability, scale_px (the slab is
// round in whitened units, of that geometric mean) and max_removed, but not LspeOptions. Made for
// few points: by default 1, 3 and 4 of 5, 8 and 12 points may be outliers, and as no more than 50
// 000 sets are tried (pose/removal_sets.cpp), 3, 2 and 1 of more than 33, 66 and 315; what they
// leave is then flagged. Nothing random; of equals the set that comes first wins.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "pose/packed_points.h"
#include "pose/removal_sets.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

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

/// One explanation of the pixels: which points are outliers, and the pose then.
struct Hypothesis {
  RemovalSet set;
  Pose pose;
  kernel::NormalEquations model;  ///< whitened, removed points at the slab's weight
  double log_weight = 0;
  double rss = 0;  ///< of the kept points, whitened
};

/// None where the points kept do not determine a pose.
std::optional<Hypothesis> with_finite_weight(Hypothesis h) {
  h.log_weight -= 0.5 * (h.rss + kernel::log_determinant(h.model.hessian));
  return std::isfinite(h.log_weight) ? std::optional(h) : std::nullopt;
}

/// Least squares on all points.
std::optional<Hypothesis> fitted(const PackedPoints& points, const Pose& start, int& iterations) {
  const kernel::Fit fit = points.fit(start, kMaxIterations, kFineStep);
  iterations += fit.iterations;
  if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
  return with_finite_weight({{}, pose_from(fit.pose), fit.model, 0, 2 * fit.model.cost});
}

/// Least squares with the removed points at the slab's weight. None where that fails.
std::optional<Hypothesis> fitted(const OutlierModel& s, const PackedPoints& points,
                                 const Linearisation& linear, const RemovalSet& set,
                                 int& iterations) {
  const SetStep step = step_of(s, linear, set);
  std::array<double, kernel::kMaxRemoved> weight;
  PackedPoints weighed = points;
  for (int i = 0; i < set.size; ++i) {
    weight[i] = step.slab[i] / (1 + step.slab[i]);
    weighed.scale_weight(set.points[i], weight[i]);
  }
  std::optional<Hypothesis> h = fitted(weighed, retract(linear.pose, step.delta), iterations);
  if (!h) h = fitted(weighed, linear.pose, iterations);
  if (!h) return std::nullopt;
  h->set = set;
  for (int i = 0; i < set.size; ++i) {
    const PointPrior& prior = s.points[set.points[i]];
    const std::optional<Eigen::Vector2d> r = residual_px(*s.c, set.points[i], h->pose);
    if (!r) return std::nullopt;
    const double f = r->dot(prior.information * *r);
    h->rss -= weight[i] * f;
    h->log_weight += 0.5 * weight[i] * f;
    h->log_weight += prior.log_odds - 2 * std::log1p(0.5 * f * prior.gamma);
  }
  return h;
}

std::vector<Hypothesis> fit_all(const OutlierModel& s, const PackedPoints& points,
                                const Linearisation& linear, std::span<const RemovalSet> sets,
                                int& iterations) {
  std::vector<Hypothesis> hypotheses;
  for (const RemovalSet& set : sets) {
    const std::optional<Hypothesis> h = fitted(s, points, linear, set, iterations);
    if (h) hypotheses.push_back(*h);
  }
  return hypotheses;
}

const Hypothesis& best_of(const std::vector<Hypothesis>& hypotheses) {
  return *std::max_element(
      hypotheses.begin(), hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight < b.log_weight; });
}

/// Of whitened residuals.
double noise_variance(const OutlierModel& s, const Hypothesis& h) {
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

/// Whether what a hypothesis keeps looks like noise.
bool is_explained(const OutlierModel& s, const Hypothesis& h) {
  const int degrees = s.degrees(h.set.size);
  return degrees <= 0 || chi_square_survival(h.rss, degrees) >= kTestLevel;
}

/// Gives every hypothesis the weight of its set in the linear model; those that fitting led away
/// from the linear model's pose, to another minimum, have none there and are left out.
void use_linear_weights(const OutlierModel& s, const Linearisation& linear,
                        std::vector<Hypothesis>& hypotheses) {
  std::erase_if(hypotheses, [&](const Hypothesis& h) {
    const Pose expected = retract(linear.pose, step_of(s, linear, h.set).delta);
    return geodesic_angle_rad(expected.rotation, h.pose.rotation) > kTooLongTurnRad;
  });
  for (Hypothesis& h : hypotheses) {
    const auto same =
        std::ranges::find_if(linear.sets, [&h](const WeighedSet& w) { return w.set == h.set; });
    h.log_weight = same->log_weight;
  }
}

// From one start to its hypotheses

struct Branch {
  PoseStatus status = PoseStatus::kDiverged;
  std::vector<Hypothesis> hypotheses;
  int iterations = 0;
};

/// The linear model where it can be trusted, its sets weighed: it moves to the pose of the heaviest
/// set as long as that is far. False when it cannot be built at the start.
bool settle(const OutlierModel& s, const PackedPoints& points, const Pose& start,
            Linearisation& linear, int& iterations) {
  if (!linearise(points, start, linear)) return false;
  weigh_explaining_sets(s, linear);
  for (int move = 0; move < kMaxMoves; ++move) {
    const RemovalSet set = heaviest(linear.sets).set;
    const Vector6d delta = step_of(s, linear, set).delta;
    const Pose before = linear.pose;
    Pose next = retract(before, delta);
    if (move == 0 && turn_rad(delta) > kTooLongTurnRad) {
      const auto sets = least_residual_sets(linear.sets, s.max_removed);
      const auto hypotheses = fit_all(s, points, linear, sets, iterations);
      if (hypotheses.empty()) return true;
      next = best_of(hypotheses).pose;
    } else if (turn_rad(delta) <= kLongTurnRad) {
      return true;
    }
    if (!linearise(points, next, linear) && !linearise(points, before, linear)) return false;
    weigh_explaining_sets(s, linear);
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

bool has_far_outlier(const OutlierModel& s, const Hypothesis& h) {
  return std::ranges::any_of(h.set.span(), [&](int i) {
    const std::optional<Eigen::Vector2d> r = residual_px(*s.c, i, h.pose);
    return !r || r->dot(s.points[i].information * *r) * s.points[i].gamma > kFarBeyondSlab2;
  });
}

/// Beside an outlier far beyond the slab the linear weights, whose slab is Gaussian, prefer sets
/// with good points in them. So the sets within the best one are fitted and weighed too.
void add_smaller_sets(const OutlierModel& s, const PackedPoints& points, Linearisation& linear,
                      Branch& branch) {
  if (!s.is_sigma_known || branch.hypotheses.empty()) return;
  const Hypothesis best = best_of(branch.hypotheses);
  if (best.set.size < 2 || !has_far_outlier(s, best)) return;
  if (!linearise(points, best.pose, linear)) return;
  std::vector<RemovalSet> subsets = proper_subsets(best.set);
  std::erase_if(subsets, [&branch](const RemovalSet& subset) {
    return std::ranges::any_of(branch.hypotheses,
                               [&subset](const Hypothesis& h) { return h.set == subset; });
  });
  for (Hypothesis& h : fit_all(s, points, linear, subsets, branch.iterations)) {
    branch.hypotheses.push_back(h);
  }
}

Branch solve_branch(const OutlierModel& s, const PackedPoints& points, const Pose& start,
                    Linearisation& linear) {
  Branch branch;
  const kernel::Fit fit = points.fit(start, kMaxIterations, kCoarseStep);
  branch.iterations = fit.iterations;
  if (fit.status == kernel::FitStatus::kStartBehindCamera) {
    branch.status = PoseStatus::kBehindCamera;
    return branch;
  }
  if (s.is_sigma_known && 2 * fit.model.cost <= noise_like_rss(s.degrees(0))) {
    const auto all_kept = fitted(points, pose_from(fit.pose), branch.iterations);
    if (all_kept) branch.hypotheses = {*all_kept};
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
    const Hypothesis fitted_best = best_of(branch.hypotheses);
    use_linear_weights(s, linear, branch.hypotheses);
    if (branch.hypotheses.empty()) branch.hypotheses = {fitted_best};
  } else if (branch.hypotheses.empty() || !is_explained(s, best_of(branch.hypotheses))) {
    // Rare: far outliers drew the linear model to a wrong place that maintains itself.
    weigh_sets(s, s.max_removed, linear);
    branch.hypotheses = fit_all(s, points, linear, heaviest_sets(linear.sets, kMaxFittedInNeed, 0),
                                branch.iterations);
  }
  branch.status = branch.hypotheses.empty() ? PoseStatus::kDiverged : PoseStatus::kOk;
  return branch;
}

// From the hypotheses of all starts to an answer

/// (w, dt) from one pose to another.
Vector6d difference(const Pose& from, const Pose& to) {
  Vector6d delta;
  delta << vector_from_rotation(to.rotation * from.rotation.transpose()),
      to.translation - from.translation;
  return delta;
}

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
bool is_preferable(const OutlierModel& s, const Hypothesis& a, const Hypothesis& b) {
  if (!s.is_sigma_known && a.set == b.set) return a.rss < b.rss;
  return a.log_weight > b.log_weight;
}

struct Answer {
  Hypothesis best;
  Pose mean;
  Matrix6d covariance;
  double best_probability = 1;
  bool is_ambiguous = false;
};

/// None where the best hypothesis leaves the pose undetermined. The mean is over the hypotheses of
/// the best one's start: between mirror poses lies no pose.
std::optional<Answer> answer_of(const std::vector<Branch>& branches, const OutlierModel& s) {
  const Branch* chosen = nullptr;
  for (const Branch& b : branches) {
    if (b.hypotheses.empty()) continue;
    if (!chosen || is_preferable(s, best_of(b.hypotheses), best_of(chosen->hypotheses))) {
      chosen = &b;
    }
  }
  const Hypothesis& best = best_of(chosen->hypotheses);
  Answer answer = {best, best.pose, Matrix6d::Zero(), 1, false};
  const double variance = noise_variance(s, best);

  double total = 0;
  double of_chosen = 0;
  double of_best = 0;
  double far = 0;
  Vector6d mean = Vector6d::Zero();
  for (const Branch& b : branches) {
    for (const Hypothesis& h : b.hypotheses) {
      const double weight = std::exp(h.log_weight - best.log_weight);
      const Vector6d delta = difference(best.pose, h.pose);
      const bool is_of_best_set = h.set == best.set;
      // Another start may lead to the same minimum: it counts once.
      if (&b != chosen && is_of_best_set && turn_rad(delta) < kCoarseStep) continue;
      total += weight;
      if (is_of_best_set) of_best += weight;
      if (&b == chosen) of_chosen += weight;
      if (&b == chosen && is_of_best_set) continue;
      if (quadratic_form(best.model.hessian, delta) > kAmbiguousDistance2 * variance) far += weight;
      if (&b == chosen) mean += weight * delta;
    }
  }
  mean /= of_chosen;
  for (const Hypothesis& h : chosen->hypotheses) {
    const double share = std::exp(h.log_weight - best.log_weight) / of_chosen;
    const std::optional<Matrix6d> covariance = inverse_of(h.model);
    if (!covariance && &h == &best) return std::nullopt;
    if (!covariance) continue;
    answer.covariance += share * noise_variance(s, h) * *covariance;
    if (chosen->hypotheses.size() == 1) break;
    const Vector6d off = difference(best.pose, h.pose) - mean;
    answer.covariance += share * off * off.transpose();
  }
  if (chosen->hypotheses.size() > 1) answer.mean = retract(best.pose, mean);
  answer.best_probability = of_best / total;
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

struct MostProbable {
  Pose pose;
  Matrix6d unit_covariance;
};

/// Least squares on exactly the points that a hypothesis keeps.
std::optional<MostProbable> fit_kept(const OutlierModel& s, const PackedPoints& points,
                                     const Hypothesis& best) {
  MostProbable result = {best.pose, Matrix6d::Zero()};
  if (best.set.size > 0) {
    PackedPoints kept = points;
    for (const int i : best.set.span()) kept.scale_weight(i, 0);
    const kernel::Fit fit = kept.fit(best.pose, kMaxIterations, kFineStep);
    if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
    result.pose = pose_from(fit.pose);
  }
  std::vector<double> ones(s.c->size(), 1.0);
  for (const int i : best.set.span()) ones[i] = 0;
  const std::optional<Matrix6d> information = information_at(PackedPoints(*s.c, ones), result.pose);
  if (!information) return std::nullopt;
  const std::optional<Matrix6d> unit_covariance = inverse_information(*information);
  if (!unit_covariance) return std::nullopt;
  result.unit_covariance = *unit_covariance;
  return result;
}

}  // namespace

PoseEstimate solve_orpe_weighed(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedWhitened prepared = prepare_whitened(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const OutlierModel s = outlier_model(prepared.correspondences, options.outliers);
  const Correspondences& c = *s.c;
  estimate.status = PoseStatus::kDegenerate;

  const PackedPoints points = packed(s);
  Linearisation linear;
  std::vector<Branch> branches;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    branches.push_back(solve_branch(s, points, start, linear));
    estimate.status = branches.back().status;
    estimate.iterations += branches.back().iterations;
  }
  const bool is_any =
      std::ranges::any_of(branches, [](const Branch& b) { return b.status == PoseStatus::kOk; });
  if (!is_any) return estimate;

  estimate.status = PoseStatus::kDegenerate;
  const std::optional<Answer> answer = answer_of(branches, s);
  if (!answer) return estimate;
  const RemovalSet& removed = answer->best.set;
  const std::optional<MostProbable> most_probable = fit_kept(s, points, answer->best);
  if (!most_probable) return estimate;
  const bool is_mean_usable = has_kept_in_front(c, removed, answer->mean);
  const Pose& pose = is_mean_usable ? answer->mean : most_probable->pose;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = from_centred(pose, c);
  estimate.removed.assign(removed.span().begin(), removed.span().end());
  estimate.unit_covariance = covariance_from_centred(most_probable->unit_covariance, pose, c);
  estimate.covariance = covariance_from_centred(answer->covariance, pose, c);
  Diagnosis& diagnosis = estimate.diagnosis.emplace();
  diagnosis.is_ambiguous = answer->is_ambiguous;
  diagnosis.removed_probability = answer->best_probability;
  diagnosis.is_removal_limit_reached = s.max_removed > 0 && removed.size == s.max_removed;
  if (s.is_sigma_known) diagnosis.is_test_failed = !is_explained(s, answer->best);
  diagnosis.most_probable_cam_from_target = from_centred(most_probable->pose, c);
  return estimate;
}

}  // namespace sightline
