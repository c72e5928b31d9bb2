// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/estimates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "eval/metrics/pose_errors.h"
#include "eval/records/line_records.h"
#include "pose/angles.h"
#include "pose/attitude.h"
#include "pose/pose.h"

namespace sightline {
namespace {

double reprojection_rms_px(const PoseProblem& problem, const PoseEstimate& estimate) {
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < problem.pixels.size(); ++i) {
    if (std::binary_search(estimate.removed.begin(), estimate.removed.end(), static_cast<int>(i))) {
      continue;
    }
    const auto pixel =
        project(problem.camera, estimate.cam_from_target * problem.points_in_target[i]);
    if (!pixel) return std::numeric_limits<double>::infinity();
    sum += (*pixel - problem.pixels[i]).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
}

// Which points a solver judged right and wrong, against the labels.
void judge_removals(const TrialRecord& record, const FoundPoints& found,
                    const PoseEstimate& estimate, EstimateRecord& out) {
  for (size_t i = 0; i < found.slots.size(); ++i) {
    const ObservationRecord& observation = record.observations()[found.slots[i]];
    const bool is_removed =
        std::binary_search(estimate.removed.begin(), estimate.removed.end(), static_cast<int>(i));
    if (is_removed) out.removed.push_back(observation.feature);
    if (is_removed && !observation.is_outlier) ++out.false_removals;
    if (!is_removed && observation.is_outlier) ++out.missed_outliers;
  }
}

// The covariance that a solver reports: its own or, of the noise that it was told, the one for unit
// noise scaled.
std::optional<Matrix6d> reported_covariance(const PoseProblem& problem,
                                            const PoseEstimate& estimate) {
  const double variance_px2 = problem.sigma_px * problem.sigma_px;
  const Matrix6d covariance =
      estimate.covariance.value_or(Matrix6d(variance_px2 * estimate.unit_covariance));
  if (covariance.isZero(0) || !covariance.allFinite()) return std::nullopt;
  return covariance;
}

// Infinite where the covariance is none.
double nees_of(const Pose& pose, const Pose& truth, const Matrix6d& covariance) {
  const Vector6d error = change_between(truth, pose);
  // To comparable units, for the sake of rounding.
  const Eigen::Matrix<double, 6, 1> scale = covariance.diagonal().cwiseSqrt();
  const Matrix6d correlation =
      scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
  const Eigen::LLT<Matrix6d> factor(correlation);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return factor.matrixL().solve(error.cwiseQuotient(scale)).squaredNorm();
}

// What the solver itself says of its pose.
void keep_diagnosis(const Diagnosis& diagnosis, EstimateRecord& out) {
  out.is_ambiguous = diagnosis.is_ambiguous;
  out.removed_probability = diagnosis.removed_probability;
  out.is_removal_limit_reached = diagnosis.is_removal_limit_reached;
  out.is_test_failed = diagnosis.is_test_failed;
}

// Whether an answer is a pose at all: guests may answer anything.
bool is_rigid(const Pose& pose) {
  constexpr double kTolerance = 1e-6;  // of a rotation's numbers, which solvers keep far better
  const Eigen::Matrix3d product = pose.rotation.transpose() * pose.rotation;
  constexpr double kFarthestM = 1e100;  // whose square is a number still
  return pose.translation.allFinite() && pose.translation.cwiseAbs().maxCoeff() < kFarthestM &&
         product.allFinite() && product.isApprox(Eigen::Matrix3d::Identity(), kTolerance) &&
         pose.rotation.determinant() > 0;
}

// The names of the points that solvers are given.
std::vector<std::string> features_of(const FoundPoints& found, const TrialRecord& record) {
  std::vector<std::string> features;
  for (const int slot : found.slots) features.push_back(record.observations()[slot].feature);
  return features;
}

bool has_symmetries(const FoundPoints& found) {
  return found.symmetries != nullptr && found.symmetries->has_any();
}

// The true pose or, of a target with symmetries, the one of those that look alike that is nearest
// to the estimate.
Pose nearest_truth(const PoseStudy& study, const FoundPoints& found, const Pose& estimated,
                   const Pose& truth) {
  if (!has_symmetries(found)) return truth;
  Pose nearest =
      nearest_alike(vertices_of(study.target->mesh), estimated, truth, found.symmetries->poses);
  for (const SymmetryAxis& axis : found.symmetries->axes) {
    nearest = turned_towards(estimated, nearest, axis.direction, axis.point);
  }
  return nearest;
}

EstimateRecord solve(const PoseStudy& study, const TrialSolver& solver, const std::string& name,
                     const FoundPoints& found, const std::vector<std::string>& features,
                     const TrialRecord& record) {
  PoseProblem problem = found.problem;
  if (solver.evaluation_only) {
    for (const int slot : found.slots) {
      problem.true_inliers.push_back(!record.observations()[slot].is_outlier);
    }
  }
  const SolverOptions& options = found.options != nullptr ? *found.options : study.solving.options;
  const SolverAnswer answer = solver.solve(
      {problem, options, features, found.trial, found.image ? &*found.image : nullptr});
  const PoseEstimate& estimate = answer.estimate;
  EstimateRecord out;
  out.solver = name;
  out.status = answer.outcome;
  if (out.is_ok() && !is_rigid(estimate.cam_from_target)) out.status = EstimateOutcome::kNotRigid;
  if (!out.is_ok()) return out;

  const Pose& pose = estimate.cam_from_target;
  const Pose truth = nearest_truth(study, found, pose, record.true_cam_from_target);
  out.cam_from_target = pose;
  out.theta_error_deg = attitude_error_rad(pose.rotation, truth.rotation) / kDegree;
  out.t_error_percent = 100 * translation_error_fraction(pose.translation, truth.translation);
  out.geodesic_deg = geodesic_angle_rad(pose.rotation, truth.rotation) / kDegree;
  out.reprojection_rms_px = reprojection_rms_px(problem, estimate);
  for (const int line : estimate.removed_lines) {
    out.removed_lines.push_back(name_of(record.lines()[static_cast<size_t>(line)]));
  }
  const VertexErrors errors =
      vertex_errors(vertices_of(study.target->mesh), problem.camera, pose, truth);
  out.add_m = errors.add;
  out.mssd_m = errors.mssd;
  out.mspd_px = errors.mspd_px;
  if (has_symmetries(found)) {
    out.mspd_px = least_mspd_px(vertices_of(study.target->mesh), problem.camera, pose,
                                record.true_cam_from_target, found.symmetries->poses);
  }
  if (!solver.looks_at_image) judge_removals(record, found, estimate, out);
  out.covariance = reported_covariance(problem, estimate);
  if (out.covariance) out.nees = nees_of(pose, truth, *out.covariance);
  if (estimate.diagnosis) keep_diagnosis(*estimate.diagnosis, out);
  return out;
}

// The points at their true places, without lines; `is_moved` says which of them.
template <typename Choice>
FoundPoints at_truth(const FoundPoints& found, const TrialRecord& record, const Choice& is_moved) {
  FoundPoints out = found;
  out.problem.lines.clear();
  for (size_t i = 0; i < found.slots.size(); ++i) {
    const ObservationRecord& observation = record.observations()[found.slots[i]];
    if (is_moved(observation)) out.problem.pixels[i] = observation.true_pixel;
  }
  return out;
}

FoundPoints inliers_of(const FoundPoints& found, const TrialRecord& record) {
  FoundPoints out = found;
  out.problem.lines.clear();
  out.problem.points_in_target.clear();
  out.problem.pixels.clear();
  out.problem.covariances_px2.clear();
  out.slots.clear();
  for (size_t i = 0; i < found.slots.size(); ++i) {
    if (record.observations()[found.slots[i]].is_outlier) continue;
    out.problem.points_in_target.push_back(found.problem.points_in_target[i]);
    out.problem.pixels.push_back(found.problem.pixels[i]);
    if (!found.problem.covariances_px2.empty()) {
      out.problem.covariances_px2.push_back(found.problem.covariances_px2[i]);
    }
    out.slots.push_back(found.slots[i]);
  }
  return out;
}

// Outliers get the error of an inlier of the same trial, drawn anew for each.
FoundPoints with_noise_alone(const FoundPoints& found, const TrialRecord& record,
                             RandomStream stream) {
  const auto is_outlier = [](const ObservationRecord& o) { return o.is_outlier; };
  FoundPoints out = at_truth(found, record, is_outlier);
  const FoundPoints inliers = inliers_of(found, record);
  if (inliers.slots.empty()) return out;
  for (size_t i = 0; i < found.slots.size(); ++i) {
    if (!is_outlier(record.observations()[found.slots[i]])) continue;
    const uint64_t drawn = (uint64_t{stream.bits()} * inliers.slots.size()) >> 32;
    const ObservationRecord& inlier = record.observations()[inliers.slots[drawn]];
    out.problem.pixels[i] += inlier.pixel - inlier.true_pixel;
  }
  return out;
}

FoundPoints points_for(PoseInput input, uint64_t seed, const FoundPoints& found,
                       const TrialRecord& record) {
  switch (input) {
    case PoseInput::kExact:
      return at_truth(found, record, [](const ObservationRecord&) { return true; });
    case PoseInput::kNoise:
      return with_noise_alone(
          found, record, RandomStream(seed, "noise input", static_cast<uint64_t>(record.trial)));
    case PoseInput::kInliers:
      return inliers_of(found, record);
  }
  return found;
}

}  // namespace

std::vector<EstimateRecord> estimates_of(const PoseStudy& study, uint64_t seed,
                                         const FoundPoints& found, const TrialRecord& record) {
  std::vector<EstimateRecord> estimates;
  const std::vector<std::string> features = features_of(found, record);
  for (const TrialSolver& solver : study.solving.solvers) {
    estimates.push_back(solve(study, solver, solver.name, found, features, record));
  }
  for (const PoseInput input : study.solving.inputs) {
    const FoundPoints points = points_for(input, seed, found, record);
    const std::vector<std::string> given = features_of(points, record);
    for (const TrialSolver& solver : study.solving.solvers) {
      if (!can_be_given_inputs(solver)) continue;
      estimates.push_back(
          solve(study, solver, name_with(solver.name, input), points, given, record));
    }
  }
  return estimates;
}

std::vector<EstimateRecord> failed_estimates(const Solving& solving, EstimateOutcome reason) {
  std::vector<EstimateRecord> estimates;
  for (const std::string& name : solving.names()) {
    EstimateRecord& estimate = estimates.emplace_back();
    estimate.solver = name;
    estimate.status = reason;
  }
  return estimates;
}

}  // namespace sightline
