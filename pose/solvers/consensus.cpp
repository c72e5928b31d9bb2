// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// One estimator for any number of points, any share of outliers and any start.
//
//   1. Points that cannot be used are left out and listed (pose/consensus/cloud.h).
//   2. Poses of three points, all or drawn ones, are screened and scored; the best are fitted
//      (search.h). An initial pose is one more of them, and a mode of a nearly planar target brings
//      its mirror pose.
//   3. A fit weighs every point by its probability of being an inlier, the law being a mixture of
//      noise (known, by covariances, or found) and outliers (anywhere, or near): expectation
//      maximisation with Gauss-Newton steps (mixture.h).
//   4. The modes found are carried to the end. The answer is that of the mode of the most evidence:
//      the mean over the sets of inliers that are probable (answer.h). Another mode that is
//      probable and far away is the second pose, and makes the answer ambiguous.
//
// Of five to twelve points of a solid target with noise that is known small sets of removals are
// swept first, about one pose: where one is decisive the other sets and poses need not be looked
// at, and the answer is the mean over the sets, as of 4 (pose/consensus/few_points.h).
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
#include "pose/consensus/few_points.h"
#include "pose/consensus/noise.h"
#include "pose/consensus/score.h"
#include "pose/consensus/search.h"
#include "pose/p3p.h"
#include "pose/pose.h"
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

/// The most probable answer and what competes with it.
struct Verdict {
  Answer answer;
  std::optional<Pose> second;  ///< cam_from_centred
};

/// How far a pose is from the initial one.
double distance_from_initial(const Pose& pose, const Pose& initial) {
  return geodesic_angle_rad(pose.rotation, initial.rotation) +
         (pose.translation - initial.translation).norm() / initial.translation.norm();
}

/// Between two poses that both are probable the initial pose decides.
void prefer_initial(const Cloud& cloud, Answer& best, Answer& other) {
  if (!cloud.initial_cam_from_centred) return;
  const Pose& initial = *cloud.initial_cam_from_centred;
  if (distance_from_initial(other.cam_from_centred, initial) <
      distance_from_initial(best.cam_from_centred, initial)) {
    std::swap(best, other);
  }
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
  Answer* second = nullptr;
  for (Answer& other : answers) {
    const double share = std::exp(other.log_evidence - best->log_evidence) / total;
    const Vector6d step = change_between(best->cam_from_centred, other.cam_from_centred);
    if (&other == &*best || !(share > largest)) continue;
    if (!(step.dot(*information * step) > consensus::kFarDistance2)) continue;
    largest = share;
    second = &other;
  }
  if (second != nullptr) {
    prefer_initial(cloud, *best, *second);
    verdict.second = second->cam_from_centred;
  }
  verdict.answer = std::move(*best);
  return verdict;
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
  return 2 * kept * residual * residual > consensus::chi_square_limit(degrees, false_alarm_rate);
}

