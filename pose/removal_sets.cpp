// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/removal_sets.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

/// Of outliers, before any point is looked at.
struct SlabLaw {
  double odds;
  double scale_px2;
};

SlabLaw slab_law(const OutlierOptions& options) {
  constexpr double kLeastProbability = 1e-9;
  constexpr double kLeastScalePx = 1e-12;  // in any unit
  constexpr double kLargestScalePx = 1e9;
  // Not std::clamp: what is no number must become one.
  const double probability = options.probability > kLeastProbability
                                 ? std::min(options.probability, 1 - kLeastProbability)
                                 : kLeastProbability;
  const double scale_px = options.scale_px > kLeastScalePx
                              ? std::min(options.scale_px, kLargestScalePx)
                              : kLeastScalePx;
  return {probability / (1 - probability), scale_px * scale_px};
}

/// What is known of a point before its residual is, by the inverse covariance of an inlier.
struct PointPrior {
  double gamma;
  double log_odds;
};

PointPrior prior_of(const Eigen::Matrix2d& information, bool is_sigma_known, const SlabLaw& slab) {
  const double of_known = 1 / (slab.scale_px2 * std::sqrt(information.determinant()));
  if (is_sigma_known) return {of_known, std::log(slab.odds * of_known)};
  return {kUnknownGamma, std::log(slab.odds / slab.scale_px2)};
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

/// For sweeps of up to the most points that may be removed.
void make_room(const RemovalModel& s, std::size_t stride, Linearisation& linear) {
  const std::size_t n = s.c->size();
  const std::size_t sets = 1 + kernel::swept_room(n, s.max_removed);
  double* next =
      linear.room.take(14 * stride + 3 * sets + kernel::sweep_workspace(n, s.max_removed));
  const auto part = [&next](std::size_t size) { return std::exchange(next, next + size); };
  linear.stride = stride;
  linear.basis = part(12 * stride);
  linear.residuals = part(2 * stride);
  linear.sweep.of.q = part(sets);
  linear.sweep.of.det = part(sets);
  linear.sweep.of.weight = part(sets);
  linear.sweep.workspace = next;
}

/// All sets of up to max_size points into linear.sweep; `before` as of kernel::sweep_sets.
void sweep_to(const RemovalModel& s, int max_size, int before, Linearisation& linear) {
  const std::size_t n = s.c->size();
  Sweep& sweep = linear.sweep;
  sweep.max_size = max_size;
  sweep.count = kernel::set_count(n, max_size) + 1;
  *sweep.of.q = 0;
  *sweep.of.det = 1;
  *sweep.of.weight = 0;
  if (max_size == 0) return;
  kernel::sweep_sets({n, linear.basis, linear.residuals, s.gamma.data(), s.log_odds.data()},
                     max_size, before, sweep.workspace,
                     {sweep.of.q + 1, sweep.of.det + 1, sweep.of.weight + 1});
}

/// The set of a place in a sweep.
RemovalSet set_at(std::size_t place, int n, int max_size) {
  RemovalSet set;
  for (int next = 0; place > 0; ++next) {
    --place;  // the set so far
    for (;; ++next) {
      const int left = max_size - set.size - 1;
      const std::size_t with_next =
          1 + kernel::set_count(static_cast<std::size_t>(n - next - 1), left);
      if (place < with_next) break;
      place -= with_next;
    }
    set.points[set.size++] = static_cast<unsigned short>(next);
  }
  return set;
}

/// A symmetric system of a few unknowns, solved in place. Positive definite by what is added to its
/// diagonal.
struct SmallSystem {
  static constexpr int kMax = 2 * kMaxRemoved;

  int size = 0;
  std::array<std::array<double, kMax>, kMax> m;  ///< lower triangle
  std::array<double, kMax> r;

  /// The solution with slab[i / 2] added to the diagonal (L D L^T).
  std::array<double, kMax> solved(const std::array<double, kMaxRemoved>& slab) const {
    std::array<std::array<double, kMax>, kMax> l;
    std::array<double, kMax> inverse_d, x;
    for (int i = 0; i < size; ++i) {
      double d = m[i][i] + slab[i / 2];
      x[i] = r[i];
      for (int j = 0; j < i; ++j) {
        // Above the diagonal l[k][i] is l[i][k] d_k.
        double undivided = m[i][j];
        for (int k = 0; k < j; ++k) undivided -= l[k][i] * l[j][k];
        l[j][i] = undivided;
        l[i][j] = undivided * inverse_d[j];
        d -= l[i][j] * undivided;
        x[i] -= l[i][j] * x[j];
      }
      inverse_d[i] = 1 / d;
    }
    for (int i = size - 1; i >= 0; --i) {
      x[i] *= inverse_d[i];
      for (int k = i + 1; k < size; ++k) x[i] -= l[k][i] * x[k];
    }
    return x;
  }
};

/// The rows of a set's points, in columns: of each point that of u, then that of v.
struct SetRows {
  int count = 0;
  Eigen::Matrix<double, 6, SmallSystem::kMax> basis;
  std::array<double, SmallSystem::kMax> residuals;
};

SetRows rows_of(const Linearisation& linear, const RemovalSet& set) {
  SetRows rows;
  rows.count = 2 * set.size;
  for (int i = 0; i < set.size; ++i) {
    const double* next = linear.basis + set.points[i];
    for (int half = 0; half < 2; ++half) {
      for (int k = 0; k < 6; ++k, next += linear.stride) rows.basis(k, 2 * i + half) = *next;
      rows.residuals[2 * i + half] = linear.residual_at(half, set.points[i]);
    }
  }
  return rows;
}

/// M of a set's points, and their residuals.
SmallSystem system_of(const SetRows& rows) {
  SmallSystem system;
  system.size = rows.count;
  for (int a = 0; a < rows.count; ++a) {
    system.r[a] = rows.residuals[a];
    for (int b = 0; b < a; ++b) system.m[a][b] = -rows.basis.col(a).dot(rows.basis.col(b));
    system.m[a][a] = 1 - rows.basis.col(a).squaredNorm();
  }
  return system;
}

std::array<double, kMaxRemoved> gammas_of(const RemovalModel& s, const RemovalSet& set) {
  std::array<double, kMaxRemoved> gammas;
  for (int i = 0; i < set.size; ++i) gammas[i] = s.gamma[set.points[i]];
  return gammas;
}

/// Whether some set of the sweep leaves what looks like noise. What is left of rss - q, which holds
/// the slab's part for outliers far out, is that of the points kept alone.
bool is_explained_by_sweep(const RemovalModel& s, const Linearisation& linear) {
  const Sweep& sweep = linear.sweep;
  const double bound = noise_like_rss(s.degrees(sweep.max_size));
  if (sweep.max_size == 0) return linear.model.rss <= bound;
  const std::size_t place = kernel::largest_of(sweep.of.q, sweep.count);
  const double all = linear.model.rss - sweep.of.q[place];
  if (all <= bound) return true;
  const RemovalSet set = set_at(place, s.n(), sweep.max_size);
  const auto gammas = gammas_of(s, set);
  // The outliers' errors, free of noise: their slab's part is gamma of their squares, and their own
  // noise's gamma^2.
  const auto errors = system_of(rows_of(linear, set)).solved(gammas);
  double of_outliers = 0;
  for (int i = 0; i < set.size; ++i) {
    const double e2 = errors[2 * i] * errors[2 * i] + errors[2 * i + 1] * errors[2 * i + 1];
    of_outliers += gammas[i] * (1 + gammas[i]) * e2;
  }
  return all - of_outliers <= bound;
}

/// Where the noise is known.
WeighedSet weighed(const RemovalModel& s, const Linearisation& linear, std::size_t place,
                   const RemovalSet& set) {
  WeighedSet w;
  w.set = set;
  w.rss = std::max(linear.model.rss - linear.sweep.of.q[place], 0.0);
  w.log_weight = -0.5 * (w.rss + std::log(linear.sweep.of.det[place]) + linear.model.log_det);
  for (const int point : set.span()) w.log_weight += s.log_odds[point];
  return w;
}

void weigh_probable_sets(const RemovalModel& s, double least, Linearisation& linear) {
  const Sweep& sweep = linear.sweep;
  const double* const weights = sweep.of.weight;
  const double least_weight =
      weights[kernel::largest_of(weights, sweep.count)] + 2 * std::log(least) - kernel::kRoughLog;
  constexpr std::size_t kUsual = 8;
  linear.sets.clear();
  linear.sets.reserve(kUsual);
  for (std::size_t place = 0; place < sweep.count; ++place) {
    // A NaN is of a set that determines no pose.
    if (!(weights[place] >= least_weight)) continue;
    linear.sets.push_back(weighed(s, linear, place, set_at(place, s.n(), sweep.max_size)));
  }
}

}  // namespace

