// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// One estimator for any number of points, any share of outliers and any start.
//
//   1. Points that cannot be used are left out and listed (pose/consensus/cloud.h).
//   2. Poses of three points, all or drawn ones, are screened and scored; the best are fitted
//      (search.h). An initial pose is one more of them, and a mode of a nearly planar target brings
//      its mirror pose. Of six to twelve points of a solid target with noise that is known the
//      small sets of orpe_weighed are swept first: where one is decisive, its pose is the only one
//      that is fitted.
//   3. A fit weighs every point by its probability of being an inlier, the law being a mixture of
//      noise (known, by covariances, or found) and outliers (anywhere, or near): expectation
//      maximisation with Gauss-Newton steps (mixture.h).
//   4. The modes found are carried to the end. The answer is that of the mode of the most evidence:
//      the mean over the sets of inliers that are probable (answer.h). Another mode that is
//      probable and far away is the second pose, and makes the answer ambiguous.
//
// Ours, after RANSAC (Fischler and Bolles 1981), its local optimisation (Chum, Matas, Kittler
// 2003), a-contrario model estimation (Moisan and Stival 2004) and mixture models of outliers.
//
// Needs four different points that can be used and are not collinear, or three with an initial
// pose: then the pose of three points (pose/p3p.h) that is nearest to it. The noise is that of
// covariances_px2, else sigma_px; where neither is given it is found. No constant is in pixels:
// what an outlier may do is measured by the spread of the pixels, so that normalised coordinates
// with K = I give the same answer. Uses LspeOptions::step_tolerance and OutlierOptions not at all
// but for false_alarm_rate, the level of the test of the residuals of the points kept.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "pose/consensus/answer.h"
#include "pose/consensus/cloud.h"
#include "pose/consensus/score.h"
#include "pose/consensus/search.h"
#include "pose/p3p.h"
#include "pose/reprojection.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

using consensus::Answer;
using consensus::Cloud;
using consensus::Row;

/// Another mode this probable, and this far away, makes the answer ambiguous.
constexpr double kAmbiguousShare = 0.05;
/// The chance, at most, that data without any pose are called significant.
constexpr double kChanceSignificance = 0.01;

/// Few points with noise that is known have the removals of orpe_weighed as a start.
constexpr std::size_t kMostAtOnce = 12;
constexpr std::size_t kFewestAtOnce = 6;
constexpr std::size_t kFewestKeptAtOnce = 5;
/// So probable must the set be that it removed; the doubtful points about it are tried both ways.
constexpr double kProbablyRemoved = 0.5;

/// The most probable answer and what competes with it.
struct Verdict {
  Answer answer;
  std::optional<Pose> second;  ///< cam_from_centred
};

Vector6d step_between(const Pose& from, const Pose& to) {
  Vector6d step;
  step << vector_from_rotation(to.rotation * from.rotation.transpose()),
      to.translation - from.translation;
  return step;
}

std::optional<Verdict> judge(const Cloud& cloud, const consensus::ModeList& modes) {
  std::vector<Answer> answers;
  for (const consensus::Mode& mode : modes.all()) {
    Answer answer;
    if (consensus::answer_of(cloud, mode, answer)) answers.push_back(std::move(answer));
  }
  if (answers.empty()) return std::nullopt;
  const auto best = std::ranges::max_element(answers, {}, &Answer::log_evidence);
  const std::optional<Matrix6d> information = inverse_information(best->covariance);
  if (!information) return std::nullopt;
  double total = 0;
  for (const Answer& a : answers) total += std::exp(a.log_evidence - best->log_evidence);
  Verdict verdict;
  double largest = kAmbiguousShare;
  if (best->far_share / total > largest) {
    largest = best->far_share / total;
    verdict.second = best->far_cam_from_centred;
  }
  for (const Answer& other : answers) {
    const double share = std::exp(other.log_evidence - best->log_evidence) / total;
    const Vector6d step = step_between(best->cam_from_centred, other.cam_from_centred);
    if (&other == &*best || !(share > largest)) continue;
    if (!(step.dot(*information * step) > consensus::kFarDistance2)) continue;
    largest = share;
    verdict.second = other.cam_from_centred;
  }
  verdict.answer = std::move(*best);
  return verdict;
}

/// The chi-square quantile by the cube root of Wilson and Hilferty (1931); z is that of the normal.
double chi_square_quantile(double degrees, double z) {
  const double spread = 2 / (9 * degrees);
  const double root = 1 - spread + z * std::sqrt(spread);
  return degrees * root * root * root;
}

/// The upper quantile of the normal law (Abramowitz and Stegun 26.2.23).
double normal_quantile(double tail) {
  const double t = std::sqrt(-2 * std::log(std::clamp(tail, 1e-12, 0.5)));
  return t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                 (1 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

/// What the points that are kept say at the answer.
struct Kept {
  int count = 0;
  double squares = 0;  ///< whitened
  Matrix6d information = Matrix6d::Zero();
};

/// Points of the most probable set that the mean pose puts behind the camera are not kept.
Kept keep(const Cloud& cloud, Answer& answer) {
  Kept kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!answer.is_inlier[i]) continue;
    Row row;
    answer.is_inlier[i] = consensus::row_at(cloud, answer.cam_from_centred, i, row);
    if (!answer.is_inlier[i]) continue;
    const Eigen::Map<const Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> j(row.jacobian[0]);
    ++kept.count;
    kept.squares += row.squared();
    kept.information.noalias() += j.transpose() * j;
  }
  return kept;
}

