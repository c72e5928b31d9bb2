// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The common entry of all pose solvers: what holds for any input stands here once, so that no
// solver can forget it. A solver itself (pose/solvers/) sees problems as they are given; what it
// answers well is passed on as it is, and only where something is wrong is the input looked at.
//
//   1. Points that cannot be used are left out and listed (pose/entry/cleaning.h).
//   2. An initial pose can only help: one that is a rotation but for rounding is made orthonormal,
//      another is left out, and a start of the solver's own competes with it (contest.h). Where the
//      solver finds no start of its own, the pose of consensus is one.
//   3. Points given twice count once for whether the pose is determined.
//   4. A camera in normalised coordinates (K = I) is one of a thousand pixels: constants in pixels
//      mean the same there.
//   5. What the solver does not say of its answer is added (judgement.h).
#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "pose/entry/cleaning.h"
#include "pose/entry/contest.h"
#include "pose/entry/judgement.h"
#include "pose/entry/lens_noise.h"
#include "pose/entry/residuals.h"
#include "pose/lines/joint.h"
#include "pose/solver.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace entry {
namespace {

/// A camera of a shorter focal length is taken for one in other units than pixels, and its numbers
/// are multiplied by the scale, which rounds nothing.
constexpr double kShortestFocalPx = 10;
constexpr double kPixelsPerUnit = 1024;

bool is_in_pixels(const Camera& camera) {
  // Also of a focal length that is no number.
  return !(camera.fx_px < kShortestFocalPx && camera.fy_px < kShortestFocalPx);
}

PoseProblem scaled(PoseProblem problem, double scale) {
  Camera& camera = problem.camera;
  for (double* value :
       {&camera.fx_px, &camera.fy_px, &camera.cx_px, &camera.cy_px, &camera.skew_px}) {
    *value *= scale;
  }
  for (Eigen::Vector2d& pixel : problem.pixels) pixel *= scale;
  for (Eigen::Matrix2d& covariance : problem.covariances_px2) covariance *= scale * scale;
  problem.sigma_px *= scale;
  for (LineObservation& line : problem.lines) {
    line.pixel *= scale;
    // Of an offset, which is in pixels, and a slope, which is not.
    line.covariance.row(0) *= scale;
    line.covariance.col(0) *= scale;
  }
  return problem;
}

SolverOptions scaled(SolverOptions options, double scale) {
  // The default is in pixels; a number that was given is in the problem's own unit.
  const bool is_given = options.outliers.scale_px != OutlierOptions{}.scale_px;
  if (is_given) options.outliers.scale_px *= scale;
  return options;
}

/// The solver's answer from the pose of consensus. Points that this pose has behind the camera,
/// where no solver can follow them, are outliers.
PoseEstimate from_consensus(const PoseSolver& solver, const PoseProblem& problem,
                            const SolverOptions& options) {
  const PoseEstimate consensus = solve_consensus(problem, options);
  if (consensus.status != PoseStatus::kOk) return consensus;
  const Pose& start = *consensus.diagnosis->most_probable_cam_from_target;
  Part part = without_points(problem, points_behind(problem, start));
  part.problem.initial_cam_from_target = start;
  PoseEstimate estimate = of_whole(solver.core(part.problem, options), part);
  std::vector<int> outliers;
  std::ranges::set_union(estimate.removed, estimate.ignored, std::back_inserter(outliers));
  estimate.removed = std::move(outliers);
  estimate.ignored.clear();
  return estimate;
}

/// Whether a point of the target is so far from most others that it alone decides where a fit to
/// all points starts: farther than five times the median distance, seen from the first two points,
/// of which one at least is no such point.
bool has_far_point(const std::vector<Eigen::Vector3d>& points) {
  constexpr double kFar2 = 5 * 5;
  for (std::size_t from = 0; from < 2; ++from) {
    const auto distance2 = [&](const Eigen::Vector3d& p) {
      return (p - points[from]).squaredNorm();
    };
    double farthest2 = 0;
    for (const Eigen::Vector3d& p : points) farthest2 = std::max(farthest2, distance2(p));
    const double near2 = farthest2 / kFar2;
    const auto near =
        std::ranges::count_if(points, [&](const auto& p) { return distance2(p) < near2; });
    if (2 * static_cast<std::size_t>(near) > points.size()) return true;
  }
  return false;
}

/// Takes the answer from the pose of consensus in the place of one that has none or that a far
/// point has led astray.
void try_consensus(const PoseSolver& solver, const PoseProblem& problem,
                   const SolverOptions& options, PoseEstimate& estimate) {
  if (problem.pixels.size() < kMinimumPosePoints) return;
  const bool is_ok = estimate.status == PoseStatus::kOk;
  const bool has_no_start =
      estimate.status == PoseStatus::kDegenerate || estimate.status == PoseStatus::kBehindCamera;
  const bool is_led_astray = (is_ok || estimate.status == PoseStatus::kDiverged) &&
                             has_far_point(problem.points_in_target);
  if (!has_no_start && !is_led_astray) return;
  Residuals residuals;
  if (is_ok) residuals = residuals_of(problem, estimate);
  if (is_ok && residuals.look_like_noise()) return;
  PoseEstimate other = from_consensus(solver, problem, options);
  if (other.status != PoseStatus::kOk) return;
  if (is_ok && !is_clearly_better(residuals_of(problem, other), residuals)) return;
  estimate = std::move(other);
}

/// Lets other starts compete with the answer from the first one; all points can be used.
void try_other_starts(const PoseSolver& solver, const PoseProblem& problem,
                      const SolverOptions& options, PoseEstimate& estimate) {
  if (problem.initial_cam_from_target) contest(solver, problem, options, estimate);
  try_consensus(solver, problem, options, estimate);
}

PoseEstimate answer_to_part(const PoseSolver& solver, const Part& part,
                            const SolverOptions& options) {
  PoseEstimate estimate = solver.core(part.problem, options);
  // That too few of the points given can be used is not that too few were given.
  if (estimate.status == PoseStatus::kTooFewPoints) estimate.status = PoseStatus::kDegenerate;
  try_other_starts(solver, part.problem, options, estimate);
  return of_whole(std::move(estimate), part);
}

bool is_whole(const Part& part, const PoseProblem& problem) {
  if (!part.left_out.empty()) return false;
  const std::optional<Pose>& given = problem.initial_cam_from_target;
  const std::optional<Pose>& used = part.problem.initial_cam_from_target;
  return !given || (used && used->rotation == given->rotation);
}

/// Improves what the solver's own function said, where that is wrong or may be.
void mend(const PoseSolver& solver, const PoseProblem& problem, const SolverOptions& options,
          PoseEstimate& estimate) {
  if (estimate.status == PoseStatus::kTooFewPoints) return;
  if (estimate.status != PoseStatus::kOk) {
    const Part part = usable_part(problem);
    if (!is_whole(part, problem)) {
      estimate = answer_to_part(solver, part, options);
      return;
    }
  }
  try_other_starts(solver, problem, options, estimate);
}

void finish(const PoseProblem& problem, const SolverOptions& options, PoseEstimate& estimate) {
  if (estimate.status != PoseStatus::kOk) return;
  if (!is_determined(problem, estimate)) estimate.status = PoseStatus::kDegenerate;
  if (estimate.status == PoseStatus::kOk && options.is_judged) judge(problem, estimate);
}

bool are_lists_of_one_length(const PoseProblem& problem) {
  const std::size_t n = problem.points_in_target.size();
  const std::size_t covariances = problem.covariances_px2.size();
  return problem.pixels.size() == n && (covariances == 0 || covariances == n);
}

/// The answer to a problem in other units than pixels.
PoseEstimate answer_in_units(const PoseSolver& solver, const PoseProblem& problem,
                             const SolverOptions& options) {
  constexpr double kScale = kPixelsPerUnit;
  PoseEstimate estimate = solver.solve(scaled(problem, kScale), scaled(options, kScale));
  const bool is_whitened = !problem.covariances_px2.empty();
  if (!is_whitened || !solver.unit_covariance_is_whitened) {
    estimate.unit_covariance *= kScale * kScale;
  }
  if (is_whitened) return estimate;
  if (estimate.noise_px) *estimate.noise_px /= kScale;
  if (estimate.residual_rms_px) *estimate.residual_rms_px /= kScale;
  return estimate;
}

/// The same with lines, of which all that is said is in units of their noise.
PoseEstimate answer_to_lines_in_units(const PoseSolver& solver, const PoseProblem& problem,
                                      const SolverOptions& options) {
  return solver.with_lines(scaled(problem, kPixelsPerUnit), scaled(options, kPixelsPerUnit));
}

}  // namespace
}  // namespace entry

