// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/few_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"
#include "pose/consensus/noise.h"
#include "pose/consensus/score.h"
#include "pose/packed_points.h"
#include "pose/point_spread.h"
#include "pose/removal_hypotheses.h"
#include "pose/removal_sets.h"
#include "pose/reprojection.h"
#include "pose/robust.h"
#include "pose/starts.h"

namespace sightline::consensus {
namespace {

constexpr std::size_t kFewestKept = 5;
/// So probable must the set be that is removed.
constexpr double kProbablyRemoved = 0.2;
/// So many other poses of three points may be expected to be agreed with as well, by chance.
constexpr double kOtherPoses = 0.01;
/// The root of the sum of squares, in deviations of the noise, that the target's thickness has in
/// the image where its mirror pose does not fit: seen at 15 degrees it leaves half of it.
constexpr double kThickness = 20;
/// Of the image's root area: how far outliers err. Wider than the near ones of mixture.h, for the
/// linear model has no even density beside it, and outliers of four times the scale cost it a
/// second look.
constexpr double kOutlierScale = 0.06;

/// What does not depend on the start.
struct Few {
  WhitenedCorrespondences points;
  double image_unit_px = 1;
  double typical_noise_px = 1;
  Eigen::Matrix3d scatter;  ///< of the points

  /// The sum of the squared distances of the points from the plane that is nearest to them, at
  /// least.
  double least_thickness2() const { return scatter.determinant() / second_invariant(scatter); }
  std::size_t size() const { return points.size(); }
  bool is_whitened() const { return !points.whitening.empty(); }
  /// The image's area in the units of a point's noise, as Cloud::area.
  double area(std::size_t i) const {
    const double area_px2 = image_unit_px * image_unit_px;
    return is_whitened() ? area_px2 * std::abs(points.whitening[i].determinant()) : area_px2;
  }
  /// As a part of the image's root area.
  double outlier_scale() const {
    return std::max(kOutlierScale, 3 * typical_noise_px / image_unit_px);
  }
};

/// The problem must have no initial pose.
std::optional<Few> few_points(const PoseProblem& problem) {
  const std::size_t n = problem.pixels.size();
  if (n < kFewestKept || n > kMostOfFew) return std::nullopt;
  if (problem.covariances_px2.empty() && !(problem.sigma_px > 0)) return std::nullopt;
  PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return std::nullopt;
  const Eigen::Matrix3d scatter = moments_of(prepared.correspondences.points.points_in_centred);
  if (!is_clearly_solid(scatter)) return std::nullopt;
  Few few = {std::move(prepared.correspondences), 1, problem.sigma_px, scatter};
  if (few.is_whitened()) {
    std::array<double, kMostOfFew> radii;
    for (std::size_t i = 0; i < n; ++i) {
      radii[i] = 1 / std::sqrt(std::abs(few.points.whitening[i].determinant()));
    }
    std::nth_element(radii.begin(), radii.begin() + n / 2, radii.begin() + n);
    few.typical_noise_px = radii[n / 2];
  }
  few.image_unit_px = image_unit_px(few.points.points.pixels, few.typical_noise_px);
  if (!(few.image_unit_px > 0)) return std::nullopt;
  return few;
}

RemovalModel model_of(const Few& few) {
  OutlierOptions options;
  options.scale_px = few.outlier_scale() * few.image_unit_px;
  return removal_model(few.points, options);
}

bool is_mirror_pose_excluded(const Few& few, const Pose& cam_from_centred) {
  const Correspondences& c = few.points.points;
  const double scale_px = std::min(c.fx_px, c.fy_px) / cam_from_centred.translation.z();
  const double least_px = kThickness * few.typical_noise_px;
  return few.least_thickness2() * scale_px * scale_px > least_px * least_px;
}

/// What the points say at the pose of the answer.
struct AtAnswer {
  double kept_squares = 0;     ///< whitened
  double largest_of_area = 0;  ///< of the kept points, as a part of the image's area
  std::vector<double> probabilities;
  double other_poses = 0;  ///< that by chance are agreed with as well
  bool is_significant = false;
};

/// The chance that a point which has nothing to do with the pose agrees as well as those kept.
double chance_of_agreement(const Few& few, double largest_of_area) {
  const double sigma = few.points.sigma / few.image_unit_px;
  const double least = few.is_whitened() ? kLeastSquare : sigma * sigma;
  return std::numbers::pi * std::max(largest_of_area, least);
}

/// Of clouds without any pose, how many poses of three points so many others agree with as well.
double chance_poses(double n, double kept, double chance) {
  double others = 1;  // ways to choose kept - 3 of n - 3, and the chance of each
  for (double k = 1; k <= kept - 3; ++k) others *= (n - 3 - (k - 1)) / k * chance;
  return 4 * n * (n - 1) * (n - 2) / 6 * others;
}

/// As of the search.
bool is_significant(double n, double kept, double chance) {
  const double share = (kept - 3) / (n - 3);
  if (!(chance < std::min(share, kWidestSignificant))) return false;
  const double triples = n * (n - 1) * (n - 2) / 6;
  return (n - 3) * bernoulli_divergence(share, chance) > least_log_improbability(triples, n);
}

/// None where a point that is kept is not in front of the camera.
std::optional<AtAnswer> look_at(const Few& few, const MeanOverRemovals& mean) {
  const std::size_t n = few.size();
  AtAnswer at;
  at.probabilities.assign(n, 0);
  double total = 0;
  for (const RemovalHypothesis& h : mean.chosen->hypotheses) {
    const double weight = std::exp(h.log_weight - mean.best.log_weight);
    total += weight;
    for (double& p : at.probabilities) p += weight;
    for (const int i : h.set.span()) at.probabilities[i] -= weight;
  }
  const double variance = few.points.sigma * few.points.sigma;
  const double outliers = mean.best.set.size;
  const double share =
      (outliers + kPriorOutliers) / (static_cast<double>(n) + kPriorOutliers + kPriorInliers);
  OutlierLaw law;
  law.scale2 = few.outlier_scale() * few.outlier_scale();
  const auto removed = mean.best.set.span();
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_removed = std::ranges::find(removed, i) != removed.end();
    const std::optional<Eigen::Vector2d> r = whitened_residual(few.points, i, mean.mean);
    if (!r && !is_removed) return std::nullopt;
    const double square = r ? r->squaredNorm() : kernel::kNotSeen;
    const double inlier =
        (1 - share) / (2 * std::numbers::pi * variance) * std::exp(-0.5 * square / variance);
    const double area = few.area(i);
    at.probabilities[i] *= inlier / (inlier + share * law.density(square, area)) / total;
    if (is_removed) continue;
    at.kept_squares += square;
    at.largest_of_area = std::max(at.largest_of_area, square / area);
  }
  const double count = static_cast<double>(n), kept = count - mean.best.set.size;
  const double chance = chance_of_agreement(few, at.largest_of_area);
  at.other_poses = chance_poses(count, kept, chance);
  at.is_significant = is_significant(count, kept, chance);
  return at;
}

bool is_doubtful(const RemovalModel& s, const MeanOverRemovals& mean) {
  const std::size_t kept = static_cast<std::size_t>(s.n() - mean.best.set.size);
  return kept < kFewestKept || mean.is_ambiguous || mean.best_probability < kProbablyRemoved ||
         !is_explained(s, mean.best);
}

/// Whether nothing is removed nor thought of, so that the mean is the best pose of all points.
bool is_certain(const MeanOverRemovals& mean) {
  return mean.best.set.size == 0 && mean.chosen->hypotheses.size() == 1;
}

PoseEstimate estimate_from(const Few& few, const MeanOverRemovals& mean, const FitOfKept& kept,
                           AtAnswer at, double false_alarm_rate) {
  const Correspondences& c = few.points.points;
  const RemovalSet& removed = mean.best.set;
  const double count = static_cast<double>(few.size()) - removed.size;
  PoseEstimate estimate;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = from_centred(mean.mean, c);
  estimate.removed.assign(removed.span().begin(), removed.span().end());
  const double variance = few.points.sigma * few.points.sigma;
  estimate.covariance = covariance_from_centred(mean.covariance, mean.mean, c);
  estimate.unit_covariance = is_certain(mean) && !few.is_whitened()
                                 ? Matrix6d(*estimate.covariance / variance)
                                 : covariance_from_centred(kept.unit_covariance, mean.mean, c);
  estimate.iterations = mean.chosen->iterations;
  estimate.residual_rms_px = std::sqrt(at.kept_squares / (2 * count));
  estimate.noise_px = few.points.sigma;
  estimate.inlier_probabilities = std::move(at.probabilities);
  Diagnosis& diagnosis = estimate.diagnosis.emplace();
  diagnosis.is_ambiguous = false;
  diagnosis.removed_probability = mean.best_probability;
  diagnosis.is_removal_limit_reached = false;
  diagnosis.is_test_failed =
      at.kept_squares > variance * chi_square_limit(2 * count - 6, false_alarm_rate);
  diagnosis.most_probable_cam_from_target = from_centred(kept.pose, c);
  diagnosis.is_significant = at.is_significant;
  return estimate;
}

/// fit_kept, which where nothing is removed and all points have one noise is the best pose.
std::optional<FitOfKept> fit_of(const Few& few, const RemovalModel& s, const PackedPoints& packed,
                                const MeanOverRemovals& mean) {
  if (mean.best.set.size > 0 || few.is_whitened()) return fit_kept(s, packed, mean.best);
  return FitOfKept{mean.best.pose, mean.best_covariance / (few.points.sigma * few.points.sigma)};
}

/// The answer from one start, where it is decisive.
PoseEstimate decide(const Few& few, const RemovalModel& s, const PackedPoints& packed,
                    const Pose& start, double false_alarm_rate) {
  Linearisation room;
  const RemovalBranch branch = removals_from(s, packed, start, RemovalEffort::kOnlySmall, room);
  if (branch.status != PoseStatus::kOk) return {};
  const std::optional<MeanOverRemovals> mean = mean_over_removals({&branch, 1}, s);
  if (!mean || is_doubtful(s, *mean) || !is_mirror_pose_excluded(few, mean->mean)) return {};
  std::optional<AtAnswer> at = look_at(few, *mean);
  if (!at || !(at->other_poses < kOtherPoses)) return {};
  const std::optional<FitOfKept> fit = fit_of(few, s, packed, *mean);
  if (!fit) return {};
  return estimate_from(few, *mean, *fit, std::move(*at), false_alarm_rate);
}

}  // namespace

PoseEstimate estimate_of_few(const PoseProblem& problem, double false_alarm_rate) {
  if (problem.pixels.size() > kMostOfFew) return {};
  if (problem.initial_cam_from_target) {
    PoseProblem free = problem;
    free.initial_cam_from_target.reset();
    return estimate_of_few(free, false_alarm_rate);
  }
  const std::optional<Few> few = few_points(problem);
  if (!few) return {};
  const RemovalModel s = model_of(*few);
  const PackedPoints points = packed(s);
  const Correspondences& c = few->points.points;
  if (const std::optional<Pose> start = weak_perspective_start(c)) {
    return decide(*few, s, points, *start, false_alarm_rate);
  }
  PoseEstimate estimate;
  for (const Pose& start : starting_poses(c, std::nullopt)) {
    estimate = decide(*few, s, points, start, false_alarm_rate);
    if (estimate.status == PoseStatus::kOk) break;
  }
  return estimate;
}

}  // namespace sightline::consensus
