// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
//   1. Hypotheses: the answer to the points alone, the initial pose, and from each of these the
//      poses that three observations ask for, which a wrong one among the others cannot spoil.
//   2. The best few are fitted by expectation maximisation: every observation is weighed by its
//      probability of being an inlier. An outlier's error is anything on the image, or some twenty
//      pixels of it, as of a search that met another edge.
//   3. Of the different poses that come out the most probable is the answer; another that is far
//      away and probable makes it ambiguous.
//
// What consensus is for points (pose/solvers/consensus.cpp), whose answer to the points it begins
// at. Lines are too few and too alike for a search of their own over all the image.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/LU>

#include "pose/consensus/answer.h"
#include "pose/consensus/noise.h"
#include "pose/lines/joint.h"
#include "pose/minimise.h"
#include "pose/solvers/solvers.h"

namespace sightline::lines {
namespace {

/// Of the image's root area: how far a near outlier errs (20 pixels of 640 x 480).
constexpr double kNearScale = 0.036;
/// Before anything is seen: how many outliers there are to how many inliers.
constexpr double kPriorOutliers = 1;
constexpr double kPriorInliers = 4;
constexpr int kMostRounds = 30;
constexpr int kStepsARound = 3;
constexpr double kStepTolerance = 1e-8;
/// The noise an observation is allowed shrinks to its own by this factor a round, so that inliers
/// are not lost while the pose is still far.
constexpr double kShrink = 0.5;
constexpr double kFirstScale = 8;
constexpr int kMostTriples = 120;
constexpr std::size_t kMostFits = 8;
/// Another pose this probable, beside the best, makes the answer ambiguous.
constexpr double kAmbiguousShare = 0.05;

/// A pose, what it makes of every observation, and how probable all is.
struct Mode {
  Pose cam_from_centred;
  double scale = 1;  ///< of the noise, in the units of each observation's own
  double outlier_share = 0.3;
  std::vector<double> weights;  ///< the probability of each observation to be an inlier
  double log_likelihood = -INFINITY;
  Matrix6d covariance = Matrix6d::Zero();
};

/// The density of an outlier's residuals, as many numbers as the observation has, in units of its
/// noise: half of them anywhere in the image, half near.
class OutlierLaw {
 public:
  OutlierLaw(const Joint& joint, const Observed& observed, double image_unit_px)
      : numbers_(observed.numbers) {
    double variance_px2 = 0;
    if (observed.is_line) {
      double log_variance = 0;
      for (int k = 0; k < numbers_; ++k) {
        log_variance += std::log(joint.edges[observed.first + k].variance_px2) / numbers_;
      }
      variance_px2 = std::exp(log_variance);
    } else {
      variance_px2 = 1 / std::sqrt(joint.point_weights[observed.first].determinant());
    }
    range_ = image_unit_px / std::sqrt(variance_px2);
    near_ = std::max(kNearScale * range_, 3.0);
  }

  double density(double squares) const {
    const double even = std::pow(range_, -numbers_);
    const double k = squares / (near_ * near_);
    const double near = numbers_ == 2
                            ? 1 / (2 * std::numbers::pi * near_ * near_ * (1 + k / 2) * (1 + k / 2))
                            : 1 / (std::numbers::pi * near_ * (1 + k));
    return 0.5 * (even + near);
  }

 private:
  int numbers_;
  double range_, near_;
};

class MixtureFit {
 public:
  explicit MixtureFit(const Joint& joint) : joint_(joint), image_unit_px_(image_unit_px(joint)) {
    for (const Observed& observed : joint.observed) {
      laws_.emplace_back(joint, observed, image_unit_px_);
    }
  }

  /// The weights and the likelihood at the mode's pose, for the scale and share that it has.
  void weigh(Mode& mode) const {
    mode.weights.resize(laws_.size());
    mode.log_likelihood = 0;
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      const Observed& observed = joint_.observed[i];
      const auto squares = squares_of(joint_, observed, mode.cam_from_centred);
      const double variance = mode.scale * mode.scale;
      const double s = squares.value_or(INFINITY);
      const double inlier = (1 - mode.outlier_share) * std::exp(-0.5 * s / variance) /
                            std::pow(2 * std::numbers::pi * variance, 0.5 * observed.numbers);
      const double outlier = mode.outlier_share * laws_[i].density(squares ? s : 0.0);
      mode.weights[i] = squares ? inlier / (inlier + outlier) : 0;
      mode.log_likelihood += std::log(inlier + outlier);
    }
  }