PoseEstimate PoseSolver::solve(const PoseProblem& problem, const SolverOptions& options) const {
  if (!entry::are_lists_of_one_length(problem)) return {};
  if (!problem.lines.empty() && with_lines == nullptr) {
    return solve(lines::points_of(problem), options);
  }
  if (!problem.lines.empty()) {
    if (entry::is_in_pixels(problem.camera)) return with_lines(problem, options);
    return entry::answer_to_lines_in_units(*this, problem, options);
  }
  if (most_points > 0 && problem.pixels.size() > most_points) {
    PoseEstimate refused;
    refused.status = PoseStatus::kTooManyPoints;
    return refused;
  }
  if (!takes_any_input && !entry::is_in_pixels(problem.camera)) {
    return entry::answer_in_units(*this, problem, options);
  }
  if (entry::is_noise_bent(problem)) {
    return entry::in_pixels(solve(entry::with_bent_noise(problem), options), *this, problem);
  }
  const bool is_plain = takes_any_input || entry::are_covariances_plausible(problem);
  PoseEstimate estimate = is_plain
                              ? core(problem, options)
                              : entry::answer_to_part(*this, entry::usable_part(problem), options);
  if (is_plain && !takes_any_input) entry::mend(*this, problem, options, estimate);
  entry::finish(problem, options, estimate);
  return estimate;
}

}  // namespace sightline
