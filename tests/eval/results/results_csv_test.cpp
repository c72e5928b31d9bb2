// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/results_csv.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/random/random.h"
#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using namespace handmade;

using ::testing::ElementsAre;

std::string to_csv(const Study& study, const std::vector<TrialRecord>& trials) {
  std::ostringstream text;
  write_csv(study, in_order(trials), text);
  return text.str();
}

using Row = std::map<std::string, std::string>;

// The fields of an RFC 4180 text, written without a look at the writer.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, {""});
  bool is_quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      lines.back().back() += text[++i];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      lines.back().emplace_back();
    } else if (c == '\n' && !is_quoted) {
      lines.push_back({""});
    } else {
      lines.back().back() += c;
    }
  }
  lines.pop_back();
  return lines;
}

std::vector<Row> rows_of(const Study& study, const std::vector<TrialRecord>& trials) {
  const auto lines = parse_csv(to_csv(study, trials));
  std::vector<Row> rows;
  for (size_t i = 1; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i].size(), lines[0].size()) << "line " << i;
    Row& row = rows.emplace_back();
    for (size_t k = 0; k < lines[0].size(); ++k) row[lines[0][k]] = lines[i][k];
  }
  return rows;
}

TEST(ResultsCsv, HasItsHeaderAndARowATrialAndSolver) {
  const std::string csv = to_csv(two_poses(), handmade_trials());
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "trial,condition,noise_px,pose,solver,status,theta_error_deg,t_error_percent,"
            "geodesic_deg,reprojection_rms_px,add_m,mssd_m,mspd_px,nees,removed,false_removals,"
            "missed_outliers,found,outliers,qw,qx,qy,qz,tx_m,ty_m,tz_m,true_qw,true_qx,true_qy,"
            "true_qz,true_tx_m,true_ty_m,true_tz_m,ambiguous,removed_probability,"
            "removal_limit_reached,test_failed");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12);
  EXPECT_EQ(csv.back(), '\n');
  std::vector<std::string> order;
  for (const Row& row : rows_of(two_poses(), handmade_trials())) {
    order.push_back(row.at("trial") + " " + row.at("solver"));
  }
  order.resize(4);
  EXPECT_THAT(order, ElementsAre("0 orpe", "0 lspe", "0 oracle", "1 orpe"));
}

TEST(ResultsCsv, SaysWhatBecameOfATrial) {
  const Row row = rows_of(two_poses(), handmade_trials())[9];
  EXPECT_EQ(row.at("trial"), "4");
  EXPECT_EQ(row.at("condition"), "pose 1");
  EXPECT_EQ(row.at("noise_px"), "0.5");
  EXPECT_EQ(row.at("solver"), "orpe");
  EXPECT_EQ(row.at("status"), "ok");
  EXPECT_EQ(row.at("geodesic_deg"), "2");
  EXPECT_EQ(row.at("removed"), "a;b");
  EXPECT_EQ(row.at("false_removals"), "1");
  EXPECT_EQ(row.at("found"), "3");
  EXPECT_EQ(row.at("outliers"), "0");
}

TEST(ResultsCsv, LeavesAFailuresNumbersEmptyAndCountsItsOutliersAsMissed) {
  const Row row = rows_of(two_poses(), handmade_trials())[6];
  EXPECT_EQ(row.at("status"), "degenerate");
  for (const char* key :
       {"theta_error_deg", "t_error_percent", "geodesic_deg", "reprojection_rms_px", "add_m",
        "mssd_m", "mspd_px", "removed", "qw", "qz", "tx_m", "tz_m"}) {
    EXPECT_EQ(row.at(key), "") << key;
  }
  EXPECT_EQ(row.at("false_removals"), "0");
  EXPECT_EQ(row.at("missed_outliers"), "1");
  EXPECT_EQ(row.at("true_qw"), "1") << "the truth is there all the same";
}

TEST(ResultsCsv, EndsWithWhatTheSolverSaysAndIsEmptyWhereItSaysNothing) {
  std::vector<TrialRecord> trials = handmade_trials();
  EstimateRecord& estimate = trials[0].pose_trial().estimates[0];
  estimate.is_ambiguous = true;
  estimate.removed_probability = 0.75;
  estimate.is_removal_limit_reached = false;
  const std::vector<Row> rows = rows_of(two_poses(), trials);
  EXPECT_EQ(rows[0].at("ambiguous"), "1");
  EXPECT_EQ(rows[0].at("removed_probability"), "0.75");
  EXPECT_EQ(rows[0].at("removal_limit_reached"), "0");
  EXPECT_EQ(rows[0].at("test_failed"), "");
  for (const char* key : {"ambiguous", "removed_probability", "removal_limit_reached"}) {
    EXPECT_EQ(rows[1].at(key), "") << key;
  }
}

TEST(ResultsCsv, ReadsBackTheSameNumbers) {
  std::vector<TrialRecord> trials = handmade_trials();
  RandomStream random(1, "csv", 0);
  trials[0].true_cam_from_target = {random.rotation(), 1300 * random.normal3()};
  trials[0].pose_trial().estimates[0].cam_from_target = {random.rotation(),
                                                         1e-7 * random.normal3()};
  trials[0].pose_trial().estimates[0].theta_error_deg = 1.0 / 3;
  const Row row = rows_of(two_poses(), trials)[0];
  const auto value = [&row](const std::string& key) { return std::stod(row.at(key)); };
  const auto expect_pose = [&value](const std::string& prefix, const Pose& pose) {
    EXPECT_EQ(value(prefix + "tx_m"), pose.translation.x());
    EXPECT_EQ(value(prefix + "ty_m"), pose.translation.y());
    EXPECT_EQ(value(prefix + "tz_m"), pose.translation.z());
    const Eigen::Vector4d quaternion(value(prefix + "qw"), value(prefix + "qx"),
                                     value(prefix + "qy"), value(prefix + "qz"));
    EXPECT_EQ(quaternion, quaternion_wxyz(pose.rotation));
  };
  EXPECT_EQ(value("theta_error_deg"), 1.0 / 3);
  expect_pose("", trials[0].pose_trial().estimates[0].cam_from_target);
  expect_pose("true_", trials[0].true_cam_from_target);
}

TEST(ResultsCsv, QuotesWhatNeedsIt) {
  Study study = two_poses();
  study.conditions[0].label = "near, \"bright\"\nand steep";
  study.conditions[1].values.erase("noise_px");
  const std::vector<Row> rows = rows_of(study, handmade_trials());
  EXPECT_EQ(rows[0].at("condition"), "near, \"bright\"\nand steep");
  EXPECT_EQ(rows[0].at("noise_px"), "0.5");
  EXPECT_EQ(rows[3].at("condition"), "pose 2");
  EXPECT_EQ(rows[3].at("noise_px"), "") << "a value that only the other condition has";
}

TEST(ResultsCsv, DoesNotDependOnTheOrderOfTheTrials) {
  std::vector<TrialRecord> trials = handmade_trials();
  const std::string csv = to_csv(two_poses(), trials);
  std::reverse(trials.begin(), trials.end());
  EXPECT_EQ(to_csv(two_poses(), trials), csv);
}

}  // namespace
}  // namespace sightline
