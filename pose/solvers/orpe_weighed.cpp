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
// covariances_px2 (taken as those of the undistorted pixels), else sigma_px; where neither is given
// it is unknown and integrated out under a scaled inverse chi-square prior (kPriorDegrees,
// kPriorSigmaPx), and step 4 is left out: the linear weights proved better there. Uses
// OutlierOptions::probability, scale_px and max_removed; never tries more than kMaxRemoved points
// or kMaxSets sets. Nothing random; of equals the set that comes first wins.

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "pose/kernels/removal_kernel.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace {

constexpr int kMaxRemoved = kernel::kMaxRemoved;
constexpr int kDefaultMaxRemoved = 4;
constexpr std::size_t kMaxSets = 50'000;

/// Sets of k points are enough when one of them leaves no more than this times the expected sum of
/// squares.
constexpr double kNoiseLike = 1.3;
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
/// Other poses this probable, and this far away, make the answer ambiguous.
constexpr double kAmbiguousShare = 0.05;
constexpr double kAmbiguousDistance2 = 22.46;  // chi-square of six degrees, 99.9 %

/// Where the noise is not known.
constexpr double kUnknownGamma = 0.005;
constexpr double kPriorDegrees = 2;
constexpr double kPriorSigmaPx = 2;

constexpr double kCoarseStep = 1e-3;
constexpr double kFineStep = 1e-6;
constexpr int kMaxIterations = 50;

// What does not depend on the pose

struct Setting {
  const Correspondences* c = nullptr;
  bool is_sigma_known = false;
  std::vector<Eigen::Matrix2d> information;  ///< inverse covariances of inliers; unit if unknown
  std::vector<double> gamma;                 ///< noise over slab, squared
  std::vector<double> log_odds;              ///< of being an outlier, with the slab's height
  int max_removed = 0;

  int n() const { return static_cast<int>(c->size()); }
  int degrees(int removed) const { return 2 * n() - 6 - 2 * removed; }
};

/// Of 5, 8 and 12 points 1, 3 and 4; at least four points are kept.
int removal_limit(int n, const OutlierOptions& options) {
  int limit = options.max_removed ? std::min(*options.max_removed, kMaxRemoved)
                                  : std::min(3 * n / 8, kDefaultMaxRemoved);
  limit = std::clamp(n - kMinimumPosePoints, 0, std::max(limit, 0));
  while (limit > 0 && kernel::set_count(n, limit) > kMaxSets) --limit;
  return limit;
}

/// None where a covariance is not positive definite or one is missing.
std::optional<Setting> setting_of(const PoseProblem& problem, const Correspondences& c,
                                  const OutlierOptions& options) {
  const bool has_covariances = !problem.covariances_px2.empty();
  if (has_covariances && problem.covariances_px2.size() != c.size()) return std::nullopt;
  Setting s;
  s.c = &c;
  s.is_sigma_known = has_covariances || problem.sigma_px > 0;
  s.max_removed = removal_limit(s.n(), options);
  const double odds = options.probability / (1 - options.probability);
  const double slab_px2 = options.scale_px * options.scale_px;
  const double sigma_px = problem.sigma_px > 0 ? problem.sigma_px : 1;
  const Eigen::Matrix2d common = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Eigen::Matrix2d& covariance = has_covariances ? problem.covariances_px2[i] : common;
    const double det = covariance.determinant();
    if (!(covariance(0, 0) > 0 && det > 0 && std::isfinite(det))) return std::nullopt;
    s.information.push_back(covariance.inverse());
    s.gamma.push_back(s.is_sigma_known ? std::sqrt(det) / slab_px2 : kUnknownGamma);
    s.log_odds.push_back(std::log(odds * (s.is_sigma_known ? s.gamma.back() : 1 / slab_px2)));
  }
  return s;
}

// Sets of points

struct RemovalSet {
  std::array<unsigned short, kMaxRemoved> points;  ///< ascending
  int size = 0;

  std::span<const unsigned short> span() const { return {points.data(), points.data() + size}; }
  bool operator==(const RemovalSet& other) const {
    return std::ranges::equal(span(), other.span());
  }
};