RemovalModel removal_model(const WhitenedCorrespondences& c, const OutlierOptions& options) {
  RemovalModel s;
  s.c = &c.points;
  s.is_sigma_known = c.sigma > 0;
  s.max_removed = own_removal_limit(s.n(), options);
  const SlabLaw slab = slab_law(options);
  if (c.whitening.empty()) {
    s.common_variance = s.is_sigma_known ? c.sigma * c.sigma : 1;
    const Eigen::Matrix2d information = Eigen::Matrix2d::Identity() / *s.common_variance;
    const PointPrior prior = prior_of(information, s.is_sigma_known, slab);
    s.gamma.assign(c.size(), prior.gamma);
    s.log_odds.assign(c.size(), prior.log_odds);
    return s;
  }
  for (const Eigen::Matrix2d& whitening : c.whitening) {
    s.information.emplace_back(whitening.transpose() * whitening);
    const PointPrior prior = prior_of(s.information.back(), true, slab);
    s.gamma.push_back(prior.gamma);
    s.log_odds.push_back(prior.log_odds);
  }
  return s;
}

PackedPoints packed(const RemovalModel& s) {
  return s.common_variance ? PackedPoints(*s.c, {}, 1 / *s.common_variance)
                           : PackedPoints(*s.c, s.information);
}

