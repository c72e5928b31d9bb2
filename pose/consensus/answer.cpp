// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/answer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "pose/consensus/doubt.h"
#include "pose/consensus/noise.h"
#include "pose/reprojection.h"

namespace sightline::consensus {
namespace {

constexpr double kLogTwoPi = 1.8378770664093453;
/// Log weights this far below the best do not count.
constexpr double kNegligible = 9;
/// A set whose pose is turned by more is not what the linear model says it is.
constexpr double kBeyondLinearRad = 0.3;
/// Up to so many points the doubtful ones are tried even if some must be left out.
constexpr std::size_t kFew = 64;
/// With so few inliers a pose that one of them decides is weighed anew without it.
constexpr int kFewInliers = 6;

double log_determinant(const Eigen::LLT<Matrix6d>& cholesky) {
  double sum = 0;
  for (int k = 0; k < 6; ++k) sum += 2 * std::log(cholesky.matrixLLT()(k, k));
  return sum;
}

/// One choice of inliers among the doubtful points.
struct WeighedSet {
  std::uint32_t outliers = 0;  ///< bit k: the k-th doubtful point is an outlier
  double log_weight = 0;
  Vector6d step;
  double squares = 0;   ///< of the inliers
  double variance = 0;  ///< of an inlier's residual
  int inliers = 0;
  /// Of a set that was linearised at its own pose: which of the informations is its own, and the
  /// point that it lacks.
  int anew = -1;
  int left_out = -1;
};

/// Every choice of inliers, weighed in the linear model.
class Sets {
 public:
  Sets(const Cloud& cloud, const Mode& mode, const LinearCloud& linear, const Sorted& sorted,
       double variance)
      : cloud_(cloud), mode_(mode), linear_(linear), sorted_(sorted), variance_(variance) {
    for (const std::size_t i : sorted.certain) certain_.add(linear.rows[i], 1);
    for (const std::size_t i : sorted.outliers) {
      log_outliers_ += std::log(mode.law.density(linear.squares[i], cloud.area(i)));
      if (linear.is_seen[i]) outliers_.add(linear.rows[i], weight_of(i));
    }
    for (const std::size_t i : sorted.doubtful) {
      doubtful_.emplace_back().add(linear.rows[i], 1);
    }
  }

  /// The sets that count, in the order of their bits.
  std::vector<WeighedSet> weigh() {
    visit(0, root());
    std::erase_if(sets_,
                  [this](const WeighedSet& s) { return s.log_weight < best_ - kNegligible; });
    return std::move(sets_);
  }

  /// One of the sets, wherever it leads; none where three points are left or do not determine a
  /// pose.
  std::optional<WeighedSet> weigh_one(std::uint32_t outliers) const {
    Node node = root();
    for (std::size_t k = 0; k < doubtful_.size(); ++k) node = child(node, k, outliers >> k & 1);
    return weighed(node);
  }

  /// The step to the pose of a set's inliers alone.
  Vector6d step_of_inliers(std::uint32_t outliers) const {
    Quadratic sum = certain_;
    for (std::size_t k = 0; k < doubtful_.size(); ++k) {
      if (outliers >> k & 1) continue;
      sum.hessian += doubtful_[k].hessian;
      sum.gradient += doubtful_[k].gradient;
    }
    return -sum.hessian.ldlt().solve(sum.gradient);
  }

  void add(std::vector<WeighedSet>& sets, WeighedSet set, const Matrix6d& own_information) {
    set.anew = static_cast<int>(own_informations_.size());
    own_informations_.push_back(own_information);
    sets.push_back(set);
  }

  /// What is known of the pose if this set is the inliers: the inverse of its covariance.
  Matrix6d information(const WeighedSet& set) const {
    if (set.anew >= 0) return own_informations_[static_cast<std::size_t>(set.anew)];
    const double variance = cloud_.is_sigma_known()
                                ? variance_
                                : mean_variance(set.squares, set.inliers - 3, cloud_.typical_noise);
    Matrix6d hessian = certain_.hessian / variance + outliers_.hessian;
    for (std::size_t k = 0; k < doubtful_.size(); ++k) {
      hessian += doubtful_[k].hessian *
                 (set.outliers >> k & 1 ? weight_of(sorted_.doubtful[k]) : 1 / variance);
    }
    return hessian;
  }

 private:
  struct Node {
    Matrix6d hessian;
    Vector6d gradient;
    std::uint32_t outliers = 0;
  };

  double weight_of(std::size_t i) const {
    return mode_.law.weight(linear_.squares[i], cloud_.area(i));
  }

  Node root() const {
    return {certain_.hessian / variance_ + outliers_.hessian,
            certain_.gradient / variance_ + outliers_.gradient};
  }

