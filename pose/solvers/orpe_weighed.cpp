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
// covariances_px2, else sigma_px; where neither is given it is unknown and integrated out under a
// scaled inverse chi-square prior (kPriorDegrees, kPriorSigmaPx), and the weights stay those of the
// linear model, which proved better there. Uses OutlierOptions::probability, scale_px (the slab is
// round in whitened units, of that geometric mean) and max_removed, but not LspeOptions. Made for
// few points: by default 1, 3 and 4 of 5, 8 and 12 points may be outliers, and as no more than 50
// 000 sets are tried (pose/removal_sets.cpp), 3, 2 and 1 of more than 33, 66 and 315; what they
// leave is then flagged. Nothing random; of equals the set that comes first wins.

#include <algorithm>
#include <vector>

#include "pose/packed_points.h"
#include "pose/removal_hypotheses.h"
#include "pose/removal_sets.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {

PoseEstimate solve_orpe_weighed(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedWhitened prepared = prepare_whitened(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const RemovalModel s = removal_model(prepared.correspondences, options.outliers);
  const Correspondences& c = *s.c;
  estimate.status = PoseStatus::kDegenerate;

  const PackedPoints points = packed(s);
  Linearisation linear;
  std::vector<RemovalBranch> branches;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    branches.push_back(removals_from(s, points, start, RemovalEffort::kAll, linear));
    estimate.status = branches.back().status;
    estimate.iterations += branches.back().iterations;
  }
  const bool is_any = std::ranges::any_of(
      branches, [](const RemovalBranch& b) { return b.status == PoseStatus::kOk; });
  if (!is_any) return estimate;

  estimate.status = PoseStatus::kDegenerate;
  const std::optional<MeanOverRemovals> answer = mean_over_removals(branches, s);
  if (!answer) return estimate;
  const RemovalSet& removed = answer->best.set;
  const std::optional<FitOfKept> most_probable = fit_kept(s, points, answer->best);
  if (!most_probable) return estimate;
  const bool is_mean_usable = has_kept_in_front(c, removed, answer->mean);
  const Pose& pose = is_mean_usable ? answer->mean : most_probable->pose;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = from_centred(pose, c);
  estimate.removed.assign(removed.span().begin(), removed.span().end());
  estimate.unit_covariance = covariance_from_centred(most_probable->unit_covariance, pose, c);
  estimate.covariance = covariance_from_centred(answer->covariance, pose, c);
  Diagnosis& diagnosis = estimate.diagnosis.emplace();
  diagnosis.is_ambiguous = answer->is_ambiguous;
  diagnosis.removed_probability = answer->best_probability;
  diagnosis.is_removal_limit_reached = s.max_removed > 0 && removed.size == s.max_removed;
  if (s.is_sigma_known) diagnosis.is_test_failed = !is_explained(s, answer->best);
  diagnosis.most_probable_cam_from_target = from_centred(most_probable->pose, c);
  return estimate;
}

}  // namespace sightline