  /// Expectation maximisation from the mode's pose. False where too little is left to fit.
  bool run(Mode& mode) const {
    mode.scale = kFirstScale;
    for (int round = 0; round < kMostRounds; ++round) {
      weigh(mode);
      const kernel::Fit fitted = fit(joint_, significant(mode.weights), mode.cam_from_centred,
                                     kStepsARound, kStepTolerance);
      if (fitted.status == kernel::FitStatus::kStartBehindCamera) return false;
      const Pose next = pose_from(fitted.pose);
      const bool is_still = change_between(mode.cam_from_centred, next).norm() <
                            kStepTolerance * (1 + next.translation.norm());
      mode.cam_from_centred = next;
      const bool is_settled = update(mode);
      if (is_still && is_settled) break;
    }
    weigh(mode);
    return take_covariance(mode);
  }

 private:
  /// Without those that hardly count and might have no residual a step on.
  static std::vector<double> significant(std::vector<double> weights) {
    constexpr double kLeast = 1e-6;
    for (double& weight : weights) {
      if (weight < kLeast) weight = 0;
    }
    return weights;
  }

  /// Noise and share of outliers; whether they hardly changed.
  bool update(Mode& mode) const {
    double inliers = 0, squares = 0, pairs = 0;
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      const Observed& observed = joint_.observed[i];
      inliers += mode.weights[i];
      pairs += mode.weights[i] * observed.numbers / 2;
      squares +=
          mode.weights[i] * squares_of(joint_, observed, mode.cam_from_centred).value_or(0.0);
    }
    const double n = static_cast<double>(laws_.size());
    mode.outlier_share = (n - inliers + kPriorOutliers) / (n + kPriorOutliers + kPriorInliers);
    const double noise = joint_.is_noise_known ? 1 : found_noise(squares, pairs - 3);
    const double next = std::max(noise, kShrink * mode.scale);
    const bool is_settled = std::abs(next - mode.scale) < 1e-3 * mode.scale;
    mode.scale = next;
    return is_settled;
  }

  double found_noise(double squares, double pairs) const {
    const double unit = image_unit_px_;
    return unit *
           std::sqrt(consensus::noise_posterior(squares / (unit * unit), pairs).most_probable);
  }

  /// The inverse of the information of the inliers, less what their doubt takes from it.
  bool take_covariance(Mode& mode) const {
    const double variance = mode.scale * mode.scale;
    const auto information =
        information_at(joint_, significant(mode.weights), mode.cam_from_centred);
    if (!information) return false;
    Matrix6d doubted = *information / variance;
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      const double doubt = mode.weights[i] * (1 - mode.weights[i]);
      if (doubt < 1e-9) continue;
      doubted -= doubt * outer_gradient(mode, i) / (variance * variance);
    }
    auto covariance = inverse_information(doubted);
    if (!covariance) covariance = inverse_information(*information / variance);
    if (!covariance) return false;
    mode.covariance = *covariance;
    return std::isfinite(mode.log_likelihood);
  }

  /// g g^T of half an observation's squares.
  Matrix6d outer_gradient(const Mode& mode, std::size_t index) const {
    const Observed& observed = joint_.observed[index];
    Vector6d gradient = Vector6d::Zero();
    if (!observed.is_line) {
      const auto r = reproject(joint_.points, observed.first, mode.cam_from_centred);
      if (!r) return Matrix6d::Zero();
      gradient = r->jacobian.transpose() * joint_.point_weights[observed.first] * r->residual_px;
      return gradient * gradient.transpose();
    }
    for (std::size_t k = observed.first; k < observed.first + observed.numbers; ++k) {
      EdgePoint edge = joint_.edges[k];
      edge.begin_in_target -= joint_.points.centroid_in_target;
      edge.end_in_target -= joint_.points.centroid_in_target;
      const auto r = edge_residual(edge, mode.cam_from_centred);
      if (r) gradient += r->jacobian.transpose() * r->residual_px / edge.variance_px2;
    }
    return gradient * gradient.transpose();
  }

  const Joint& joint_;
  double image_unit_px_;
  std::vector<OutlierLaw> laws_;
};

