// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// One Newton step on the conditions sum l_i g_i = 0, sum l_i = 1, l_i s_i = mu, f_i + s_i = t, g_i
// the slope of f_i, is, with w_i = l_i / s_i, m_i = f_i + s_i - t and
// p_i = (mu - correction_i + l_i m_i) / s_i,
//
//   [H + sum w_i g_i g_i^T   -sum w_i g_i] [dx]   [-sum p_i g_i]
//   [-sum w_i g_i^T           sum w_i    ] [dt] = [ sum p_i - 1 ]
//   ds_i = dt - g_i . dx - m_i,   dl_i = (mu - correction_i - l_i ds_i) / s_i - l_i,
//
// the algebra of pose/interior_point.h. The unknowns are (w, dt), and d ln scale where a scale is
// estimated; H = sum l_i (second derivative of f_i), with q_i = scale R x_a and r_i = q_i + t -
// x_b:
//
//   J_i = (-[q_i]x, I, q_i),   f_i'' v_i = 2 J_i^T J_i + turning: r q^T + q r^T - 2 (r . q) I,
//                                          turning and scale: 2 q x r,   scale: 2 r . q.

#include "pose/orientation/orpe_minimax.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace sightline {
namespace {

using pair_consensus::PairSet;
using pair_consensus::Similarity;

/// Up to seven pairs hold the maximum; so many are taken at first, and so many join at a time.
constexpr std::size_t kFirstPairs = 10;
constexpr std::size_t kJoiningPairs = 5;
constexpr int kMostRounds = 50;
constexpr int kMostSteps = 60;
/// The largest f is found to this part of itself.
constexpr double kGap = 1e-7;
/// Squared distances below this are rounding.
constexpr double kNoSquare = 1e-24;
/// How near to its bound a step may go.
constexpr double kStepPart = 0.995;

using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 7, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 7, 7>;

struct DistanceConstraint {
  Eigen::Vector3d q, r;
  Unknowns slope;
  double f = 0, slack = 0, multiplier = 0, miss = 0, correction = 0;
  double slack_change = 0, multiplier_change = 0;
};

double square_at(const PairSet& set, const Similarity& map, int index) {
  const auto k = static_cast<std::size_t>(index);
  return (map * set.a[k] - set.b[k]).squaredNorm() * set.inverse_variance[k];
}

/// The iteration on a few pairs.
class DistanceInteriorPoint {
 public:
  DistanceInteriorPoint(const PairSet& set, std::span<const int> indices)
      : set_(set), indices_(indices), constraints_(indices.size()) {}

  /// The multipliers at the end; `map` becomes the best that was met.
  std::vector<double> run(Similarity& map) {
    evaluate(map);
    centre();
    Similarity best = map;
    double lowest = largest();
    for (int i = 0; i < kMostSteps && lowest > kNoSquare; ++i) {
      if (!step(map)) break;
      if (largest() < lowest) {
        lowest = largest();
        best = map;
      }
      if (is_done()) break;
    }
    map = best;
    std::vector<double> multipliers;
    for (const DistanceConstraint& c : constraints_) multipliers.push_back(c.multiplier);
    return multipliers;
  }

 private:
  void evaluate(const Similarity& map) {
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      const auto k = static_cast<std::size_t>(indices_[i]);
      DistanceConstraint& c = constraints_[i];
      c.q = map.scale * (map.rotation * set_.a[k]);
      c.r = c.q + map.translation - set_.b[k];
      const double information = set_.inverse_variance[k];
      c.f = information * c.r.squaredNorm();
      c.slope.resize(set_.unknowns());
      c.slope.head<3>() = 2 * information * c.q.cross(c.r);
      c.slope.segment<3>(3) = 2 * information * c.r;
      if (set_.estimates_scale) c.slope[6] = 2 * information * c.r.dot(c.q);
    }
  }

  double largest() const {
    double most = 0;
    for (const DistanceConstraint& c : constraints_) most = std::max(most, c.f);
    return most;
  }

  double mean_product() const {
    double sum = 0;
    for (const DistanceConstraint& c : constraints_) sum += c.multiplier * c.slack;
    return sum / static_cast<double>(constraints_.size());
  }

  /// Whether the products and the misses are gone: sum l f is then max f.
  bool is_done() const {
    double weighed = 0;
    double sum = 0;
    for (const DistanceConstraint& c : constraints_) {
      weighed += c.multiplier * c.f;
      sum += c.multiplier;
    }
    return weighed > (1 - kGap) * sum * largest();
  }

