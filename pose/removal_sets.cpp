// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/removal_sets.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace sightline {
namespace {

constexpr int kMaxRemoved = kernel::kMaxRemoved;
constexpr int kDefaultMaxRemoved = 4;
constexpr std::size_t kMaxSets = 50'000;

/// Where the noise is not known.
constexpr double kUnknownGamma = 0.005;

/// Of 5, 8 and 12 points 1, 3 and 4; at least four points are kept.
int own_removal_limit(int n, const OutlierOptions& options) {
  int limit = options.max_removed ? std::min(*options.max_removed, kMaxRemoved)
                                  : std::min(3 * n / 8, kDefaultMaxRemoved);
  limit = std::clamp(n - kMinimumPosePoints, 0, std::max(limit, 0));
  while (limit > 0 && kernel::set_count(n, limit) > kMaxSets) --limit;
  return limit;
}

/// `information`: the inverse covariance of an inlier.
PointPrior prior_of(const Eigen::Matrix2d& information, bool is_sigma_known,
                    const OutlierOptions& options) {
  constexpr double kLeastProbability = 1e-9;
  constexpr double kLeastScalePx = 1e-12;  // in any unit
  constexpr double kLargestScalePx = 1e9;
  // Not std::clamp: what is no number must become one.
  const double probability = options.probability > kLeastProbability
                                 ? std::min(options.probability, 1 - kLeastProbability)
                                 : kLeastProbability;
  const double odds = probability / (1 - probability);
  const double scale_px = options.scale_px > kLeastScalePx
                              ? std::min(options.scale_px, kLargestScalePx)
                              : kLeastScalePx;
  const double slab_px2 = scale_px * scale_px;
  PointPrior prior;
  prior.information = information;
  prior.gamma =
      is_sigma_known ? 1 / (slab_px2 * std::sqrt(information.determinant())) : kUnknownGamma;
  prior.log_odds = std::log(odds * (is_sigma_known ? prior.gamma : 1 / slab_px2));
  return prior;
}

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

/// ln of the integral over the noise of what sets of one size leave; what depends on the size alone
/// is computed once.
struct SizeWeight {
  double constant = 0;
  double half_nu = 0;
};

std::array<SizeWeight, kMaxRemoved + 1> size_weights(const RemovalModel& s, int max_size) {
  std::array<SizeWeight, kMaxRemoved + 1> weights;
  if (s.is_sigma_known) return weights;
  for (int size = 0; size <= max_size; ++size) {
    weights[size].half_nu = 0.5 * (s.degrees(size) + kPriorDegrees);
    weights[size].constant = std::lgamma(weights[size].half_nu);
  }
  return weights;
}

/// q of every set of up to `max_size` points, then det of each; both begin with the empty set.
std::span<const double> sweep(const RemovalModel& s, int max_size, Linearisation& linear) {
  const std::size_t n = s.c->size();
  const std::size_t count = kernel::set_count(n, max_size) + 1;
  linear.sweep.resize(2 * count + kernel::sweep_workspace(n, max_size));
  double* const q = linear.sweep.data();
  double* const det = q + count;
  q[0] = 0;
  det[0] = 1;
  if (max_size > 0) {
    kernel::sweep_sets(n, linear.basis.data(), linear.residuals.data(), s.gamma.data(), max_size,
                       det + count, q + 1, det + 1);
  }
  return {q, 2 * count};
}

/// A symmetric system of a few unknowns, solved in place. Positive definite by what is added to its
/// diagonal.
struct SmallSystem {
  static constexpr int kMax = 2 * kMaxRemoved;

  int size = 0;
  std::array<std::array<double, kMax>, kMax> m;  ///< lower triangle
  std::array<double, kMax> r;

  /// The solution with slab[i / 2] added to the diagonal (Cholesky).
  std::array<double, kMax> solved(const std::array<double, kMaxRemoved>& slab) const {
    std::array<std::array<double, kMax>, kMax> l;
    std::array<double, kMax> x;
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = m[i][j] + (i == j ? slab[i / 2] : 0.0);
        for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
        l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
      }
      double sum = r[i];
      for (int k = 0; k < i; ++k) sum -= l[i][k] * x[k];
      x[i] = sum / l[i][i];
    }
    for (int i = size - 1; i >= 0; --i) {
      for (int k = i + 1; k < size; ++k) x[i] -= l[k][i] * x[k];
      x[i] /= l[i][i];
    }
    return x;
  }
};

/// From what sweep() gave.
void weigh_swept_sets(const RemovalModel& s, int max_size, std::span<const double> q_then_det,
                      Linearisation& linear) {
  const std::size_t count = q_then_det.size() / 2;
  const auto by_size = size_weights(s, max_size);
  const double prior_sum = kPriorDegrees * kPriorSigmaPx * kPriorSigmaPx;
  linear.sets.resize(count);
  RemovalSet set;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) set = next_set(set, s.n(), max_size);
    WeighedSet& w = linear.sets[i];
    w.set = set;
    w.rss = std::max(linear.model.rss - q_then_det[i], 0.0);
    w.log_weight = -0.5 * (std::log(q_then_det[count + i]) + linear.model.log_det);
    for (const int point : set.span()) w.log_weight += s.points[point].log_odds;
    const SizeWeight& of_size = by_size[set.size];
    w.log_weight += s.is_sigma_known
                        ? -0.5 * w.rss
                        : of_size.constant - of_size.half_nu * std::log(0.5 * (w.rss + prior_sum));
  }
}

}  // namespace

