// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/orientation_trial.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "eval/records/caps.h"
#include "pose/angles.h"
#include "pose/attitude.h"
#include "scenes/scene/scene_law.h"

namespace sightline {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Eigen::Vector3d drawn_in_cube(double half_side, RandomStream& stream) {
  Eigen::Vector3d x;
  for (double& coordinate : x) coordinate = stream.uniform(-half_side, half_side);
  return x;
}

Points drawn_points(int count, double half_side_m, RandomStream& stream) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(drawn_in_cube(half_side_m, stream));
  return points;
}

Points noisy_copy(const Points& points_in_a, const Pose& b_from_a, const OrientationCell& cell,
                  RandomStream& stream) {
  Points points_in_b;
  for (const Eigen::Vector3d& x : points_in_a) {
    points_in_b.push_back(b_from_a * (cell.scale * x) + cell.noise_m * stream.normal3());
  }
  return points_in_b;
}

// Takes some of the points, drawn anew for each copy, to places uniform in the cube.
void plant_outliers(const OrientationCell& cell, double half_side_m, const Pose& b_from_a,
                    RandomStream& stream, Points& points_in_b) {
  std::vector<size_t> order(points_in_b.size());
  std::iota(order.begin(), order.end(), size_t{0});
  for (int i = 0; i < cell.outliers; ++i) {
    const auto first = static_cast<size_t>(i);
    const uint64_t drawn = (uint64_t{stream.bits()} * (order.size() - first)) >> 32;
    std::swap(order[first], order[first + drawn]);
    points_in_b[order[first]] = b_from_a * (cell.scale * drawn_in_cube(half_side_m, stream));
  }
}

// What any method makes of the pairs.
OrientationEstimate estimate_by(const StudyMethod& method, const Points& points_in_a,
                                const Points& points_in_b, const RobustAlignmentOptions& options) {
  if (const auto* const plain = std::get_if<const OrientationMethod*>(&method)) {
    return (*plain)->estimate(points_in_a, points_in_b);
  }
  const RobustAlignment alignment =
      std::get<const RobustAlignmentMethod*>(method)->align({points_in_a, points_in_b}, options);
  return {alignment.status, alignment.b_from_a, alignment.scale};
}

// Mean of the three angles' absolute errors, each wrapped to [-pi, pi].
double mean_angle_error_rad(const Eigen::Matrix3d& estimated, const Eigen::Matrix3d& truth) {
  const Attitude a = attitude_from_rotation(estimated);
  const Attitude b = attitude_from_rotation(truth);
  double sum = 0;
  for (const double difference :
       {a.pitch_rad - b.pitch_rad, a.yaw_rad - b.yaw_rad, a.roll_rad - b.roll_rad}) {
    sum += std::abs(std::remainder(difference, 2 * std::numbers::pi));
  }
  return sum / 3;
}

// Adds one copy's errors to the sums. Not std::min alone: a NaN must count as the cap.
void add_errors(const OrientationEstimate& estimate, const Pose& truth, OrientationRecord& sums) {
  const bool is_ok = estimate.status == OrientationStatus::kOk;
  if (!is_ok && sums.failures++ == 0) {
    sums.status = from_string<EstimateOutcome>(to_string(estimate.status));
  }
  const auto capped = [is_ok](double error, double cap) {
    return is_ok && error < cap ? error : cap;
  };
  const Pose& pose = estimate.b_from_a;
  sums.angle_error_deg +=
      capped(mean_angle_error_rad(pose.rotation, truth.rotation) / kDegree, kAngleCapDeg);
  sums.theta_error_deg +=
      capped(attitude_error_rad(pose.rotation, truth.rotation) / kDegree, kAngleCapDeg);
  sums.geodesic_deg +=
      capped(geodesic_angle_rad(pose.rotation, truth.rotation) / kDegree, kAngleCapDeg);
  sums.t_error_percent +=
      capped(100 * translation_error_fraction(pose.translation, truth.translation),
             kTranslationCapPercent);
}

void divide_by(int copies, OrientationRecord& sums) {
  for (double* sum :
       {&sums.angle_error_deg, &sums.theta_error_deg, &sums.geodesic_deg, &sums.t_error_percent}) {
    *sum /= copies;
  }
}

double mean_time_ns(const StudyMethod& method, const Points& points_in_a, const Points& points_in_b,
                    const RobustAlignmentOptions& options, int repeats) {
  double sum = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < repeats; ++i) {
    sum += estimate_by(method, points_in_a, points_in_b, options).b_from_a.rotation(0, 0);
  }
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
  [[maybe_unused]] const volatile double used = sum;  // so that no solve can be left out
  return time.count() / repeats;
}

}  // namespace

TrialRecord run_orientation_trial(const OrientationStudy& study, uint64_t seed, int64_t index) {
  TrialRecord record;
  record.trial = index;
  record.condition = static_cast<int>(index % study.cells.size());
  const OrientationCell& cell = study.cells[record.condition];
  const PointPairs& pairs = study.pairs;

  RandomStream draw_stream(seed, "points", index);
  const Points points_in_a = drawn_points(cell.points, pairs.half_side_m, draw_stream);
  const Eigen::Vector3d theta_deg = drawn_in_cube(180, draw_stream);
  const Pose b_from_a = pose_from(theta_deg, drawn_in_cube(pairs.translation_m, draw_stream));
  record.true_cam_from_target = b_from_a;
  auto& orientations = record.kind.emplace<OrientationTrial>().orientations;
  for (const StudyMethod& method : study.methods) {
    orientations.emplace_back().method = name_of(method);
  }

  const RobustAlignmentOptions options = {.sigma_m = pairs.is_sigma_known ? cell.noise_m : 0.0,
                                          .estimates_scale = pairs.estimates_scale};
  RandomStream noise_stream(seed, "point noise", index);
  RandomStream outlier_stream(seed, "wrong pairs", index);
  for (int copy = 0; copy < pairs.copies; ++copy) {
    Points points_in_b = noisy_copy(points_in_a, b_from_a, cell, noise_stream);
    plant_outliers(cell, pairs.half_side_m, b_from_a, outlier_stream, points_in_b);
    for (size_t i = 0; i < study.methods.size(); ++i) {
      const StudyMethod& method = study.methods[i];
      OrientationRecord& sums = orientations[i];
      add_errors(estimate_by(method, points_in_a, points_in_b, options), b_from_a, sums);
      if (copy > 0 || pairs.timed_repeats == 0) continue;
      sums.time_ns = mean_time_ns(method, points_in_a, points_in_b, options, pairs.timed_repeats);
    }
  }
  for (OrientationRecord& sums : orientations) divide_by(pairs.copies, sums);
  return record;
}

}  // namespace sightline