  /// Slacks and multipliers of equal products; the multipliers sum to one.
  void centre() {
    bound_ = 1.1 * largest();
    double sum = 0;
    for (DistanceConstraint& c : constraints_) {
      c.slack = bound_ - c.f;
      sum += 1 / c.slack;
    }
    for (DistanceConstraint& c : constraints_) {
      c.multiplier = 1 / (sum * c.slack);
      c.miss = 0;
    }
  }

  /// sum l_i f_i'', or of it what is positive in any case: 2 sum l_i J_i^T J_i / v_i.
  Square hessian(bool is_whole) const {
    const int p = set_.unknowns();
    Square h = Square::Zero(p, p);
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 7> jacobian(3, p);
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      const DistanceConstraint& c = constraints_[i];
      const double weight =
          c.multiplier * set_.inverse_variance[static_cast<std::size_t>(indices_[i])];
      jacobian.leftCols<3>() << 0, c.q.z(), -c.q.y(), -c.q.z(), 0, c.q.x(), c.q.y(), -c.q.x(), 0;
      jacobian.middleCols<3>(3).setIdentity();
      if (p == 7) jacobian.col(6) = c.q;
      h.noalias() += (2 * weight) * jacobian.transpose() * jacobian;
      if (!is_whole) continue;
      const double rq = c.r.dot(c.q);
      h.topLeftCorner<3, 3>() += weight * (c.r * c.q.transpose() + c.q * c.r.transpose());
      h.topLeftCorner<3, 3>().diagonal().array() -= 2 * weight * rq;
      if (p < 7) continue;
      const Eigen::Vector3d mixed = 2 * weight * c.q.cross(c.r);
      h.topRightCorner<3, 1>() += mixed;
      h.bottomLeftCorner<1, 3>() += mixed.transpose();
      h(6, 6) += 2 * weight * rq;
    }
    return h;
  }

  /// Solves for the step towards l s = mu - correction, and stores the constraints' own changes.
  void solve(const Eigen::LLT<Square>& factor, const Unknowns& coupling, double weights,
             double mu) {
    Unknowns right = Unknowns::Zero(set_.unknowns());
    double sum = -1;
    for (const DistanceConstraint& c : constraints_) {
      const double p = (mu - c.correction + c.multiplier * c.miss) / c.slack;
      right -= p * c.slope;
      sum += p;
    }
    delta_ = factor.solve(right + coupling * (sum / weights));
    bound_change_ = (sum + coupling.dot(delta_)) / weights;
    for (DistanceConstraint& c : constraints_) {
      c.slack_change = bound_change_ - c.slope.dot(delta_) - c.miss;
      c.multiplier_change =
          (mu - c.correction - c.multiplier * c.slack_change) / c.slack - c.multiplier;
    }
  }

  /// The longest step that keeps slacks and multipliers positive.
  double longest_step() const {
    double step = 1;
    for (const DistanceConstraint& c : constraints_) {
      if (c.slack_change < 0) step = std::min(step, -kStepPart * c.slack / c.slack_change);
      if (c.multiplier_change < 0) {
        step = std::min(step, -kStepPart * c.multiplier / c.multiplier_change);
      }
    }
    return step;
  }

  /// Mehrotra's: how far mu may fall, by where a step to zero would lead, whose second order is
  /// corrected.
  double predicted_mu() {
    const double before = mean_product();
    const double length = longest_step();
    double after = 0;
    for (DistanceConstraint& c : constraints_) {
      after += (c.slack + length * c.slack_change) * (c.multiplier + length * c.multiplier_change);
      c.correction = c.slack_change * c.multiplier_change;
    }
    after /= static_cast<double>(constraints_.size());
    return before * std::pow(std::clamp(after / before, 0.0, 1.0), 3);
  }

  bool step(Similarity& map) {
    Square outer = Square::Zero(set_.unknowns(), set_.unknowns());
    Unknowns coupling = Unknowns::Zero(set_.unknowns());
    double weights = 0;
    for (DistanceConstraint& c : constraints_) {
      const double w = c.multiplier / c.slack;
      outer.noalias() += w * c.slope * c.slope.transpose();
      coupling += w * c.slope;
      weights += w;
      c.correction = 0;
    }
    outer.noalias() -= coupling * (coupling.transpose() / weights);
    const auto factored = [&](bool is_whole) {
      Square matrix = hessian(is_whole) + outer;
      matrix.diagonal() *= 1 + 1e-12;
      return Eigen::LLT<Square>(matrix);
    };
    Eigen::LLT<Square> factor = factored(true);
    if (factor.info() != Eigen::Success) factor = factored(false);
    if (factor.info() != Eigen::Success) return false;
    solve(factor, coupling, weights, 0);
    solve(factor, coupling, weights, predicted_mu());
    if (!delta_.allFinite()) return false;
    move(longest_step(), map);
    return true;
  }

  void move(double length, Similarity& map) {
    const Unknowns d = length * delta_;
    const double growth = set_.estimates_scale ? std::exp(d[6]) : 1.0;
    map.rotation = rotation_from_vector(d.head<3>()) * map.rotation;
    map.translation += d.segment<3>(3);
    map.scale *= growth;
    bound_ += length * bound_change_;
    evaluate(map);
    for (DistanceConstraint& c : constraints_) {
      c.slack += length * c.slack_change;
      c.multiplier += length * c.multiplier_change;
      c.miss = c.f + c.slack - bound_;
    }
  }

  const PairSet& set_;
  std::span<const int> indices_;
  std::vector<DistanceConstraint> constraints_;
  double bound_ = 0;
  Unknowns delta_;
  double bound_change_ = 0;
};