/// The next in the order of kernel::sweep_sets; of the empty set the first.
RemovalSet next_set(RemovalSet set, int n, int max_size) {
  const int last = set.size > 0 ? set.points[set.size - 1] : -1;
  if (set.size < max_size && last + 1 < n) {
    set.points[set.size++] = static_cast<unsigned short>(last + 1);
    return set;
  }
  if (last + 1 >= n) --set.size;
  if (set.size > 0) ++set.points[set.size - 1];
  return set;
}

struct WeighedSet {
  RemovalSet set;
  double log_weight = 0;
  double rss = 0;  ///< of the kept points, whitened
};

/// ln weight, its part that all sets of a start have in common included: what -(RSS - Q) / 2 or the
/// unknown noise's integral, and the pose's volume, leave of the likelihood.
double log_weight(const Setting& s, const RemovalSet& set, double rss, double det, double log_det) {
  double sum = -0.5 * (std::log(det) + log_det);
  for (const int i : set.span()) sum += s.log_odds[i];
  if (s.is_sigma_known) return sum - 0.5 * rss;
  const double nu = s.degrees(set.size) + kPriorDegrees;
  const double scale = rss + kPriorDegrees * kPriorSigmaPx * kPriorSigmaPx;
  return sum + std::lgamma(0.5 * nu) - 0.5 * nu * std::log(0.5 * scale);
}

// The linear model

struct Linear {
  Pose pose;
  kernel::LinearModel model;
  std::vector<double> basis;
  std::vector<double> residuals;

  double basis_at(int k, int half, int i) const { return basis[(6 * half + k) * stride() + i]; }
  double residual_at(int half, int i) const { return residuals[half * stride() + i]; }
  std::size_t stride() const { return residuals.size() / 2; }
};

std::optional<Linear> linearise(const PackedPoints& points, const Pose& pose) {
  Linear linear;
  linear.pose = pose;
  const std::size_t stride = points.lanes().size() * kernel::kLanes;
  linear.basis.resize(12 * stride);
  linear.residuals.resize(2 * stride);
  if (!kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(pose),
                         linear.basis.data(), linear.residuals.data(), linear.model)) {
    return std::nullopt;
  }
  return linear;
}

/// All sets of up to `max_size` points, the empty one first.
std::vector<WeighedSet> weigh_sets(const Setting& s, const Linear& linear, int max_size) {
  const std::size_t n = s.c->size();
  const std::size_t count = kernel::set_count(n, max_size);
  std::vector<double> numbers(2 * count + kernel::sweep_workspace(n, max_size));
  double* const q = numbers.data();
  double* const det = q + count;
  if (max_size > 0) {
    kernel::sweep_sets(n, linear.basis.data(), linear.residuals.data(), s.gamma.data(), max_size,
                       det + count, q, det);
  }
  const double rss = linear.model.rss, log_det = linear.model.log_det;
  std::vector<WeighedSet> sets;
  sets.reserve(count + 1);
  sets.push_back({{}, log_weight(s, {}, rss, 1, log_det), rss});
  for (std::size_t i = 0; i < count; ++i) {
    const RemovalSet set = next_set(sets.back().set, s.n(), max_size);
    const double rest = std::max(rss - q[i], 0.0);
    sets.push_back({set, log_weight(s, set, rest, det[i], log_det), rest});
  }
  return sets;
}

/// Sets of as few points as leave what looks like noise, or of all sizes allowed.
std::vector<WeighedSet> sets_that_explain(const Setting& s, const Linear& linear) {
  if (!s.is_sigma_known) return weigh_sets(s, linear, s.max_removed);
  for (int k = 0;; ++k) {
    std::vector<WeighedSet> sets = weigh_sets(s, linear, k);
    if (k == s.max_removed) return sets;
    const double enough = kNoiseLike * s.degrees(k);
    for (const WeighedSet& w : sets) {
      if (w.rss <= enough) return sets;
    }
  }
}

