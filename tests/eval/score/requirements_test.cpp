// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/requirements.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/cube_of_100_mm.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A cube 1000 mm away in each of two images, of which one is estimated, 10 mm off along the ray.
struct HalfFound {
  BopDataset dataset;
  std::vector<BopEstimate> estimates;
  BopScores scores;

  HalfFound() {
    BopModel model;
    model.points_mm = cube_points();
    model.diameter_mm = 100 * std::sqrt(3.0);
    model.symmetries = kNoSymmetry;
    dataset.models = {{1, model}};
    for (int i = 0; i < 2; ++i) {
      BopImage& image = dataset.images.emplace_back();
      image.im_id = i;
      image.width_px = 640;
      image.k = k_of(500, 320);
      image.instances.push_back({.obj_id = 1, .cam_from_model = at_1000_mm()});
      image.targets[1] = 1;
    }
    estimates.push_back({.scene_id = 0,
                         .im_id = 0,
                         .obj_id = 1,
                         .score = 1,
                         .cam_from_model = shifted(at_1000_mm(), {0, 0, 10})});
    scores = score_bop(dataset, estimates, 15);
  }

  std::vector<RequirementResult> check(const std::string& text) const {
    const std::vector<MethodScores> methods = {
        {"mine", {"mine.csv", "set", 15, dataset, estimates, scores}}};
    const std::vector<Requirement> requirements = {parse_requirement(text)};
    return check_requirements(requirements, methods);
  }
};

TEST(Requirements, AreMetOrNot) {
  const HalfFound half;
  for (const char* met : {"add_recall>=0.5", "ADD >= 0.4", "failure_rate<=0.5", "ar_mssd>=0.45",
                          "geodesic_deg.mean<=10", "within_5deg_5cm<=0.5"}) {
    EXPECT_TRUE(half.check(met).at(0).is_met) << met;
  }
  for (const char* missed : {"add_recall>=0.51", "add_recall<=0.49", "failure_rate<=0.1",
                             "ar_mssd>=0.46", "geodesic_deg.mean<=9.99"}) {
    EXPECT_FALSE(half.check(missed).at(0).is_met) << missed;
  }
  EXPECT_EQ(to_text(half.check("add_recall>=0.9")[0]),
            "mine: add_recall is 0.5, must be 0.9 or more");
  EXPECT_EQ(to_text(half.check("add_recall>=0.5")[0]),
            "mine: add_recall is 0.5, which is 0.5 or more");
}

// Turned by a quarter about z every vertex of the cube lies where another was: ADI is 0, and ADD is
// far too great, which counts unless the cube is said to have that symmetry.
TEST(Requirements, AddSKnowsWhichObjectsHaveSymmetries) {
  HalfFound half;
  half.estimates[0].cam_from_model = at_1000_mm(turn_z(std::numbers::pi / 2));
  half.scores = score_bop(half.dataset, half.estimates, 15);
  EXPECT_EQ(half.check("ADD-S>=0.5").at(0).value, 0.5);
  EXPECT_EQ(half.check("ADD(-S)>=0.5").at(0).value, 0);
  half.dataset.models.at(1).symmetries.push_back({turn_z(std::numbers::pi / 2), {0, 0, 0}});
  half.scores = score_bop(half.dataset, half.estimates, 15);
  EXPECT_EQ(half.check("ADD(-S)>=0.5").at(0).value, 0.5);
  EXPECT_EQ(half.check("ADD>=0.5").at(0).value, 0);
}

TEST(Requirements, AreTestCasesOfJUnit) {
  const HalfFound half;
  const std::string missed = to_junit(half.check("add_recall>=0.9"), "set");
  EXPECT_THAT(missed, HasSubstr("<testsuite name=\"scores\" tests=\"1\" failures=\"1\">"));
  EXPECT_THAT(missed, HasSubstr("<failure message=\"mine: add_recall is 0.5, must be 0.9"));
  EXPECT_THAT(missed, HasSubstr("<property name=\"dataset\" value=\"set\" />"));
  EXPECT_THAT(to_junit(half.check("add_recall>=0.5"), "set"), HasSubstr("failures=\"0\""));
}

TEST(Requirements, BadOnesGetOneClearLine) {
  const auto error = [](const std::string& text) {
    return error_of([&] { parse_requirement(text); });
  };
  for (const char* text : {"add_recall", "add_recall>0.9", "add_recall>=", "add_recall>=much",
                           "add_recall>=nan", ">=0.5", "add_recall=0.9"}) {
    EXPECT_THAT(error(text), HasSubstr("--require '" + std::string(text) + "'")) << text;
  }
  EXPECT_THAT(error("add_recal>=0.9"), HasSubstr("did you mean 'add_recall'"));
  // Without depth there is no AR, which must not pass for one that is met.
  const HalfFound half;
  EXPECT_THAT(error_of([&] { half.check("ar>=0.5"); }), HasSubstr("does not let ar be known"));
}

}  // namespace
}  // namespace sightline