  Node child(const Node& node, std::size_t k, bool is_outlier) const {
    const double weight = is_outlier ? weight_of(sorted_.doubtful[k]) : 1 / variance_;
    return {node.hessian + weight * doubtful_[k].hessian,
            node.gradient + weight * doubtful_[k].gradient,
            node.outliers | (is_outlier ? 1u << k : 0u)};
  }

  void visit(std::size_t k, const Node& node) {
    if (k < doubtful_.size()) {
      for (const bool is_outlier : {false, true}) visit(k + 1, child(node, k, is_outlier));
      return;
    }
    const std::optional<WeighedSet> set = weighed(node);
    if (!set || !(set->step.head<3>().norm() < kBeyondLinearRad)) return;
    if (set->log_weight > best_ - kNegligible) sets_.push_back(*set);
    best_ = std::max(best_, set->log_weight);
  }

  std::optional<WeighedSet> weighed(const Node& node) const {
    const int n = static_cast<int>(cloud_.size());
    const int outliers = std::popcount(node.outliers) + static_cast<int>(sorted_.outliers.size());
    WeighedSet set;
    set.outliers = node.outliers;
    set.inliers = n - outliers;
    // Three agree with any pose of theirs.
    if (set.inliers < kMinimumPosePoints) return std::nullopt;
    const Eigen::LLT<Matrix6d> cholesky(node.hessian);
    if (cholesky.info() != Eigen::Success) return std::nullopt;
    set.step = -cholesky.solve(node.gradient);
    double squares = certain_.at(set.step);
    double log_weight = log_outliers_ + std::lgamma(outliers + kPriorOutliers) +
                        std::lgamma(set.inliers + kPriorInliers);
    for (std::size_t k = 0; k < doubtful_.size(); ++k) {
      const double square = doubtful_[k].at(set.step);
      const double area = cloud_.area(sorted_.doubtful[k]);
      if (node.outliers >> k & 1) log_weight += std::log(mode_.law.density(square, area));
      if (!(node.outliers >> k & 1)) squares += square;
    }
    set.squares = squares;
    set.variance = variance_;
    log_weight += log_of_noise(squares, log_determinant(cholesky), set);
    if (!std::isfinite(log_weight)) return std::nullopt;
    set.log_weight = log_weight;
    return set;
  }

  /// The inliers' likelihood, the pose integrated out, and the noise where it is not known, whose
  /// mean is then the set's.
  double log_of_noise(double squares, double log_det, WeighedSet& set) const {
    const int m = set.inliers;
    if (cloud_.is_sigma_known()) {
      return -m * (kLogTwoPi + std::log(variance_)) - 0.5 * squares / variance_ - 0.5 * log_det +
             3 * kLogTwoPi;
    }
    const NoisePosterior noise = noise_posterior(squares, m - 3, cloud_.typical_noise);
    set.variance = noise.most_probable;
    return -(m - 3) * kLogTwoPi - 0.5 * (log_det + 6 * std::log(variance_)) + noise.log_evidence;
  }