/// The poses that three observations ask for, near a start. Of many triples a sample that is spread
/// over all of them.
void add_triples(const Joint& joint, const Pose& start, std::vector<Pose>& poses) {
  const int n = static_cast<int>(joint.observed.size());
  const int all = n * (n - 1) * (n - 2) / 6;
  const int stride = (all + kMostTriples - 1) / kMostTriples;
  int index = 0;
  std::vector<double> weights(joint.observed.size(), 0);
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      for (int c = b + 1; c < n; ++c) {
        if (index++ % stride != 0) continue;
        for (const int i : {a, b, c}) weights[static_cast<std::size_t>(i)] = 1;
        const kernel::Fit fitted = fit(joint, weights, start, 20, kStepTolerance);
        for (const int i : {a, b, c}) weights[static_cast<std::size_t>(i)] = 0;
        const Pose pose = pose_from(fitted.pose);
        if (fitted.status == kernel::FitStatus::kConverged && is_valid(pose)) {
          poses.push_back(pose);
        }
      }
    }
  }
}

/// Of more observations even counting the triples takes longer than all else.
constexpr std::size_t kMostForTriples = 200;

/// With nothing to lead it: what least squares makes of all attitudes.
std::vector<Pose> free_hypotheses(const Joint& joint) {
  std::vector<Pose> poses = starts_over_attitudes(joint);
  for (Pose& pose : poses) {
    bool has_all = false;
    const kernel::Fit fitted = fit_all(joint, pose, 50, kStepTolerance, has_all);
    if (fitted.status == kernel::FitStatus::kConverged) pose = pose_from(fitted.pose);
  }
  return poses;
}

/// The poses of three observations near the first and the last of the starts.
std::vector<Pose> more_hypotheses(const Joint& joint, std::vector<Pose> starts) {
  if (joint.observed.size() > kMostForTriples) return starts;
  const Pose first = starts.front(), last = starts.back();
  const bool are_two = starts.size() > 1;
  add_triples(joint, last, starts);
  if (are_two) add_triples(joint, first, starts);
  return starts;
}

/// The most promising hypotheses, fitted; different ones, the most probable first.
std::vector<Mode> modes_of(const Joint& joint, const std::vector<Pose>& poses) {
  constexpr double kScreenScale = 3;
  const MixtureFit mixture(joint);
  std::vector<Mode> screened;
  for (const Pose& pose : poses) {
    Mode mode;
    mode.cam_from_centred = pose;
    mode.scale = kScreenScale;
    mixture.weigh(mode);
    screened.push_back(std::move(mode));
  }
  std::ranges::stable_sort(screened, std::ranges::greater(), &Mode::log_likelihood);
  if (screened.size() > kMostFits) screened.resize(kMostFits);
  std::vector<Mode> modes;
  for (Mode& mode : screened) {
    if (!mixture.run(mode)) continue;
    const auto is_same = [&mode](const Mode& other) {
      const Vector6d step = change_between(other.cam_from_centred, mode.cam_from_centred);
      const auto information = inverse_information(other.covariance);
      return information && step.dot(*information * step) < consensus::kFarDistance2;
    };
    const auto same = std::ranges::find_if(modes, is_same);
    if (same == modes.end()) {
      modes.push_back(std::move(mode));
    } else if (same->log_likelihood < mode.log_likelihood) {
      *same = std::move(mode);
    }
  }
  std::ranges::stable_sort(modes, std::ranges::greater(), &Mode::log_likelihood);
  return modes;
}

/// Between two poses that both are probable the initial pose decides.
void prefer_initial(const Joint& joint, Mode& best, Mode& other) {
  if (!joint.initial_cam_from_centred) return;
  const auto distance = [&](const Mode& mode) {
    const Pose& initial = *joint.initial_cam_from_centred;
    return geodesic_angle_rad(mode.cam_from_centred.rotation, initial.rotation) +
           (mode.cam_from_centred.translation - initial.translation).norm() /
               initial.translation.norm();
  };
  if (distance(other) < distance(best)) std::swap(best, other);
}

/// What the observations that are kept say.
struct Kept {
  int count = 0;
  int numbers = 0;
  double squares = 0;
  double log_odds = 0;  ///< of the observations as inliers against all as outliers
};

Kept keep(const Joint& joint, const Mode& mode) {
  Kept kept;
  for (std::size_t i = 0; i < joint.observed.size(); ++i) {
    if (!(mode.weights[i] > 0.5)) continue;
    ++kept.count;
    kept.numbers += joint.observed[i].numbers;
    const double squares =
        squares_of(joint, joint.observed[i], mode.cam_from_centred).value_or(0.0);
    kept.squares += squares;
    kept.log_odds += std::log(mode.weights[i] / std::max(1 - mode.weights[i], 1e-300));
  }
  return kept;
}