const WeighedSet& heaviest(const std::vector<WeighedSet>& sets) {
  return *std::max_element(sets.begin(), sets.end(), [](const WeighedSet& a, const WeighedSet& b) {
    return a.log_weight < b.log_weight;
  });
}

/// What stands on the diagonal for the points of a set, and the step to its pose.
struct SetStep {
  std::array<double, kMaxRemoved> slab;  ///< Gamma: noise over slab, squared, of Student's law
  Vector6d delta;
};

/// z = (M_SS + slab)^-1 r_S, two numbers a point: the errors of the removed points.
using SetErrors = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 2 * kMaxRemoved, 1>;
using SetMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMaxRemoved, 2 * kMaxRemoved>;

SetStep step_of(const Setting& s, const Linear& linear, const RemovalSet& set) {
  const int size = set.size;
  SetStep step;
  step.delta = Eigen::Map<const Vector6d>(linear.model.step);
  if (size == 0) return step;
  SetMatrix m(2 * size, 2 * size);
  SetErrors r(2 * size);
  for (int a = 0; a < 2 * size; ++a) {
    r[a] = linear.residual_at(a % 2, set.points[a / 2]);
    for (int b = 0; b <= a; ++b) {
      double dot = a == b;
      for (int k = 0; k < 6; ++k) {
        dot -= linear.basis_at(k, a % 2, set.points[a / 2]) *
               linear.basis_at(k, b % 2, set.points[b / 2]);
      }
      m(a, b) = m(b, a) = dot;
    }
  }
  const auto errors = [&](const auto& slab) -> SetErrors {
    SetMatrix with_slab = m;
    for (int a = 0; a < 2 * size; ++a) with_slab(a, a) += slab(a / 2);
    return with_slab.llt().solve(r);
  };
  const SetErrors first = errors([&](int i) { return s.gamma[set.points[i]]; });
  for (int i = 0; i < size; ++i) {
    const double e2 = first.segment<2>(2 * i).squaredNorm();
    step.slab[i] = 4 / (2 / s.gamma[set.points[i]] + e2);
  }
  const SetErrors z = errors([&](int i) { return step.slab[i]; });
  double along[6] = {};
  for (int k = 0; k < 6; ++k) {
    for (int a = 0; a < 2 * size; ++a) {
      along[k] += linear.basis_at(k, a % 2, set.points[a / 2]) * z[a];
    }
  }
  double delta[6];
  kernel::step_along(linear.model, along, delta);
  step.delta += Eigen::Map<const Vector6d>(delta);
  return step;
}

double turn_rad(const Vector6d& delta) {
  return delta.head<3>().norm();
}

// Sets fitted without linearisation

/// One explanation of the pixels: which points are outliers, and the pose then.
struct Hypothesis {
  RemovalSet set;
  Pose pose;
  Matrix6d covariance;
  double log_weight = 0;
  double rss = 0;  ///< of the kept points, whitened
};

/// Least squares with the removed points at the slab's weight. None where that fails.
std::optional<Hypothesis> fitted(const Setting& s, const Linear& linear, const RemovalSet& set,
                                 int& iterations) {
  const SetStep step = step_of(s, linear, set);
  std::vector<Eigen::Matrix2d> weights = s.information;
  for (int i = 0; i < set.size; ++i) {
    weights[set.points[i]] *= step.slab[i] / (1 + step.slab[i]);
  }
  const PackedPoints points(*s.c, weights);
  kernel::Fit fit = points.fit(retract(linear.pose, step.delta), kMaxIterations, kFineStep);
  iterations += fit.iterations;
  if (fit.status == kernel::FitStatus::kStartBehindCamera) {
    fit = points.fit(linear.pose, kMaxIterations, kFineStep);
    iterations += fit.iterations;
  }
  if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
  const std::optional<Matrix6d> covariance = inverse_of(fit.model);
  if (!covariance) return std::nullopt;

  Hypothesis h = {set, pose_from(fit.pose), *covariance, 0, 0};
  std::size_t next = 0;
  const std::span<const unsigned short> removed = set.span();
  for (std::size_t i = 0; i < s.c->size(); ++i) {
    const std::optional<Eigen::Vector2d> r = residual_px(*s.c, i, h.pose);
    if (!r) return std::nullopt;
    const double f = r->dot(s.information[i] * *r);
    if (next < removed.size() && removed[next] == i) {
      h.log_weight += s.log_odds[i] - 2 * std::log1p(0.5 * f * s.gamma[i]);
      ++next;
    } else {
      h.rss += f;
    }
  }
  h.log_weight -= 0.5 * h.rss + 0.5 * kernel::log_determinant(fit.model.hessian);
  return h;
}