RemovalModel removal_model(const WhitenedCorrespondences& c, const OutlierOptions& options) {
  RemovalModel s;
  s.c = &c.points;
  s.is_sigma_known = c.sigma > 0;
  s.max_removed = own_removal_limit(s.n(), options);
  const double variance = s.is_sigma_known ? c.sigma * c.sigma : 1;
  const Eigen::Matrix2d common = Eigen::Matrix2d::Identity() / variance;
  s.points.assign(c.size(), prior_of(common, s.is_sigma_known, options));
  for (std::size_t i = 0; i < c.whitening.size(); ++i) {
    s.points[i] = prior_of(c.whitening[i].transpose() * c.whitening[i], true, options);
  }
  for (const PointPrior& prior : s.points) s.gamma.push_back(prior.gamma);
  return s;
}

PackedPoints packed(const RemovalModel& s) {
  std::vector<Eigen::Matrix2d> weights;
  weights.reserve(s.points.size());
  for (const PointPrior& prior : s.points) weights.push_back(prior.information);
  return PackedPoints(*s.c, weights);
}

bool linearise(const PackedPoints& points, const Pose& pose, Linearisation& linear) {
  linear.pose = pose;
  linear.stride = points.lanes().size() * kernel::kLanes;
  linear.basis.resize(12 * linear.stride);
  linear.residuals.resize(2 * linear.stride);
  return kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(pose),
                           linear.basis.data(), linear.residuals.data(), linear.model);
}

void weigh_sets(const RemovalModel& s, int max_size, Linearisation& linear) {
  weigh_swept_sets(s, max_size, sweep(s, max_size, linear), linear);
}

void weigh_explaining_sets(const RemovalModel& s, Linearisation& linear) {
  for (int k = s.is_sigma_known ? 0 : s.max_removed;; ++k) {
    const std::span<const double> numbers = sweep(s, k, linear);
    const double largest_q = std::ranges::max(numbers.first(numbers.size() / 2));
    const bool is_enough = linear.model.rss - largest_q <= noise_like_rss(s.degrees(k));
    if (is_enough || k >= s.max_removed) {
      weigh_swept_sets(s, k, numbers, linear);
      return;
    }
  }
}

const WeighedSet& heaviest(const std::vector<WeighedSet>& sets) {
  return *std::max_element(sets.begin(), sets.end(), [](const WeighedSet& a, const WeighedSet& b) {
    return a.log_weight < b.log_weight;
  });
}

std::vector<RemovalSet> heaviest_sets(const std::vector<WeighedSet>& sets, std::size_t count,
                                      double least) {
  const double least_log = heaviest(sets).log_weight + std::log(least);
  std::vector<const WeighedSet*> heavy;
  for (const WeighedSet& w : sets) {
    if (w.log_weight >= least_log) heavy.push_back(&w);
  }
  std::stable_sort(heavy.begin(), heavy.end(), [](const WeighedSet* a, const WeighedSet* b) {
    return a->log_weight > b->log_weight;
  });
  heavy.resize(std::min(heavy.size(), count));
  std::vector<RemovalSet> chosen;
  for (const WeighedSet* w : heavy) chosen.push_back(w->set);
  return chosen;
}

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

SetStep step_of(const RemovalModel& s, const Linearisation& linear, const RemovalSet& set) {
  SetStep step;
  step.delta = Eigen::Map<const Vector6d>(linear.model.step);
  if (set.size == 0) return step;
  SmallSystem system;
  system.size = 2 * set.size;
  for (int a = 0; a < system.size; ++a) {
    system.r[a] = linear.residual_at(a % 2, set.points[a / 2]);
    for (int b = 0; b <= a; ++b) {
      double dot = a == b;
      for (int k = 0; k < 6; ++k) {
        dot -= linear.basis_at(k, a % 2, set.points[a / 2]) *
               linear.basis_at(k, b % 2, set.points[b / 2]);
      }
      system.m[a][b] = dot;
    }
  }
  for (int i = 0; i < set.size; ++i) step.slab[i] = s.gamma[set.points[i]];
  const auto errors = system.solved(step.slab);  // of the removed points
  for (int i = 0; i < set.size; ++i) {
    const double e2 = errors[2 * i] * errors[2 * i] + errors[2 * i + 1] * errors[2 * i + 1];
    step.slab[i] = 4 / (2 / s.gamma[set.points[i]] + e2);
  }
  const auto z = system.solved(step.slab);
  double along[6] = {};
  for (int k = 0; k < 6; ++k) {
    for (int a = 0; a < system.size; ++a) {
      along[k] += linear.basis_at(k, a % 2, set.points[a / 2]) * z[a];
    }
  }
  double delta[6];
  kernel::step_along(linear.model, along, delta);
  step.delta += Eigen::Map<const Vector6d>(delta);
  return step;
}

}  // namespace sightline