/// What does not depend on how the pose was found.
PoseEstimate estimate_from(const Cloud& cloud, Answer& answer) {
  PoseEstimate estimate;
  estimate.ignored = cloud.ignored;
  const Kept kept = keep(cloud, answer);
  const std::optional<Matrix6d> unit = inverse_information(kept.information);
  const bool is_whitened = !cloud.whitening.empty();
  const double unit_px = is_whitened ? 1 : cloud.image_unit_px;
  const Pose pose = consensus::from_cloud(answer.cam_from_centred, cloud);
  if (kept.count < kMinimumPosePointsFromInitial || !unit || !is_valid(pose)) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = pose;
  estimate.unit_covariance =
      consensus::covariance_from_cloud(*unit / (unit_px * unit_px), answer.cam_from_centred, cloud);
  estimate.residual_rms_px = std::sqrt(kept.squares / (2 * kept.count)) * unit_px;
  std::vector<double> probabilities(cloud.size() + cloud.ignored.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    probabilities[cloud.given_index[i]] = answer.probabilities[i];
    if (!answer.is_inlier[i]) estimate.removed.push_back(cloud.given_index[i]);
  }
  std::ranges::sort(estimate.removed);
  estimate.inlier_probabilities = std::move(probabilities);
  return estimate;
}

/// Whether the points kept leave more than noise of the size that is known would; none where it is
/// not known.
std::optional<bool> is_test_failed(const Cloud& cloud, const PoseEstimate& estimate,
                                   double false_alarm_rate) {
  if (!cloud.is_sigma_known()) return std::nullopt;
  const double kept = static_cast<double>(cloud.size() - estimate.removed.size());
  const double unit_px = cloud.whitening.empty() ? cloud.image_unit_px : 1;
  const double residual = *estimate.residual_rms_px / (cloud.sigma * unit_px);
  const double degrees = 2 * kept - 6;
  if (!(degrees > 0)) return false;
  const double limit = chi_square_quantile(degrees, normal_quantile(false_alarm_rate));
  return 2 * kept * residual * residual > limit;
}

/// With three points: the pose that meets them exactly and is nearest to the initial one.
PoseEstimate solve_three_points(const Cloud& cloud) {
  std::array<Eigen::Vector3d, 3> points, rays;
  for (std::size_t i = 0; i < 3; ++i) {
    points[i] = cloud.points_in_centred[i];
    rays[i] = cloud.image[i].cwiseQuotient(cloud.focal).homogeneous();
  }
  const Pose& initial = *cloud.initial_cam_from_centred;
  const auto distance = [&initial](const Pose& pose) {
    return geodesic_angle_rad(pose.rotation, initial.rotation) +
           (pose.translation - initial.translation).norm() / initial.translation.norm();
  };
  const P3pPoses poses = p3p(points, rays);
  if (poses.count == 0) return estimate_of_failure(PoseStatus::kDegenerate);
  Answer answer;
  answer.cam_from_centred = *std::ranges::min_element(poses.all(), {}, distance);
  answer.probabilities.assign(3, 1);
  answer.is_inlier.assign(3, true);
  PoseEstimate estimate = estimate_from(cloud, answer);
  if (estimate.status != PoseStatus::kOk) return estimate;
  Diagnosis diagnosis;
  diagnosis.is_removal_limit_reached = true;
  diagnosis.removed_probability = 1;
  diagnosis.most_probable_cam_from_target = estimate.cam_from_target;
  diagnosis.is_significant = false;
  diagnosis.is_ambiguous = false;
  for (const Pose& other : poses.all()) {
    // A double root comes twice.
    constexpr double kSameRad = 1e-6;
    const Pose& best = answer.cam_from_centred;
    if (geodesic_angle_rad(other.rotation, best.rotation) < kSameRad) continue;
    const Pose pose = consensus::from_cloud(other, cloud);
    const bool is_first = !estimate.second_cam_from_target.has_value();
    if (is_first ||
        distance(other) < distance(consensus::to_cloud(*estimate.second_cam_from_target, cloud))) {
      estimate.second_cam_from_target = pose;
    }
    diagnosis.is_ambiguous = true;
  }
  if (cloud.is_sigma_known()) {
    const double noise = cloud.whitening.empty() ? cloud.sigma * cloud.image_unit_px : 1;
    estimate.noise_px = noise;
    estimate.covariance = noise * noise * estimate.unit_covariance;
  }
  estimate.diagnosis = diagnosis;
  return estimate;
}

