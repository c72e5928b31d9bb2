// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/passes.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/summary/localisation.h"
#include "eval/trial/image_trial.h"
#include "scenes/files/input_error.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

// The 707 with all its features, as outlier-impact has it.
Study study_with(int trials, std::vector<std::string> settings) {
  settings.insert(settings.end(), {"solvers=['orpe_weighed']", "solver.inputs=[]", "sweep={}"});
  return read_study("outlier-impact", {.trials = trials, .seed = {}, .set = settings});
}

struct Result {
  Localisation localisation;
  double mean_geodesic_deg = 0;
};

Result result_of(int trials, const std::vector<std::string>& settings) {
  const Study study = study_with(trials, settings);
  Renderer renderer;
  LocalisationStatistics statistics;
  Result result;
  for (int64_t i = 0; i < trials; ++i) {
    const TrialRecord record = run_trial(study, i, renderer).record;
    statistics.add(record);
    EXPECT_TRUE(record.estimates()[0].is_ok());
    result.mean_geodesic_deg += record.estimates()[0].geodesic_deg / trials;
  }
  result.localisation = statistics.summary();
  return result;
}

int found_in(const Extraction& extraction) {
  return static_cast<int>(
      std::count_if(extraction.observations.begin(), extraction.observations.end(),
                    [](const Observation& o) { return o.status == ObservationStatus::kFound; }));
}

TEST(Passes, TwoFindMoreAndNearerThanOneFromABadPrior) {
  constexpr int kTrials = 6;
  const Result one = result_of(kTrials, {"prior.attitude_deg=4", "extraction.passes=1"});
  const Result two = result_of(kTrials, {"prior.attitude_deg=4", "extraction.passes=2"});
  EXPECT_GT(two.localisation.found_rate.value, one.localisation.found_rate.value + 0.02);
  EXPECT_LT(two.localisation.outlier_rate.value, one.localisation.outlier_rate.value / 2);
  EXPECT_LT(two.localisation.rms_px.value, one.localisation.rms_px.value);
}

TEST(Passes, OnePassLooksAroundThePrior) {
  const Study study = study_with(1, {"extraction.passes=1"});
  Renderer renderer;
  const Trial trial = run_trial(study, 0, renderer);
  const auto look = [&](int passes) {
    ImageStudy images = *study.images();
    images.setups.front().passes = passes;
    return extract(images, trial.record, trial.scene, trial.frame, renderer);
  };
  const auto off_deg = [&](const Extraction& extraction) {
    return geodesic_angle_rad(extraction.cam_from_target.rotation,
                              trial.record.true_cam_from_target.rotation) *
           180 / M_PI;
  };
  EXPECT_EQ(look(1).cam_from_target.rotation,
            trial.record.pose_trial().prior_cam_from_target.rotation);
  EXPECT_GT(off_deg(look(1)), 0.5);
  EXPECT_LT(off_deg(look(2)), 0.5);
}

TEST(Passes, RemovingTheBiasOfTheExtractorsLessensTheError) {
  constexpr int kTrials = 8;
  const Result off = result_of(kTrials, {"extraction.bias_removal=off"});
  const std::string exact = "extraction.bias_mesh_percent=100";
  const Result known = result_of(kTrials, {"extraction.bias_removal=known_light", exact});
  const Result wrong = result_of(kTrials, {"extraction.bias_removal=wrong_light", exact});
  EXPECT_LT(known.mean_geodesic_deg, 0.8 * off.mean_geodesic_deg);
  EXPECT_LT(known.localisation.rms_px.value, 0.8 * off.localisation.rms_px.value);
  EXPECT_LT(known.mean_geodesic_deg, wrong.mean_geodesic_deg);
}

// The same renderer made the image, noise apart: what is left once its bias is removed is next to
// nothing, unless image and rendering stand for light in different ways.
TEST(Passes, TheBiasIsThatOfTheImagesOwnEncoding) {
  constexpr int kTrials = 3;
  const auto rms_px = [&](const std::string& removal, const std::string& encoding) {
    return result_of(kTrials, {"image.encoding=" + encoding, "background.kind=uniform",
                               "noise.read_noise_grey=0", "extraction.noise_sd_grey=1",
                               "extraction.bias_mesh_percent=100", "prior.attitude_deg=0.01",
                               "prior.range_percent=0.01", "prior.lateral_px=0.01",
                               "extraction.bias_removal=" + removal})
        .localisation.rms_px.value;
  };
  EXPECT_LT(rms_px("known_light", "linear"), 0.5 * rms_px("off", "linear"));
  EXPECT_LT(rms_px("known_light", "srgb"), 0.5 * rms_px("off", "srgb"));
}

TEST(Passes, TheBiasIsThatOfACoarserMeshUnlessAskedOtherwise) {
  const auto triangles = [](const std::vector<std::string>& settings) {
    const Study study = study_with(1, settings);
    const auto& bias_target = study.images()->setups.front().bias_target;
    return bias_target == nullptr ? 0.0 : static_cast<double>(bias_target->mesh.triangles.size());
  };
  const double all =
      triangles({"extraction.bias_removal=wrong_light", "extraction.bias_mesh_percent=100"});
  EXPECT_EQ(all, static_cast<double>(study_with(1, {}).images()->target->mesh.triangles.size()));
  EXPECT_NEAR(triangles({"extraction.bias_removal=wrong_light"}) / all, 0.5, 0.02);
  EXPECT_NEAR(triangles({"extraction.bias_removal=known_light"}) / all, 0.5, 0.02);
  EXPECT_EQ(triangles({"extraction.bias_removal=off"}), 0);
  EXPECT_THROW(study_with(1, {"extraction.bias_mesh_percent=0"}), InputError);
  EXPECT_THROW(study_with(1, {"extraction.bias_mesh_percent=101"}), InputError);
}

// Of the target, a dot at fifty times the range, nothing is to be seen: the first pass finds what
// clouds show in its wide windows, the second less of it.
TEST(Passes, APassThatFindsLessThanHalfIsDropped) {
  const Study study = study_with(
      12, {"background.kind=clouds", "background.contrast=0.9", "background.cloud_px=10",
           "extraction.line_intersection=hough_intersection", "noise.read_noise_grey=0"});
  Renderer renderer;
  int kept = 0, dropped = 0;
  for (int64_t i = 0; i < study.trial_count(); ++i) {
    const Trial trial = run_trial(study, i, renderer);
    Scene empty = trial.scene;
    empty.cam_from_target.translation *= 50;
    const Frame frame = renderer.render(empty, RandomStream(1, "sensor", i));
    const auto look = [&](int passes) {
      ImageStudy images = *study.images();
      images.setups.front().passes = passes;
      return extract(images, trial.record, trial.scene, frame, renderer);
    };
    const Extraction one = look(1), two = look(2);
    EXPECT_GE(2 * found_in(two), found_in(one)) << i;
    const bool is_dropped = one.cam_from_target.rotation == two.cam_from_target.rotation;
    ++(is_dropped ? dropped : kept);
  }
  EXPECT_GE(kept, 1);
  EXPECT_GE(dropped, 1);
}

}  // namespace
}  // namespace sightline
