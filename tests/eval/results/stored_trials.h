// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What tests of the store share: a folder for each test, trials that differ in every number, and
// whether two trials are the same bit by bit.
#pragma once

#include <bit>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "eval/records/records.h"
#include "scenes/random/random.h"

namespace sightline {

class StoreTest : public ::testing::Test {
 protected:
  StoreTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              fmt::format("sightline_store_{}_{}", test->name(), getpid());
    std::filesystem::create_directories(folder_);
  }
  ~StoreTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const char* name = "results.sqlite") const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

inline void expect_complaint(const std::string& text, const std::filesystem::path& file,
                             const char* reason) {
  EXPECT_THAT(text, ::testing::HasSubstr(file.string()));
  EXPECT_THAT(text, ::testing::HasSubstr(reason));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("\n")));
}

// Every number of a record as bits, so that -0 differs from 0 and NaN equals NaN.
inline std::vector<uint64_t> bits_of(const Pose& pose) {
  std::vector<uint64_t> bits;
  for (const double x : pose.rotation.reshaped()) bits.push_back(std::bit_cast<uint64_t>(x));
  for (const double x : pose.translation) bits.push_back(std::bit_cast<uint64_t>(x));
  return bits;
}

inline void expect_same_bits(double a, double b) {
  EXPECT_EQ(std::bit_cast<uint64_t>(a), std::bit_cast<uint64_t>(b)) << a << " and " << b;
}

inline void expect_same(const ObservationRecord& a, const ObservationRecord& b) {
  EXPECT_EQ(a.feature, b.feature);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.is_visible, b.is_visible);
  EXPECT_EQ(a.is_outlier, b.is_outlier);
  expect_same_bits(a.pixel.x(), b.pixel.x());
  expect_same_bits(a.pixel.y(), b.pixel.y());
  expect_same_bits(a.true_pixel.x(), b.true_pixel.x());
  expect_same_bits(a.true_pixel.y(), b.true_pixel.y());
  expect_same_bits(a.error_px, b.error_px);
  expect_same_bits(a.error_sigmas, b.error_sigmas);
  EXPECT_EQ(a.label, b.label);
}

inline void expect_same(const LineRecord& a, const LineRecord& b) {
  EXPECT_EQ(a.feature, b.feature);
  EXPECT_EQ(a.edge, b.edge);
  EXPECT_EQ(a.label, b.label);
  for (const int i : {0, 1}) {
    expect_same_bits(a.pixel[i], b.pixel[i]);
    expect_same_bits(a.direction[i], b.direction[i]);
  }
  expect_same_bits(a.offset_variance_px2, b.offset_variance_px2);
  expect_same_bits(a.offset_slope_covariance, b.offset_slope_covariance);
  expect_same_bits(a.slope_variance, b.slope_variance);
  expect_same_bits(a.offset_px, b.offset_px);
  expect_same_bits(a.error_sigmas, b.error_sigmas);
}

inline void expect_same(const EstimateRecord& a, const EstimateRecord& b) {
  EXPECT_EQ(a.solver, b.solver);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(bits_of(a.cam_from_target), bits_of(b.cam_from_target));
  expect_same_bits(a.theta_error_deg, b.theta_error_deg);
  expect_same_bits(a.t_error_percent, b.t_error_percent);
  expect_same_bits(a.geodesic_deg, b.geodesic_deg);
  expect_same_bits(a.reprojection_rms_px, b.reprojection_rms_px);
  expect_same_bits(a.add_m, b.add_m);
  expect_same_bits(a.mssd_m, b.mssd_m);
  expect_same_bits(a.mspd_px, b.mspd_px);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_EQ(a.removed_lines, b.removed_lines);
  EXPECT_EQ(a.false_removals, b.false_removals);
  EXPECT_EQ(a.missed_outliers, b.missed_outliers);
  EXPECT_EQ(a.nees, b.nees);
  EXPECT_EQ(a.is_ambiguous, b.is_ambiguous);
  EXPECT_EQ(a.removed_probability, b.removed_probability);
  EXPECT_EQ(a.is_removal_limit_reached, b.is_removal_limit_reached);
  EXPECT_EQ(a.is_test_failed, b.is_test_failed);
  ASSERT_EQ(a.covariance.has_value(), b.covariance.has_value());
  if (!a.covariance) return;
  for (int i = 0; i < 36; ++i) {
    expect_same_bits(a.covariance->reshaped()(i), b.covariance->reshaped()(i));
  }
}

inline void expect_same(const OrientationRecord& a, const OrientationRecord& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.failures, b.failures);
  expect_same_bits(a.angle_error_deg, b.angle_error_deg);
  expect_same_bits(a.theta_error_deg, b.theta_error_deg);
  expect_same_bits(a.t_error_percent, b.t_error_percent);
  expect_same_bits(a.geodesic_deg, b.geodesic_deg);
  expect_same_bits(a.time_ns, b.time_ns);
}

inline void expect_same(const TrialRecord& a, const TrialRecord& b);