bool linearise(const RemovalModel& s, const PackedPoints& points, const Pose& pose,
               Linearisation& linear) {
  linear.pose = pose;
  if (linear.stride == 0) make_room(s, points.lanes().size() * kernel::kLanes, linear);
  return kernel::linearise(points.lanes().data(), points.lanes().size(), rigid_from(pose),
                           linear.basis, linear.residuals, linear.model);
}

void weigh_swept_sets(const RemovalModel& s, Linearisation& linear) {
  const Sweep& sweep = linear.sweep;
  const auto by_size = size_weights(s, sweep.max_size);
  const double prior_sum = kPriorDegrees * kPriorSigmaPx * kPriorSigmaPx;
  linear.sets.resize(sweep.count);
  RemovalSet set;
  for (std::size_t place = 0; place < sweep.count; ++place) {
    if (place > 0) set = next_set(set, s.n(), sweep.max_size);
    WeighedSet& w = linear.sets[place];
    w = weighed(s, linear, place, set);
    if (s.is_sigma_known) continue;
    const SizeWeight& of_size = by_size[set.size];
    w.log_weight +=
        0.5 * w.rss + of_size.constant - of_size.half_nu * std::log(0.5 * (w.rss + prior_sum));
  }
}

void weigh_sets(const RemovalModel& s, int max_size, Linearisation& linear) {
  sweep_to(s, max_size, 0, linear);
  weigh_swept_sets(s, linear);
}

void weigh_explaining_sets(const RemovalModel& s, int fewest, double least, Linearisation& linear) {
  if (!s.is_sigma_known) return weigh_sets(s, s.max_removed, linear);
  int before = 0;
  for (int k = std::min(fewest, s.max_removed);; ++k) {
    sweep_to(s, k, before, linear);
    before = k;
    if (k >= s.max_removed || is_explained_by_sweep(s, linear)) break;
  }
  weigh_probable_sets(s, least, linear);
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
  heavy.reserve(sets.size());
  for (const WeighedSet& w : sets) {
    if (w.log_weight >= least_log) heavy.push_back(&w);
  }
  std::ranges::sort(heavy, [](const WeighedSet* a, const WeighedSet* b) {
    return a->log_weight > b->log_weight || (a->log_weight == b->log_weight && a < b);
  });
  heavy.resize(std::min(heavy.size(), count));
  std::vector<RemovalSet> chosen;
  chosen.reserve(heavy.size());
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
  const SetRows rows = rows_of(linear, set);
  const SmallSystem system = system_of(rows);
  step.slab = gammas_of(s, set);
  const auto errors = system.solved(step.slab);  // of the removed points
  for (int i = 0; i < set.size; ++i) {
    const double e2 = errors[2 * i] * errors[2 * i] + errors[2 * i + 1] * errors[2 * i + 1];
    step.slab[i] = 4 / (2 / s.gamma[set.points[i]] + e2);
  }
  const auto z = system.solved(step.slab);
  Vector6d along_set = Vector6d::Zero();
  for (int a = 0; a < rows.count; ++a) along_set += z[a] * rows.basis.col(a);
  double along[6];
  Eigen::Map<Vector6d>(along, 6) = along_set;
  double delta[6];
  kernel::step_along(linear.model, along, delta);
  step.delta += Eigen::Map<const Vector6d>(delta);
  return step;
}

}  // namespace sightline
