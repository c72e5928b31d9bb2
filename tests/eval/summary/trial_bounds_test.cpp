// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/trial_bounds.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pose/bounds.h"
#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using namespace handmade;

// Two trials of the cube from 60 m: six vertices found with these errors, a seventh is an outlier.
std::vector<TrialRecord> cube_trials(double first_error_px, double other_error_px) {
  std::vector<TrialRecord> trials(2);
  for (int i = 0; i < 2; ++i) {
    trials[i].trial = i;
    trials[i].true_cam_from_target = {rotation_from_vector({0.3, -0.4, 0.5}), {0.5, 0.2, 60}};
    for (int k = 0; k < 7; ++k) {
      const double error_px = k == 0 ? first_error_px : other_error_px;
      trials[i].pose_trial().observations.push_back(
          found(fmt::format("vertex_{}", k).c_str(), k == 6 ? 30 : error_px, k == 6));
    }
    trials[i].pose_trial().estimates = {estimate("orpe", 1), estimate("lspe", 2),
                                        estimate("oracle", 0.5)};
  }
  return trials;
}

Study cube_study() {
  Study study = two_poses();
  images_of(study).setups.front().scene.camera = centred_camera(512, 512, 15000);
  return study;
}

TEST(TrialBounds, BoundThePoseByTheInliersNoise) {
  const Study study = cube_study();
  const std::vector<TrialRecord> trials = cube_trials(2, 2);
  const Summary summary = summarise(study, trials);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 6; ++k) points.push_back(study.images()->target->features[k].position_m);
  const auto bound = cramer_rao_bound(study.camera_of(0), points, trials[0].true_cam_from_target,
                                      std::sqrt(2.0));  // 2 px in all is sqrt(2) a coordinate
  ASSERT_TRUE(bound);
  const double degree = std::acos(-1.0) / 180;
  const CellObservations& cell = summary.observations[0];
  EXPECT_NEAR(cell.bound_theta_deg, bound->attitude_rms_rad / degree, 1e-9);
  EXPECT_NEAR(cell.bound_t_percent, 100 * bound->translation_rms, 1e-9);
  EXPECT_NEAR(cell.bound_geodesic_deg, bound->geodesic_rms_rad / degree, 1e-9);
  EXPECT_NEAR(cell_of(summary, 0, "lspe").ratio_to_bound, 2 / cell.bound_geodesic_deg, 1e-9);
}

TEST(TrialBounds, WeighEachFeatureByItsOwnNoise) {
  const Study study = cube_study();
  const auto bound_deg = [&](double first_px, double other_px) {
    return summarise(study, cube_trials(first_px, other_px)).observations[0].bound_geodesic_deg;
  };
  EXPECT_NEAR(bound_deg(4, 4), 2 * bound_deg(2, 2), 1e-9);
  // One bad feature costs something, but far less than the same noise on all would.
  EXPECT_GT(bound_deg(5, 1), bound_deg(1, 1));
  EXPECT_LT(bound_deg(5, 1), 2 * bound_deg(1, 1));
}

TEST(TrialBounds, AreNoneWithoutEnoughInliers) {
  std::vector<TrialRecord> trials = cube_trials(1, 1);
  for (TrialRecord& trial : trials) trial.pose_trial().observations.resize(2);
  EXPECT_TRUE(std::isnan(summarise(cube_study(), trials).observations[0].bound_theta_deg));
}

TEST(TrialBounds, LeaveFeaturesOutThatTheTargetNoLongerHas) {
  const Study study = cube_study();
  std::vector<TrialRecord> with_stranger = cube_trials(2, 1);
  std::vector<TrialRecord> without = with_stranger;
  for (TrialRecord& trial : with_stranger) trial.pose_trial().observations[0].feature = "chimney";
  for (TrialRecord& trial : without)
    trial.pose_trial().observations.erase(trial.pose_trial().observations.begin());
  const CellObservations expected = summarise(study, without).observations[0];
  const CellObservations cell = summarise(study, with_stranger).observations[0];
  EXPECT_GT(expected.bound_geodesic_deg, 0);
  EXPECT_EQ(cell.bound_geodesic_deg, expected.bound_geodesic_deg);
  EXPECT_EQ(cell.bound_t_percent, expected.bound_t_percent);
}

}  // namespace
}  // namespace sightline