/// Whether a mode keeps every observation, and what they leave looks like the noise that is known.
bool explains_all(const Joint& joint, const Mode& mode, double false_alarm_rate) {
  if (!joint.is_noise_known ||
      std::ranges::any_of(mode.weights, [](double w) { return w < 0.9; })) {
    return false;
  }
  const Kept kept = keep(joint, mode);
  return kept.numbers > 6 &&
         kept.squares <= consensus::chi_square_limit(kept.numbers - 6, false_alarm_rate);
}

Diagnosis diagnosis_of(const Joint& joint, const Mode& mode, const Kept& kept,
                       std::size_t hypotheses, double false_alarm_rate) {
  Diagnosis diagnosis;
  double log_set = 0;
  for (const double w : mode.weights) log_set += std::log(std::max(w, 1 - w));
  diagnosis.removed_probability = std::exp(log_set);
  const int redundant = kept.numbers - 6;
  const bool has_removed = kept.count < static_cast<int>(joint.observed.size());
  diagnosis.is_removal_limit_reached = has_removed && redundant < 2;
  if (joint.is_noise_known) {
    diagnosis.is_test_failed =
        redundant > 0 && kept.squares > consensus::chi_square_limit(redundant, false_alarm_rate);
  }
  // Six numbers are met by chance; the others speak for the pose, against as many tries.
  const double odds_a_number = kept.numbers > 0 ? kept.log_odds / kept.numbers : 0;
  constexpr double kLeastLogOdds = 7;  // one of a thousand
  diagnosis.is_significant =
      redundant > 0 &&
      redundant * odds_a_number - std::log(static_cast<double>(hypotheses)) > kLeastLogOdds;
  return diagnosis;
}

void take_indices(const Joint& joint, const Mode& mode, PoseEstimate& estimate,
                  std::size_t points) {
  std::vector<double> probabilities(points, 0);
  for (std::size_t i = 0; i < joint.observed.size(); ++i) {
    const Observed& observed = joint.observed[i];
    const auto index = static_cast<std::size_t>(observed.given_index);
    if (!observed.is_line) probabilities[index] = mode.weights[i];
    if (mode.weights[i] > 0.5) continue;
    (observed.is_line ? estimate.removed_lines : estimate.removed).push_back(observed.given_index);
  }
  estimate.inlier_probabilities = std::move(probabilities);
}

}  // namespace

PoseEstimate solve_consensus(const PoseProblem& problem, const SolverOptions& options) {
  PreparedJoint prepared = prepare_joint(problem);
  Joint& joint = prepared.joint;
  PoseEstimate estimate;
  estimate.status = prepared.status;
  estimate.ignored = joint.ignored;
  estimate.ignored_lines = joint.ignored_lines;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const double false_alarm_rate = options.outliers.false_alarm_rate;
  std::vector<Pose> poses =
      starts_of(joint, sightline::solve_consensus(points_of(problem), options));
  std::vector<Mode> modes = modes_of(joint, poses);
  const auto look_further = [&] {
    if (poses.empty() || (!modes.empty() && explains_all(joint, modes[0], false_alarm_rate))) {
      return;
    }
    poses = more_hypotheses(joint, std::move(poses));
    modes = modes_of(joint, poses);
  };
  look_further();
  if (modes.empty()) {
    poses = free_hypotheses(joint);
    modes = modes_of(joint, poses);
    look_further();
  }
  estimate.status = PoseStatus::kDegenerate;
  if (modes.empty()) return estimate;
  if (modes.size() > 1 &&
      modes[1].log_likelihood - modes[0].log_likelihood > std::log(kAmbiguousShare)) {
    prefer_initial(joint, modes[0], modes[1]);
    estimate.second_cam_from_target = from_centred(modes[1].cam_from_centred, joint.points);
  }
  const Mode& mode = modes.front();
  const Kept kept = keep(joint, mode);
  const Pose pose = from_centred(mode.cam_from_centred, joint.points);
  if (kept.numbers < 6 || !is_valid(pose)) return estimate;

  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = pose;
  estimate.iterations = static_cast<int>(poses.size());
  estimate.covariance =
      covariance_from_centred(mode.covariance, mode.cam_from_centred, joint.points);
  estimate.unit_covariance = *estimate.covariance / (mode.scale * mode.scale);
  estimate.noise_px = mode.scale;
  estimate.residual_rms_px = std::sqrt(kept.squares / kept.numbers);
  take_indices(joint, mode, estimate, problem.pixels.size());
  estimate.diagnosis = diagnosis_of(joint, mode, kept, poses.size(), false_alarm_rate);
  estimate.diagnosis->is_ambiguous = estimate.second_cam_from_target.has_value();
  estimate.diagnosis->most_probable_cam_from_target = pose;
  return estimate;
}

}  // namespace sightline::lines