/// With three points: the pose that meets them exactly and is nearest to the initial one.
PoseEstimate solve_three_points(const Cloud& cloud) {
  std::array<Eigen::Vector3d, 3> points, rays;
  for (std::size_t i = 0; i < 3; ++i) {
    points[i] = cloud.points_in_centred[i];
    rays[i] = cloud.image[i].cwiseQuotient(cloud.focal).homogeneous();
  }
  const auto distance = [&initial = *cloud.initial_cam_from_centred](const Pose& pose) {
    return distance_from_initial(pose, initial);
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

/// What is said of an estimate beyond its pose.
Diagnosis diagnosis_of(const Cloud& cloud, const Verdict& verdict, const PoseEstimate& estimate,
                       int triples, double false_alarm_rate) {
  const Answer& answer = verdict.answer;
  Diagnosis diagnosis;
  diagnosis.is_ambiguous = verdict.second.has_value();
  diagnosis.removed_probability = answer.set_probability;
  const auto kept = cloud.size() - estimate.removed.size();
  diagnosis.is_removal_limit_reached = kept <= kMinimumPosePoints && cloud.size() > kept;
  diagnosis.is_test_failed = is_test_failed(cloud, estimate, false_alarm_rate);
  diagnosis.most_probable_cam_from_target = consensus::from_cloud(answer.most_probable, cloud);
  const double n = static_cast<double>(cloud.size());
  consensus::Scorer scorer(cloud);
  diagnosis.is_significant = scorer.log_improbability(answer.most_probable) >
                             consensus::least_log_improbability(triples, n);
  return diagnosis;
}

PoseEstimate estimate_by_search(const Cloud& cloud, double false_alarm_rate) {
  const consensus::Found found = consensus::search(cloud);
  std::optional<Verdict> verdict = judge(cloud, found.modes);
  PoseEstimate estimate = estimate_of_failure(PoseStatus::kDegenerate);
  estimate.ignored = cloud.ignored;
  if (!verdict) return estimate;
  Answer& answer = verdict->answer;
  estimate = estimate_from(cloud, answer);
  estimate.iterations = found.fits;
  if (estimate.status != PoseStatus::kOk) return estimate;
  estimate.covariance =
      consensus::covariance_from_cloud(answer.covariance, answer.cam_from_centred, cloud);
  const double unit_px = cloud.whitening.empty() ? cloud.image_unit_px : 1;
  estimate.noise_px = std::sqrt(answer.variance) * unit_px;
  if (verdict->second) {
    estimate.second_cam_from_target = consensus::from_cloud(*verdict->second, cloud);
  }
  estimate.diagnosis = diagnosis_of(cloud, *verdict, estimate, found.triples, false_alarm_rate);
  return estimate;
}

/// The root mean square of the residuals of the points kept, in the units of the covariances.
double whitened_rms(const Cloud& cloud, const PoseEstimate& estimate) {
  const Pose pose = consensus::to_cloud(estimate.cam_from_target, cloud);
  double squares = 0;
  int kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    double r[2];
    if (std::ranges::binary_search(estimate.removed, cloud.given_index[i])) continue;
    if (!consensus::residual_at(cloud, pose, i, r)) continue;
    squares += r[0] * r[0] + r[1] * r[1];
    ++kept;
  }
  return std::sqrt(squares / (2 * kept));
}

/// The points that can be used, and which of those given they are.
struct UsableProblem {
  PoseProblem problem;
  std::vector<int> given_index;
};

UsableProblem usable_problem(const PoseProblem& problem, const Cloud& cloud) {
  UsableProblem usable;
  usable.problem.camera = problem.camera;
  usable.problem.sigma_px = problem.sigma_px;
  usable.problem.initial_cam_from_target = consensus::rigid_pose(problem.initial_cam_from_target);
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const int index = static_cast<int>(i);
    if (std::ranges::binary_search(cloud.ignored, index)) continue;
    usable.given_index.push_back(index);
    usable.problem.points_in_target.push_back(problem.points_in_target[i]);
    usable.problem.pixels.push_back(problem.pixels[i]);
    if (problem.covariances_px2.empty()) continue;
    usable.problem.covariances_px2.push_back(problem.covariances_px2[i]);
  }
  return usable;
}

/// Whether a free start leads to residuals that are clearly smaller than those from the initial
/// pose.
bool is_clearly_better(const Cloud& cloud, const PoseEstimate& free, const PoseEstimate& started) {
  constexpr double kClearly = 1.5;
  if (free.status != PoseStatus::kOk) return false;
  return started.status != PoseStatus::kOk ||
         whitened_rms(cloud, started) > kClearly * whitened_rms(cloud, free);
}

