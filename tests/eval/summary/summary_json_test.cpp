// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary_json.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using namespace handmade;

using ::testing::ElementsAre;
using Json = nlohmann::ordered_json;

std::vector<std::string> keys_of(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

Json handmade_json() {
  return Json::parse(to_json(two_poses(), summarise(two_poses(), handmade_trials())));
}

TEST(SummaryJson, HasTheKeysOfTheContract) {
  const Json json = handmade_json();
  EXPECT_THAT(keys_of(json),
              ElementsAre("study", "seed", "cells", "observations", "features", "extraction"));
  ASSERT_EQ(json["extraction"].size(), json["observations"].size());
  ASSERT_EQ(json["cells"].size(), 6);
  for (const Json& cell : json["cells"]) {
    EXPECT_THAT(keys_of(cell),
                ElementsAre("condition", "solver", "trials", "failures", "theta_error_deg",
                            "t_error_percent", "geodesic_deg", "ratio_to_oracle", "ratio_to_bound",
                            "false_removals", "missed_outliers", "exact_set_rate", "capped",
                            "failure_rate_ci95", "exact_set_rate_ci95", "ratio_to_oracle_ci95",
                            "ratio_to_bound_ci95", "nees", "ratio_to_oracle_median",
                            "ratio_to_oracle_median_ci95", "ratio_to_bound_median",
                            "ratio_to_bound_median_ci95"));
    for (const char* error : {"theta_error_deg", "t_error_percent", "geodesic_deg"}) {
      EXPECT_THAT(keys_of(cell[error]), ElementsAre("mean", "mean_ci95", "median", "median_ci95",
                                                    "rms", "rms_ci95", "p90", "p90_ci95"));
      EXPECT_TRUE(cell[error]["mean"].is_number());
      EXPECT_EQ(cell[error]["mean_ci95"].size(), 2);
    }
    EXPECT_TRUE(cell["trials"].is_number_integer());
    EXPECT_TRUE(cell["failures"].is_number_integer());
    EXPECT_TRUE(cell["capped"].is_number_integer());
  }
  for (const Json& cell : json["observations"]) {
    EXPECT_THAT(keys_of(cell),
                ElementsAre("condition", "trials", "trials_repeated", "found_per_trial",
                            "outliers_per_trial", "inlier_rms_px", "bound_theta_deg",
                            "bound_t_percent", "bound_geodesic_deg"));
  }
  ASSERT_EQ(json["features"].size(), 3);
  for (const Json& feature : json["features"]) {
    EXPECT_THAT(keys_of(feature),
                ElementsAre("condition", "feature", "trials_visible", "trials_found",
                            "trials_outlier", "inlier_rms_px", "median_error_px"));
  }
}

TEST(SummaryJson, SaysWhatTheSummarySays) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const Json json = handmade_json();
  EXPECT_EQ(json["study"], "tiny");
  EXPECT_EQ(json["seed"], 7);
  const Json& orpe = json["cells"][0];
  EXPECT_EQ(orpe["solver"], "orpe");
  EXPECT_EQ(orpe["failures"], 1);
  EXPECT_EQ(orpe["capped"], 1);
  EXPECT_EQ(orpe["geodesic_deg"]["rms"].get<double>(), summary.cells[0].geodesic_deg.rms);
  EXPECT_EQ(orpe["geodesic_deg"]["mean_ci95"][1].get<double>(),
            summary.cells[0].geodesic_deg.mean_ci95[1]);
  EXPECT_EQ(orpe["ratio_to_oracle"].get<double>(), summary.cells[0].ratio_to_oracle);
}

TEST(SummaryJson, WritesKeysThatAreWholeNumbersThroughoutAsIntegers) {
  const Json json = handmade_json();
  const Json& condition = json["cells"][3]["condition"];
  EXPECT_TRUE(condition["pose"].is_number_integer());
  EXPECT_EQ(condition["pose"], 2);
  EXPECT_TRUE(condition["noise_px"].is_number_float()) << "the other condition has 0.5";
  EXPECT_EQ(condition["noise_px"], 2.0);
}

TEST(SummaryJson, WritesNullForWhatIsNoNumber) {
  const Json json = handmade_json();
  const Json& dark = json["cells"][3];
  EXPECT_TRUE(dark["geodesic_deg"]["median"].is_null());
  EXPECT_TRUE(dark["ratio_to_bound"].is_null());
  EXPECT_TRUE(json["observations"][1]["inlier_rms_px"].is_null());
  EXPECT_EQ(dark["geodesic_deg"]["mean"], 20);
}

}  // namespace
}  // namespace sightline