template <typename Record>
inline void expect_same(std::span<const Record> a, std::span<const Record> b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i]);
}

inline void expect_same(const std::vector<TrialRecord>& a, const std::vector<TrialRecord>& b) {
  expect_same<TrialRecord>(std::span(a), std::span(b));
}

inline void expect_same(const TrialRecord& a, const TrialRecord& b) {
  SCOPED_TRACE(fmt::format("trial {}", a.trial));
  EXPECT_EQ(a.trial, b.trial);
  EXPECT_EQ(a.condition, b.condition);
  EXPECT_EQ(a.redraws, b.redraws);
  EXPECT_EQ(bits_of(a.true_cam_from_target), bits_of(b.true_cam_from_target));
  ASSERT_EQ(a.kind.index(), b.kind.index());
  if (std::holds_alternative<PoseTrial>(a.kind)) {
    EXPECT_EQ(bits_of(a.pose_trial().prior_cam_from_target),
              bits_of(b.pose_trial().prior_cam_from_target));
  }
  expect_same(a.observations(), b.observations());
  expect_same(a.lines(), b.lines());
  expect_same(a.estimates(), b.estimates());
  expect_same(a.orientations(), b.orientations());
}

inline Pose drawn_pose(RandomStream& random) {
  return {random.rotation(), 1000 * random.normal3()};
}

inline Eigen::Matrix<double, 6, 6> drawn_covariance(RandomStream& random) {
  Eigen::Matrix<double, 6, 6> root;
  for (double& number : root.reshaped()) number = random.normal();
  const Eigen::Matrix<double, 6, 6> square = root * root.transpose();
  return square.selfadjointView<Eigen::Upper>();
}

inline EstimateRecord drawn_estimate(const char* solver, RandomStream& random) {
  EstimateRecord e;
  e.solver = solver;
  e.cam_from_target = drawn_pose(random);
  for (double* number : {&e.theta_error_deg, &e.t_error_percent, &e.geodesic_deg,
                         &e.reprojection_rms_px, &e.add_m, &e.mssd_m, &e.mspd_px}) {
    *number = random.normal();
  }
  e.removed = {"nose", "an 'odd', \"name\" °"};
  e.removed_lines = {"nose/1"};
  e.false_removals = 1;
  e.missed_outliers = 2;
  e.covariance = drawn_covariance(random);
  e.nees = random.normal();
  e.is_ambiguous = random.uniform() < 0.5;
  e.removed_probability = random.uniform();
  e.is_removal_limit_reached = random.uniform() < 0.5;
  return e;  // is_test_failed: the solver says nothing of it
}

// A trial with a different number in every place.
inline TrialRecord drawn_trial(int64_t number) {
  RandomStream random(3, "trial", number);
  TrialRecord trial;
  trial.trial = number;
  trial.condition = static_cast<int>(number % 4);
  trial.redraws = static_cast<int>(number % 7);
  trial.true_cam_from_target = drawn_pose(random);
  PoseTrial& pose_trial = trial.pose_trial();
  pose_trial.prior_cam_from_target = drawn_pose(random);
  for (const char* feature : {"nose", "wing_tip_le_port", "an 'odd', \"name\" °"}) {
    const Eigen::Vector2d pixel(random.normal(), random.normal());
    const Eigen::Vector2d true_pixel(random.normal(), random.normal());
    pose_trial.observations.push_back({feature, ObservationOutcome::kFound, random.uniform() < 0.5,
                                       pixel, true_pixel, random.normal(), random.normal(),
                                       random.uniform() < 0.5, ObservationLabel::kWrongLine});
  }
  for (const char* feature : {"fin_tip", "nose"}) {
    LineRecord& line = pose_trial.lines.emplace_back();
    line.feature = feature;
    line.edge = static_cast<int>(3 * random.uniform());
    line.label = random.uniform() < 0.5 ? LineLabel::kRight : LineLabel::kWrong;
    for (double* value :
         {&line.pixel.x(), &line.pixel.y(), &line.direction.x(), &line.direction.y(),
          &line.offset_slope_covariance, &line.offset_px, &line.error_sigmas}) {
      *value = random.normal();
    }
    line.offset_variance_px2 = 0.1 + random.uniform();
    line.slope_variance = std::numeric_limits<double>::infinity();
  }
  for (const char* solver : {"orpe", "lspe"}) {
    pose_trial.estimates.push_back(drawn_estimate(solver, random));
  }
  return trial;
}

inline TrialRecord drawn_orientation_trial(int64_t number) {
  RandomStream random(4, "trial", number);
  TrialRecord trial;
  trial.trial = number;
  trial.true_cam_from_target = drawn_pose(random);
  auto& orientations = trial.kind.emplace<OrientationTrial>().orientations;
  for (const char* method : {"fast", "umeyama"}) {
    orientations.push_back({method, EstimateOutcome::kDegenerate, 3, random.normal(),
                            random.normal(), random.normal(), random.normal(), random.normal()});
  }
  orientations.emplace_back().method = "not timed";
  return trial;
}

}  // namespace sightline