/// The removals of orpe_weighed, which has a pose whatever the residuals are: as if the noise were
/// so large as what is kept says, each point's in proportion.
PoseEstimate estimate_of_few_understated(const PoseProblem& problem, const Cloud& cloud) {
  UsableProblem usable = usable_problem(problem, cloud);
  const auto removals = [&] {
    PoseEstimate estimate = solve_orpe_weighed(usable.problem, {});
    estimate.ignored = cloud.ignored;
    for (int& index : estimate.removed) index = usable.given_index[static_cast<std::size_t>(index)];
    return estimate;
  };
  PoseEstimate estimate = removals();
  if (usable.problem.initial_cam_from_target) {
    usable.problem.initial_cam_from_target.reset();
    PoseEstimate free = removals();
    if (is_clearly_better(cloud, free, estimate)) estimate = std::move(free);
  }
  if (estimate.status != PoseStatus::kOk) return estimate;
  const std::size_t kept = cloud.size() - estimate.removed.size();
  const double unit_px = cloud.whitening.empty() ? cloud.image_unit_px : 1;
  const double sigma = cloud.sigma * unit_px;
  const double rms = whitened_rms(cloud, estimate) * unit_px;
  const double degrees = std::max(2 * static_cast<double>(kept) - 6, 1.0);
  const double noise = std::max(rms * std::sqrt(2 * static_cast<double>(kept) / degrees), sigma);
  estimate.residual_rms_px = rms;
  estimate.noise_px = noise;
  *estimate.covariance *= noise * noise / (sigma * sigma);
  std::vector<double> probabilities(cloud.size() + cloud.ignored.size(), 1);
  for (const int i : estimate.removed) probabilities[static_cast<std::size_t>(i)] = 0;
  for (const int i : cloud.ignored) probabilities[static_cast<std::size_t>(i)] = 0;
  estimate.inlier_probabilities = std::move(probabilities);
  estimate.diagnosis->is_removal_limit_reached = kept <= kMinimumPosePoints;
  estimate.diagnosis->is_significant = false;
  return estimate;
}

/// Where noise of the size that was stated explains no pose: with noise that is found, which says
/// of itself that it is not the one stated.
PoseEstimate estimate_of_understated(const PoseProblem& problem, const Cloud& cloud,
                                     double false_alarm_rate) {
  if (cloud.size() <= consensus::kMostOfFew) {
    PoseEstimate few = estimate_of_few_understated(problem, cloud);
    if (few.status == PoseStatus::kOk) few.diagnosis->is_test_failed = true;
    if (few.status == PoseStatus::kOk) return few;
  }
  PoseEstimate estimate =
      estimate_by_search(consensus::with_unknown_noise(cloud), false_alarm_rate);
  if (estimate.status != PoseStatus::kOk) return estimate;
  estimate.diagnosis->is_test_failed = true;
  if (cloud.whitening.empty()) return estimate;
  estimate.residual_rms_px = estimate.noise_px = whitened_rms(cloud, estimate);
  return estimate;
}

PoseEstimate estimate_of_any(const PoseProblem& problem, double false_alarm_rate) {
  const consensus::PreparedCloud prepared = consensus::prepare_cloud(problem);
  const Cloud& cloud = prepared.cloud;
  if (prepared.status != PoseStatus::kOk) {
    PoseEstimate failure = estimate_of_failure(prepared.status);
    failure.ignored = cloud.ignored;
    return failure;
  }
  if (cloud.size() == 3) return solve_three_points(cloud);
  PoseEstimate estimate = estimate_by_search(cloud, false_alarm_rate);
  if (estimate.status == PoseStatus::kOk || !cloud.is_sigma_known()) return estimate;
  return estimate_of_understated(problem, cloud, false_alarm_rate);
}

}  // namespace

PoseEstimate solve_consensus(const PoseProblem& problem, const SolverOptions& options) {
  const double false_alarm_rate = options.outliers.false_alarm_rate;
  PoseEstimate estimate = consensus::estimate_of_few(problem, false_alarm_rate);
  if (estimate.status != PoseStatus::kOk) estimate = estimate_of_any(problem, false_alarm_rate);
  return estimate;
}

}  // namespace sightline