std::vector<Hypothesis> fit_all(const Setting& s, const Linear& linear,
                                std::span<const RemovalSet> sets, int& iterations) {
  std::vector<Hypothesis> hypotheses;
  for (const RemovalSet& set : sets) {
    std::optional<Hypothesis> h = fitted(s, linear, set, iterations);
    if (h) hypotheses.push_back(std::move(*h));
  }
  return hypotheses;
}

const Hypothesis& best_of(const std::vector<Hypothesis>& hypotheses) {
  return *std::max_element(
      hypotheses.begin(), hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight < b.log_weight; });
}

/// The heaviest sets, at most `count`, none below `least` of the heaviest.
std::vector<RemovalSet> heaviest_sets(std::vector<WeighedSet> sets, std::size_t count,
                                      double least) {
  const double least_log = heaviest(sets).log_weight + std::log(least);
  std::erase_if(sets, [=](const WeighedSet& w) { return !(w.log_weight >= least_log); });
  std::stable_sort(sets.begin(), sets.end(), [](const WeighedSet& a, const WeighedSet& b) {
    return a.log_weight > b.log_weight;
  });
  std::vector<RemovalSet> chosen;
  for (const WeighedSet& w : sets) {
    if (chosen.size() < count) chosen.push_back(w.set);
  }
  return chosen;
}

/// For each size the two sets that leave the least.
std::vector<RemovalSet> least_residual_sets(const std::vector<WeighedSet>& all, int max_size) {
  std::vector<RemovalSet> chosen;
  for (int size = 0; size <= max_size; ++size) {
    std::vector<WeighedSet> of_size;
    for (const WeighedSet& w : all) {
      if (w.set.size == size) of_size.push_back(w);
    }
    std::stable_sort(of_size.begin(), of_size.end(),
                     [](const WeighedSet& a, const WeighedSet& b) { return a.rss < b.rss; });
    for (std::size_t i = 0; i < std::min<std::size_t>(2, of_size.size()); ++i) {
      chosen.push_back(of_size[i].set);
    }
  }
  return chosen;
}

/// Of whitened residuals.
double noise_variance(const Setting& s, const Hypothesis& h) {
  if (s.is_sigma_known) return 1;
  return (h.rss + kPriorDegrees * kPriorSigmaPx * kPriorSigmaPx) /
         (s.degrees(h.set.size) + kPriorDegrees);
}

/// P(chi-square > x) for an even number of degrees of freedom.
double chi_square_survival(double x, int degrees) {
  double term = std::exp(-0.5 * x);
  double sum = 0;
  for (int i = 0; i < degrees / 2; ++i) {
    sum += term;
    term *= 0.5 * x / (i + 1);
  }
  return sum;
}

/// Whether what a hypothesis keeps looks like noise.
bool is_explained(const Setting& s, const Hypothesis& h) {
  const int degrees = s.degrees(h.set.size);
  return degrees <= 0 || chi_square_survival(h.rss, degrees) >= kTestLevel;
}

void use_linear_weights(const std::vector<WeighedSet>& sets, std::vector<Hypothesis>& hypotheses) {
  for (Hypothesis& h : hypotheses) {
    const auto same =
        std::ranges::find_if(sets, [&h](const WeighedSet& w) { return w.set == h.set; });
    h.log_weight = same->log_weight;
  }
}

// From one start to its hypotheses

