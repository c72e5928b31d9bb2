// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/outlier_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/trial/numeric_trial.h"
#include "scenes/files/input_error.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

ObservationRecord record(const std::string& feature, bool is_found, bool is_outlier,
                         const Eigen::Vector2d& error) {
  ObservationRecord out;
  out.feature = feature;
  if (!is_found) out.status = ObservationOutcome::kTooFewEdgePixels;
  out.is_visible = true;
  out.true_pixel = {100, 50};
  out.pixel = out.true_pixel + error;
  out.is_outlier = is_outlier;
  return out;
}

std::vector<TrialRecord> three_trials() {
  std::vector<TrialRecord> trials(3);
  trials[0].pose_trial().observations = {record("vertex_0", true, true, {20, -3}),
                                         record("vertex_1", true, false, {1, 1})};
  trials[1].pose_trial().observations = {record("vertex_0", true, false, {0, 0}),
                                         record("vertex_1", false, false, {0, 0})};
  return trials;  // the third could not be imaged
}

std::filesystem::path write(const TemporaryFolder& folder, const std::string& text) {
  return folder.write("outliers.json", text);
}

TEST(OutlierModel, KeepsWhatFailedTogether) {
  const OutlierModel model = outlier_model_of(three_trials());
  ASSERT_EQ(model.trials.size(), 2u);
  ASSERT_EQ(model.trials[0].size(), 1u);
  EXPECT_EQ(model.trials[0][0].feature, "vertex_0");
  EXPECT_EQ(model.trials[0][0].displacement_px, Eigen::Vector2d(20, -3));
  ASSERT_EQ(model.trials[1].size(), 1u);
  EXPECT_TRUE(model.trials[1][0].is_missing);
}

TEST(OutlierModel, IsReadBackAsWritten) {
  const TemporaryFolder folder;
  const auto file = write(folder, to_json(outlier_model_of(three_trials()), "a study"));
  const OutlierModel back = read_outlier_model(file);
  ASSERT_EQ(back.trials.size(), 2u);
  EXPECT_EQ(back.trials[0][0].feature, "vertex_0");
  EXPECT_EQ(back.trials[0][0].displacement_px, Eigen::Vector2d(20, -3));
  EXPECT_TRUE(back.trials[1][0].is_missing);
  EXPECT_EQ(back.trials[1][0].feature, "vertex_1");
}

TEST(OutlierModel, BadFilesGetOneClearLine) {
  const TemporaryFolder folder;
  const auto model_error = [&](const std::string& text) {
    return error_of([&] { read_outlier_model(write(folder, text)); });
  };
  EXPECT_THAT(model_error("{"), HasSubstr("not an outliers.json"));
  EXPECT_THAT(model_error(R"({"features": ["a"], "trials": [[[1]]]})"),
              HasSubstr("not an outliers"));
  EXPECT_THAT(model_error(R"({"features": ["a"], "trials": [[[0, 1]]]})"), HasSubstr("not an out"));
  EXPECT_THAT(model_error(R"({"features": ["a"], "trials": [[[0, 1e999, 0]]]})"),
              HasSubstr("not an outliers.json"));
  EXPECT_THAT(model_error(R"({"features": ["a"], "trials": []})"), HasSubstr("no trials"));
  EXPECT_THROW(read_outlier_model(folder.path() / "none.json"), InputError);
}

TEST(OutlierModel, ANumericStudyReplaysItsTrials) {
  const TemporaryFolder folder;
  const Study cube = read_study("cube-noise");
  const std::string first = cube.numeric()->feature(0).name;
  const std::string second = cube.numeric()->feature(1).name;
  std::vector<TrialRecord> measured(2);
  measured[0].pose_trial().observations = {record(first, true, true, {20, -3})};
  measured[1].pose_trial().observations = {record(second, false, false, {0, 0})};
  const auto file = write(folder, to_json(outlier_model_of(measured), "measured"));

  const Study study = read_study(
      "cube-noise", {.trials = 50, .seed = {}, .set = {"outliers.model='" + file.string() + "'"}});
  int displaced = 0, missing = 0;
  for (int i = 0; i < 50; ++i) {
    const TrialRecord trial = run_numeric_trial(study, i);
    const ObservationRecord& a = trial.observations()[0];
    const ObservationRecord& b = trial.observations()[1];
    EXPECT_NE(a.is_outlier, !b.is_found()) << i;  // one of the two trials, never both
    if (a.is_outlier) {
      ++displaced;
      EXPECT_TRUE((a.pixel - a.true_pixel).isApprox(Eigen::Vector2d(20, -3), 1e-9));
      EXPECT_EQ(a.label, ObservationLabel::kPlanted);
    } else {
      ++missing;
      EXPECT_EQ(b.label, ObservationLabel::kMissing);
    }
  }
  EXPECT_GT(displaced, 10);
  EXPECT_GT(missing, 10);
}

TEST(OutlierModel, OfOtherFeaturesIsRefused) {
  const TemporaryFolder folder;
  const auto file = write(folder, R"({"features": ["fin"], "trials": [[[0]]]})");
  try {
    read_study("cube-noise",
               {.trials = {}, .seed = {}, .set = {"outliers.model='" + file.string() + "'"}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no \"fin\""));
  }
}

}  // namespace
}  // namespace sightline
