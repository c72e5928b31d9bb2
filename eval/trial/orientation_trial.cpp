// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/orientation_trial.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>

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

Points noisy_copy(const Points& points_in_a, const Pose& b_from_a, double sd_m,
                  RandomStream& stream) {
  Points points_in_b;
  for (const Eigen::Vector3d& x : points_in_a) {
    points_in_b.push_back(b_from_a * x + sd_m * stream.normal3());
  }
  return points_in_b;
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

double mean_time_ns(const OrientationMethod& method, const Points& points_in_a,
                    const Points& points_in_b, int repeats) {
  double sum = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < repeats; ++i) {
    sum += method.estimate(points_in_a, points_in_b).b_from_a.rotation(0, 0);
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
  for (const OrientationMethod* method : study.methods) {
    orientations.emplace_back().method = method->name;
  }

  RandomStream noise_stream(seed, "point noise", index);
  for (int copy = 0; copy < pairs.copies; ++copy) {
    const Points points_in_b = noisy_copy(points_in_a, b_from_a, cell.noise_m, noise_stream);
    for (size_t i = 0; i < study.methods.size(); ++i) {
      const OrientationMethod& method = *study.methods[i];
      OrientationRecord& sums = orientations[i];
      add_errors(method.estimate(points_in_a, points_in_b), b_from_a, sums);
      if (copy > 0 || pairs.timed_repeats == 0) continue;
      sums.time_ns = mean_time_ns(method, points_in_a, points_in_b, pairs.timed_repeats);
    }
  }
  for (OrientationRecord& sums : orientations) divide_by(pairs.copies, sums);
  return record;
}

}  // namespace sightline