  const Cloud& cloud_;
  const Mode& mode_;
  const LinearCloud& linear_;
  const Sorted& sorted_;
  const double variance_;
  Quadratic certain_, outliers_;
  double log_outliers_ = 0;
  std::vector<Quadratic> doubtful_;
  std::vector<WeighedSet> sets_;
  std::vector<Matrix6d> own_informations_;
  double best_ = -std::numeric_limits<double>::infinity();
};

/// Of those in the linear model, from which the answer's pose is.
const WeighedSet& heaviest(const std::vector<WeighedSet>& sets) {
  return *std::ranges::max_element(sets, {}, [](const WeighedSet& set) {
    return set.anew < 0 ? set.log_weight : -std::numeric_limits<double>::infinity();
  });
}

/// A set linearised at its own pose, its step being from the common one; and what is known of the
/// pose if it is the inliers.
struct OwnSet {
  WeighedSet set;
  Matrix6d information;
};

// Whether all inliers of a set lie in front of the camera at the pose of the linearisation. One
// that does not has no residual, and would count as one that fits exactly.
bool are_inliers_seen(const LinearCloud& linear, const Sorted& sorted, std::uint32_t outliers) {
  for (const std::size_t i : sorted.certain) {
    if (!linear.is_seen[i]) return false;
  }
  for (std::size_t k = 0; k < sorted.doubtful.size(); ++k) {
    if ((outliers >> k & 1) == 0 && !linear.is_seen[sorted.doubtful[k]]) return false;
  }
  return true;
}

/// From a step to its pose; none where that does not settle, or an inlier is not in front there.
std::optional<OwnSet> weigh_anew(const Cloud& cloud, const Mode& mode, const Sorted& sorted,
                                 const Pose& common, const Vector6d& step_to_it, double variance,
                                 std::uint32_t outliers) {
  constexpr int kMostSteps = 8;
  constexpr double kSettledRad = 1e-3;
  LinearCloud own;
  Vector6d next = step_to_it;
  Pose pose = common;
  for (int step = 0; step < kMostSteps; ++step) {
    const double turn = next.head<3>().norm();
    if (!std::isfinite(turn)) break;
    pose = retract(pose, std::min(1.0, kBeyondLinearRad / turn) * next);
    linearise(cloud, pose, own);
    if (!are_inliers_seen(own, sorted, outliers)) break;
    const Sets at_own(cloud, mode, own, sorted, variance);
    std::optional<WeighedSet> set = at_own.weigh_one(outliers);
    if (!set) break;
    next = set->step;
    if (next.head<3>().norm() > kSettledRad) continue;
    const Matrix6d information = at_own.information(*set);
    set->step = change_between(common, retract(pose, next));
    return OwnSet{*set, information};
  }
  return std::nullopt;
}

/// A set that lacks one of the inliers of another.
struct LeftOut {
  std::size_t point;
  Sorted sorted;  ///< with that point among the doubtful
  std::uint32_t outliers;
};

std::vector<LeftOut> leave_each_out(const Sorted& sorted, const WeighedSet& set) {
  std::vector<LeftOut> all;
  for (std::size_t k = 0; k < sorted.doubtful.size(); ++k) {
    if (set.outliers >> k & 1) continue;
    all.push_back({sorted.doubtful[k], sorted, set.outliers | 1u << k});
  }
  for (std::size_t k = 0; k < sorted.certain.size(); ++k) {
    LeftOut left = {sorted.certain[k], sorted, set.outliers | 1u << sorted.doubtful.size()};
    left.sorted.certain.erase(left.sorted.certain.begin() + static_cast<std::ptrdiff_t>(k));
    left.sorted.doubtful.push_back(left.point);
    all.push_back(std::move(left));
  }
  return all;
}

/// A point that agrees by chance may decide what the few others leave open. As an outlier near the
/// truth it holds the pose where it is; as one that may be anywhere it leaves the pose to the
/// others, many deviations away. So the sets that lack one of the inliers are weighed there, too.
void weigh_without(const Cloud& cloud, const Mode& mode, const Sorted& sorted,
                   const LinearCloud& linear, double variance, Sets& model,
                   std::vector<WeighedSet>& sets) {
  const WeighedSet best = heaviest(sets);
  if (best.inliers > kFewInliers || best.inliers <= kMinimumPosePoints) return;
  const Matrix6d information = model.information(best);
  const auto is_far = [&](const Vector6d& step) {
    const Vector6d apart = step - best.step;
    return apart.dot(information * apart) > kFarDistance2;
  };
  for (const LeftOut& left : leave_each_out(sorted, best)) {
    const Sets without(cloud, mode, linear, left.sorted, variance);
    const Vector6d step = without.step_of_inliers(left.outliers);
    if (!is_far(step)) continue;
    auto own = weigh_anew(cloud, mode, left.sorted, linear.cam_from_centred, step, variance,
                          left.outliers);
    if (!own || !(own->set.log_weight > best.log_weight - kNegligible)) continue;
    own->set.left_out = static_cast<int>(left.point);
    if (is_far(own->set.step)) model.add(sets, own->set, own->information);
  }
}

/// Sums up the sets that lead far from the most probable one.
void find_far_sets(const LinearCloud& linear, const Sets& model,
                   const std::vector<WeighedSet>& sets, double total, Answer& answer) {
  const WeighedSet& best = heaviest(sets);
  const Matrix6d information = model.information(best);
  const WeighedSet* far = nullptr;
  answer.far_share = 0;
  for (const WeighedSet& set : sets) {
    const Vector6d apart = set.step - best.step;
    if (!(apart.dot(information * apart) > kFarDistance2)) continue;
    answer.far_share += std::exp(set.log_weight - best.log_weight) / total;
    if (far == nullptr || set.log_weight > far->log_weight) far = &set;
  }
  if (far != nullptr) answer.far_cam_from_centred = retract(linear.cam_from_centred, far->step);
}

/// The mean over the sets of the linear model, and the second moment of all sets about it.
void average(const Cloud& cloud, const Sorted& sorted, const LinearCloud& linear, const Sets& model,
             const std::vector<WeighedSet>& sets, Answer& answer) {
  const WeighedSet& best = heaviest(sets);
  double total = 0, linear_total = 0;
  Vector6d mean = Vector6d::Zero();
  for (const WeighedSet& set : sets) {
    const double weight = std::exp(set.log_weight - best.log_weight);
    total += weight;
    if (set.anew >= 0) continue;
    linear_total += weight;
    mean += weight * set.step;
  }
  mean /= linear_total;
  find_far_sets(linear, model, sets, total, answer);
  answer.probabilities.assign(cloud.size(), 0);
  answer.is_inlier.assign(cloud.size(), false);
  for (const std::size_t i : sorted.certain) {
    answer.probabilities[i] = 1;
    answer.is_inlier[i] = true;
  }
  answer.variance = 0;
  answer.covariance.setZero();
  for (const WeighedSet& set : sets) {
    const double share = std::exp(set.log_weight - best.log_weight) / total;
    const Vector6d apart = set.step - mean;
    answer.covariance += share * (model.information(set).inverse() + apart * apart.transpose());
    answer.variance += share * set.variance;
    for (std::size_t k = 0; k < sorted.doubtful.size(); ++k) {
      if (!(set.outliers >> k & 1)) answer.probabilities[sorted.doubtful[k]] += share;
    }
    const bool lacks_certain = set.outliers >> sorted.doubtful.size() != 0;
    if (lacks_certain) answer.probabilities[static_cast<std::size_t>(set.left_out)] -= share;
  }
  for (std::size_t k = 0; k < sorted.doubtful.size(); ++k) {
    if (!(best.outliers >> k & 1)) answer.is_inlier[sorted.doubtful[k]] = true;
  }
  answer.set_probability = sorted.is_exhaustive ? 1 / total : 0;
  answer.cam_from_centred = retract(linear.cam_from_centred, mean);
  answer.most_probable = retract(linear.cam_from_centred, best.step);
  answer.log_evidence = best.log_weight + std::log(linear_total);
}

/// Linearises anew while the most probable set leads too far away. False where no set has a pose.
bool answer_of_sets(const Cloud& cloud, const Mode& mode, const Sorted& sorted, LinearCloud& linear,
                    Answer& answer) {
  constexpr int kRounds = 3;
  constexpr double kFarRad = 3e-3;
  double variance = mode.variance;
  for (int round = 0;; ++round) {
    Sets model(cloud, mode, linear, sorted, variance);
    std::vector<WeighedSet> sets = model.weigh();
    if (sets.empty()) return false;
    const WeighedSet& best = heaviest(sets);
    const double turn = best.step.head<3>().norm();
    if (round + 1 == kRounds || !(turn > kFarRad * (round + 1))) {
      weigh_without(cloud, mode, sorted, linear, variance, model, sets);
      average(cloud, sorted, linear, model, sets, answer);
      return answer.covariance.allFinite();
    }
    if (!cloud.is_sigma_known()) variance = best.variance;
    linearise(cloud, retract(linear.cam_from_centred, best.step), linear);
  }
}

/// The mode itself, with the information observed.
bool answer_of_weights(const Cloud& cloud, const Mode& mode, const LinearCloud& linear,
                       Answer& answer) {
  Quadratic expected;
  Matrix6d doubt = Matrix6d::Zero();
  double log_set = 0;
  answer.is_inlier.assign(cloud.size(), false);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double w = mode.weights[i];
    answer.is_inlier[i] = w > 0.5;
    log_set += std::log(std::max(w, 1 - w));
    if (w == 0 || !linear.is_seen[i]) continue;
    expected.add(linear.rows[i], w / mode.variance);
    Quadratic one;
    one.add(linear.rows[i], 1 / mode.variance);
    doubt += w * (1 - w) * one.gradient * one.gradient.transpose();
  }
  std::optional<Matrix6d> covariance = inverse_information(expected.hessian - doubt);
  if (!covariance) covariance = inverse_information(expected.hessian);
  if (!covariance) return false;
  const double degrees = 2 * mode.inliers - 6;
  const bool has_tails = !cloud.is_sigma_known() && degrees > 2;
  answer.covariance = has_tails ? *covariance * (degrees / (degrees - 2)) : *covariance;
  answer.cam_from_centred = answer.most_probable = mode.cam_from_centred;
  answer.probabilities = mode.weights;
  answer.set_probability = std::exp(log_set);
  answer.variance = mode.variance;
  answer.log_evidence = mode.log_likelihood;
  return true;
}

/// A pose as probable as its mirror image in scale: the density of its position is 1 / z^3.
double log_prior(const Pose& cam_from_centred) {
  return -3 * std::log(std::abs(cam_from_centred.translation.z()));
}

}  // namespace

bool answer_of(const Cloud& cloud, const Mode& mode, Answer& answer) {
  LinearCloud linear;
  linearise(cloud, mode.cam_from_centred, linear);
  if (cloud.size() > kFew) return answer_of_weights(cloud, mode, linear, answer);
  const Sorted sorted = sort_by_doubt(cloud, mode, linear, kMostDoubtful);
  if (!answer_of_sets(cloud, mode, sorted, linear, answer)) return false;
  answer.log_evidence += log_prior(mode.cam_from_centred);
  return true;
}

}  // namespace sightline::consensus