/// The problem without the points that cannot be used and without an initial pose.
PoseProblem usable_problem(const PoseProblem& problem, const Cloud& cloud) {
  PoseProblem usable;
  usable.camera = problem.camera;
  usable.sigma_px = problem.sigma_px;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    if (std::ranges::binary_search(cloud.ignored, static_cast<int>(i))) continue;
    usable.points_in_target.push_back(problem.points_in_target[i]);
    usable.pixels.push_back(problem.pixels[i]);
    if (problem.covariances_px2.empty()) continue;
    usable.covariances_px2.push_back(problem.covariances_px2[i]);
  }
  return usable;
}

/// The start that a sweep over small sets of removals gives in some microseconds, where it is
/// decisive: what it keeps looks like noise, and no other set or pose is nearly as probable.
std::optional<Pose> decisive_start(const PoseProblem& problem, const Cloud& cloud) {
  const std::size_t n = cloud.size();
  if (n < kFewestAtOnce || n > kMostAtOnce) return std::nullopt;
  if (!cloud.is_sigma_known()) return std::nullopt;
  if (!is_clearly_solid(cloud.points_in_centred)) return std::nullopt;
  SolverOptions options;  // no number in pixels: normalised coordinates give the same answer
  options.outliers.scale_px = std::sqrt(consensus::outlier_law(cloud).scale2) * cloud.image_unit_px;
  const bool is_whole = cloud.ignored.empty() && !problem.initial_cam_from_target;
  const PoseEstimate swept =
      solve_orpe_weighed(is_whole ? problem : usable_problem(problem, cloud), options);
  if (swept.status != PoseStatus::kOk || n - swept.removed.size() < kFewestKeptAtOnce) {
    return std::nullopt;
  }
  const Diagnosis& said = *swept.diagnosis;
  const bool is_doubtful = said.is_ambiguous.value_or(true) || said.is_test_failed.value_or(true) ||
                           said.removed_probability.value_or(0) < kProbablyRemoved;
  if (is_doubtful) return std::nullopt;
  return consensus::to_cloud(*said.most_probable_cam_from_target, cloud);
}

/// The mode at that start, in place of a search.
std::optional<consensus::Found> found_at_once(const PoseProblem& problem, const Cloud& cloud) {
  const std::optional<Pose> start = decisive_start(problem, cloud);
  if (!start) return std::nullopt;
  consensus::Mode mode;
  mode.cam_from_centred = *start;
  mode.law = consensus::outlier_law(cloud);
  if (!consensus::fit_mixture(cloud, cloud.sigma, {30, 1e-7}, mode)) return std::nullopt;
  if (mode.inliers < kFewestKeptAtOnce - 0.5) return std::nullopt;
  mode.is_decisive = true;
  consensus::Found found;
  const int n = static_cast<int>(cloud.size());
  found.triples = n * (n - 1) * (n - 2) / 6;  // that it stands for
  found.fits = 1;
  found.modes.add(std::move(mode));
  return found;
}

}  // namespace

PoseEstimate solve_consensus(const PoseProblem& problem, const SolverOptions& options) {
  const consensus::PreparedCloud prepared = consensus::prepare_cloud(problem);
  const Cloud& cloud = prepared.cloud;
  PoseEstimate failure = estimate_of_failure(prepared.status);
  failure.ignored = cloud.ignored;
  if (prepared.status != PoseStatus::kOk) return failure;
  if (cloud.size() == 3) return solve_three_points(cloud);

  const std::optional<consensus::Found> at_once = found_at_once(problem, cloud);
  const consensus::Found found = at_once ? *at_once : consensus::search(cloud);
  std::optional<Verdict> verdict = judge(cloud, found.modes);
  failure.status = PoseStatus::kDegenerate;
  if (!verdict) return failure;
  Answer& answer = verdict->answer;
  PoseEstimate estimate = estimate_from(cloud, answer);
  estimate.iterations = found.fits;
  if (estimate.status != PoseStatus::kOk) return estimate;

  estimate.covariance =
      consensus::covariance_from_cloud(answer.covariance, answer.cam_from_centred, cloud);
  const double unit_px = cloud.whitening.empty() ? cloud.image_unit_px : 1;
  estimate.noise_px = std::sqrt(answer.variance) * unit_px;
  Diagnosis diagnosis;
  diagnosis.is_ambiguous = verdict->second.has_value();
  if (verdict->second) {
    estimate.second_cam_from_target = consensus::from_cloud(*verdict->second, cloud);
  }
  diagnosis.removed_probability = answer.set_probability;
  const auto kept = cloud.size() - estimate.removed.size();
  diagnosis.is_removal_limit_reached = kept <= kMinimumPosePoints && cloud.size() > kept;
  diagnosis.is_test_failed = is_test_failed(cloud, estimate, options.outliers.false_alarm_rate);
  diagnosis.most_probable_cam_from_target = consensus::from_cloud(answer.most_probable, cloud);
  // Of all poses that were tried, and all radii about them.
  const double n = static_cast<double>(cloud.size());
  const double log_tests = std::log(3.0 * found.triples) + std::log(64 * n);
  consensus::Scorer scorer(cloud);
  diagnosis.is_significant =
      scorer.log_improbability(answer.most_probable) > log_tests - std::log(kChanceSignificance);
  estimate.diagnosis = diagnosis;
  return estimate;
}

}  // namespace sightline