/// Lets the pairs join that exceed `limit` most, by their positions among the indices.
bool join_farthest(const PairSet& set, std::span<const int> indices, const Similarity& map,
                   double limit, std::size_t count, std::vector<std::size_t>& active) {
  std::vector<std::pair<double, std::size_t>> beyond;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const double f = square_at(set, map, indices[i]);
    if (!(f > limit) || std::find(active.begin(), active.end(), i) != active.end()) continue;
    beyond.emplace_back(f, i);
  }
  const std::size_t joining = std::min(count, beyond.size());
  std::partial_sort(beyond.begin(), beyond.begin() + static_cast<std::ptrdiff_t>(joining),
                    beyond.end(), std::greater<>());
  for (std::size_t i = 0; i < joining; ++i) active.push_back(beyond[i].second);
  return joining > 0;
}

/// max f, and the least that any map reaches by the multipliers.
void certify(const PairSet& set, std::span<const int> indices, DistanceMinimax& minimax) {
  minimax.largest = 0;
  for (const int index : indices) {
    minimax.largest = std::max(minimax.largest, square_at(set, minimax.map, index));
  }
  double sum = 0;
  for (double& multiplier : minimax.multipliers) sum += multiplier;
  for (double& multiplier : minimax.multipliers) multiplier /= sum;
  minimax.lower_bound = 0;
  const auto map = pair_consensus::fit_pairs(set, indices, minimax.multipliers);
  if (!map) return;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    minimax.lower_bound += minimax.multipliers[i] * square_at(set, *map, indices[i]);
  }
}

}  // namespace

std::size_t DistanceMinimax::most_binding() const {
  return static_cast<std::size_t>(std::max_element(multipliers.begin(), multipliers.end()) -
                                  multipliers.begin());
}

std::optional<DistanceMinimax> minimise_largest_distance(const PairSet& set,
                                                         std::span<const int> indices) {
  const auto start = pair_consensus::fit_pairs(set, indices);
  if (!start) return std::nullopt;
  DistanceMinimax minimax;
  minimax.map = *start;
  minimax.multipliers.assign(indices.size(), 1 / static_cast<double>(indices.size()));
  std::vector<std::size_t> active;
  double limit = -1;
  std::size_t joining = kFirstPairs;
  for (int round = 0; round < kMostRounds; ++round) {
    if (!join_farthest(set, indices, minimax.map, limit, joining, active)) break;
    joining = kJoiningPairs;
    std::vector<int> chosen;
    for (const std::size_t i : active) chosen.push_back(indices[i]);
    const std::vector<double> multipliers = DistanceInteriorPoint(set, chosen).run(minimax.map);
    std::fill(minimax.multipliers.begin(), minimax.multipliers.end(), 0);
    limit = 0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      minimax.multipliers[active[i]] = multipliers[i];
      limit = std::max(limit, square_at(set, minimax.map, chosen[i]));
    }
    limit = std::max(limit * (1 + kGap), kNoSquare);
  }
  certify(set, indices, minimax);
  return minimax;
}

}  // namespace sightline