struct Branch {
  PoseStatus status = PoseStatus::kDiverged;
  std::vector<Hypothesis> hypotheses;
  int iterations = 0;
};

/// The linear model where it can be trusted: it moves to the pose of the heaviest set as long as
/// that is far.
struct Settled {
  Linear linear;
  std::vector<WeighedSet> sets;
};

std::optional<Settled> settle(const Setting& s, const PackedPoints& points, const Pose& start,
                              int& iterations) {
  std::optional<Linear> linear = linearise(points, start);
  if (!linear) return std::nullopt;
  Settled settled = {std::move(*linear), {}};
  settled.sets = sets_that_explain(s, settled.linear);
  for (int move = 0; move < kMaxMoves; ++move) {
    const RemovalSet set = heaviest(settled.sets).set;
    const Vector6d delta = step_of(s, settled.linear, set).delta;
    Pose next = retract(settled.linear.pose, delta);
    if (move == 0 && turn_rad(delta) > kTooLongTurnRad) {
      const auto hypotheses =
          fit_all(s, settled.linear, least_residual_sets(settled.sets, s.max_removed), iterations);
      if (hypotheses.empty()) return settled;
      next = best_of(hypotheses).pose;
    } else if (turn_rad(delta) <= kLongTurnRad) {
      return settled;
    }
    linear = linearise(points, next);
    if (!linear) return settled;
    settled.linear = std::move(*linear);
    settled.sets = sets_that_explain(s, settled.linear);
    const bool is_same = heaviest(settled.sets).set == set;
    if (is_same && turn_rad(delta) <= kLongTurnOfSameSetRad) return settled;
  }
  return settled;
}

