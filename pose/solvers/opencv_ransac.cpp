// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What users of OpenCV run: cv::solvePnPRansac with SOLVEPNP_SQPNP, and a refinement of its pose by
// least squares on the consensus (as solvePnPRefineLM would; here LSPE's iteration). Its samples of
// five points are solved by EPnP, the consensus by SQPnP (Terzakis and Lourakis, ECCV 2020).
// Present where CMake's SIGHTLINE_POSE_OPENCV is ON; for comparison.
//
// Needs four points that are not collinear, or three with an initial pose; up to five points are
// solved by least squares, because OpenCV then has no choice of sample. The threshold is sigma
// times the root of squared_threshold(false_alarm_rate); where sigma is not known it is OpenCV's
// default, 8 px. OpenCV cannot weigh: with covariances sigma is the root of their mean variance,
// and only the refinement is whitened. max_removed does not bind. An initial pose is used where
// OpenCV has no consensus and with up to five points; one with a point behind the camera is
// refused. No consensus is kDiverged.
//
// OpenCV's sampling has a fixed seed; so that its samples differ between problems but not with the
// order of the points, these are given in canonical_order, about their centroid and in units of
// their size.

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "pose/point_spread.h"
#include "pose/removal_limits.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr int kMaxSamples = 100;
constexpr double kConfidence = 0.99;
constexpr double kThresholdOfUnknownNoisePx = 8;  // OpenCV's default

double threshold_px(const PoseProblem& problem, double false_alarm_rate) {
  double variance_px2 = std::pow(std::min(problem.sigma_px, kLargestSigma), 2);
  if (!problem.covariances_px2.empty()) {
    variance_px2 = 0;
    for (const Eigen::Matrix2d& covariance : problem.covariances_px2) {
      variance_px2 += 0.5 * covariance.trace();
    }
    variance_px2 /= static_cast<double>(problem.covariances_px2.size());
  }
  if (!(variance_px2 > 0)) return kThresholdOfUnknownNoisePx;
  return std::sqrt(variance_px2 * squared_threshold(false_alarm_rate, problem.pixels.size()));
}

struct Consensus {
  Pose cam_from_centred;
  std::vector<double> weights;  ///< 1 for its points, 0 for the others
};

/// None when OpenCV finds none.
std::optional<Consensus> opencv_consensus(const Correspondences& c, double threshold) {
  const std::vector<std::size_t> order = canonical_order(c);
  const double size = spread_of(c.points_in_centred).sd[0];
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const std::size_t i : order) {
    const Eigen::Vector3d x = c.points_in_centred[i] / size;
    points.emplace_back(x.x(), x.y(), x.z());
    pixels.emplace_back(c.pixels[i].x(), c.pixels[i].y());
  }
  const cv::Matx33d intrinsics(c.fx_px, 0, 0, 0, c.fy_px, 0, 0, 0, 1);
  cv::Mat rotation, translation, inliers;
  try {
    cv::solvePnPRansac(points, pixels, intrinsics, cv::noArray(), rotation, translation, false,
                       kMaxSamples, static_cast<float>(threshold), kConfidence, inliers,
                       cv::SOLVEPNP_SQPNP);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (rotation.total() != 3 || translation.total() != 3) return std::nullopt;
  Consensus consensus;
  const Eigen::Vector3d w(rotation.at<double>(0), rotation.at<double>(1), rotation.at<double>(2));
  consensus.cam_from_centred = {
      rotation_from_vector(w),
      size * Eigen::Vector3d(translation.at<double>(0), translation.at<double>(1),
                             translation.at<double>(2))};
  if (!is_valid(consensus.cam_from_centred)) return std::nullopt;
  consensus.weights.assign(c.size(), 0.0);
  for (int k = 0; k < static_cast<int>(inliers.total()); ++k) {
    consensus.weights[order[static_cast<std::size_t>(inliers.at<int>(k))]] = 1;
  }
  return consensus;
}

}  // namespace

PoseEstimate solve_opencv_ransac(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  const std::optional<Pose>& initial = problem.initial_cam_from_target;
  if (c.size() <= kMinimumKeptPoints) {
    return estimate_from_least_squares(
        whitened_least_squares(c, starting_poses(c.points, initial), options.lspe), c.points, {});
  }
  if (initial &&
      !std::isfinite(std::ranges::max(squared_residuals(c, to_centred(*initial, c.points))))) {
    return estimate_of_failure(PoseStatus::kBehindCamera);
  }
  const std::optional<Consensus> consensus =
      opencv_consensus(c.points, threshold_px(problem, options.outliers.false_alarm_rate));
  if (!consensus) return estimate_of_failure(PoseStatus::kDiverged);
  std::vector<int> removed;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (consensus->weights[i] == 0) removed.push_back(static_cast<int>(i));
  }
  return estimate_from_least_squares(
      whitened_least_squares(c, std::span(&consensus->cam_from_centred, 1), options.lspe,
                             consensus->weights),
      c.points, removed);
}

}  // namespace sightline