Branch solve_branch(const Setting& s, const PackedPoints& points, const Pose& start) {
  Branch branch;
  const kernel::Fit fit = points.fit(start, kMaxIterations, kCoarseStep);
  branch.iterations = fit.iterations;
  if (fit.status == kernel::FitStatus::kStartBehindCamera) {
    branch.status = PoseStatus::kBehindCamera;
    return branch;
  }
  const auto settled = settle(s, points, pose_from(fit.pose), branch.iterations);
  if (!settled) {
    branch.status = PoseStatus::kDegenerate;
    return branch;
  }
  branch.hypotheses = fit_all(
      s, settled->linear, heaviest_sets(settled->sets, kMaxFitted, kProbable), branch.iterations);
  if (!s.is_sigma_known) {
    use_linear_weights(settled->sets, branch.hypotheses);
  } else if (branch.hypotheses.empty() || !is_explained(s, best_of(branch.hypotheses))) {
    // Rare: far outliers drew the linear model to a wrong place that maintains itself.
    branch.hypotheses =
        fit_all(s, settled->linear,
                heaviest_sets(weigh_sets(s, settled->linear, s.max_removed), kMaxFittedInNeed, 0),
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

struct Answer {
  Hypothesis best;
  Pose mean;
  Matrix6d covariance;
  double best_probability = 1;
  bool is_ambiguous = false;
};

/// The mean is over the hypotheses of the best one's start: between mirror poses lies no pose.
Answer answer_of(const std::vector<Branch>& branches, const Setting& s) {
  const Branch* chosen = nullptr;
  for (const Branch& b : branches) {
    if (b.hypotheses.empty()) continue;
    if (!chosen || best_of(b.hypotheses).log_weight > best_of(chosen->hypotheses).log_weight) {
      chosen = &b;
    }
  }
  Answer answer = {best_of(chosen->hypotheses), {}, Matrix6d::Zero(), 1, false};
  const Hypothesis& best = answer.best;
  const double variance = noise_variance(s, best);
  const Matrix6d information_of_best = best.covariance.inverse() / variance;

  double total = 0, of_chosen = 0, of_best = 0, far = 0;
  Vector6d mean = Vector6d::Zero();
  for (const Branch& b : branches) {
    for (const Hypothesis& h : b.hypotheses) {
      const double weight = std::exp(h.log_weight - best.log_weight);
      const Vector6d delta = difference(best.pose, h.pose);
      total += weight;
      if (h.set == best.set && &b == chosen) of_best += weight;
      if (delta.dot(information_of_best * delta) > kAmbiguousDistance2) far += weight;
      if (&b != chosen) continue;
      of_chosen += weight;
      mean += weight * delta;
    }
  }
  mean /= of_chosen;
  for (const Hypothesis& h : chosen->hypotheses) {
    const double share = std::exp(h.log_weight - best.log_weight) / of_chosen;
    const Vector6d off = difference(best.pose, h.pose) - mean;
    answer.covariance += share * (noise_variance(s, h) * h.covariance + off * off.transpose());
  }
  answer.mean = retract(best.pose, mean);
  answer.best_probability = of_best / total;
  answer.is_ambiguous = far > kAmbiguousShare * total;
  return answer;
}

bool has_kept_in_front(const Correspondences& c, const RemovalSet& removed, const Pose& pose) {
  for (std::size_t i = 0; i < c.size(); ++i) {
    const bool is_removed = std::ranges::count(removed.span(), i) > 0;
    if (!is_removed && !residual_px(c, i, pose)) return false;
  }
  return true;
}

struct MostProbable {
  Pose pose;
  Matrix6d unit_covariance;
};

/// Least squares on exactly the points that a hypothesis keeps.
std::optional<MostProbable> fit_kept(const Setting& s, const Hypothesis& best,
                                     const LspeOptions& options) {
  std::vector<Eigen::Matrix2d> weights = s.information;
  std::vector<double> ones(s.c->size(), 1.0);
  for (const int i : best.set.span()) {
    weights[i].setZero();
    ones[i] = 0;
  }
  const kernel::Fit fit =
      PackedPoints(*s.c, weights).fit(best.pose, options.max_iterations, options.step_tolerance);
  if (fit.status != kernel::FitStatus::kConverged) return std::nullopt;
  const PackedPoints unit(*s.c, ones);
  kernel::NormalEquations model;
  if (!kernel::normal_equations(unit.lanes().data(), unit.lanes().size(), fit.pose, model)) {
    return std::nullopt;
  }
  const std::optional<Matrix6d> unit_covariance = inverse_of(model);
  if (!unit_covariance) return std::nullopt;
  return MostProbable{pose_from(fit.pose), *unit_covariance};
}

}  // namespace

PoseEstimate solve_orpe_weighed(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const Correspondences& c = prepared.correspondences;
  const std::optional<Setting> setting = setting_of(problem, c, options.outliers);
  estimate.status = PoseStatus::kDegenerate;
  if (!setting) return estimate;
  const Setting& s = *setting;

  const PackedPoints points(c, s.information);
  std::vector<Branch> branches;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    branches.push_back(solve_branch(s, points, start));
    estimate.status = branches.back().status;
    estimate.iterations += branches.back().iterations;
  }
  const bool is_any =
      std::ranges::any_of(branches, [](const Branch& b) { return b.status == PoseStatus::kOk; });
  if (!is_any) return estimate;

  const Answer answer = answer_of(branches, s);
  const RemovalSet& removed = answer.best.set;
  const std::optional<MostProbable> most_probable = fit_kept(s, answer.best, options.lspe);
  if (!most_probable) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  const bool is_mean_usable = has_kept_in_front(c, removed, answer.mean);
  const Pose& pose = is_mean_usable ? answer.mean : most_probable->pose;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = from_centred(pose, c);
  estimate.most_probable_cam_from_target = from_centred(most_probable->pose, c);
  estimate.removed.assign(removed.span().begin(), removed.span().end());
  estimate.unit_covariance = covariance_from_centred(most_probable->unit_covariance, pose, c);
  estimate.covariance = covariance_from_centred(answer.covariance, pose, c);
  estimate.removed_probability = answer.best_probability;
  estimate.is_ambiguous = answer.is_ambiguous;
  estimate.is_removal_limit_reached = s.max_removed > 0 && removed.size == s.max_removed;
  estimate.is_test_failed = s.is_sigma_known && !is_explained(s, answer.best);
  return estimate;
}

}  // namespace sightline
