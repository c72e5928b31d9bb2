// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// From a mesh to a proposal that a user judges and changes, through the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/review/feature_errors.h"
#include "scenes/target/target.h"
#include "tests/eval/program.h"
#include "tests/eval/rounded_aircraft.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class TargetReview : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  void propose() const {
    write_rounded_aircraft(path("plane.obj"));
    const Outcome outcome = run("target " + path("plane.obj") + " --propose " + path("plane"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  std::string target_text() const { return read_whole(path("plane/target.toml")); }
  std::string target() const { return "target " + path("plane/target.toml"); }
  TemporaryFolder folder_;
};

TEST_F(TargetReview, TheTipsOfARoundedAircraftAreFoundWithinTwoPixels) {
  propose();
  const auto plane = load_target(path("plane/target.toml"));
  ASSERT_GE(plane->features.size(), 6u);
  int good = 0;
  const auto errors = feature_errors(plane);
  for (size_t i = 0; i < errors.size(); ++i) {
    const FeatureError& error = errors[i];
    EXPECT_GT(error.visible_fraction, 0.3) << plane->features[i].name;
    // The edge of what is rounded darkens, and is seen 1 to 2 px inside its outline.
    good += error.found > 0.5 * error.shown && error.median_px < 2;
  }
  EXPECT_GE(good, 6);
  // In the middle of the belly the outline runs straight, and tells nothing along it.
  ASSERT_EQ(run(target() + " --add 0,0,0.6,belly").exit_code, 0);
  const FeatureError belly = feature_errors(load_target(path("plane/target.toml"))).back();
  EXPECT_LT(belly.found, 0.5 * belly.shown);
}

TEST_F(TargetReview, ThePageShowsEveryFeatureAndNeedsNoNetwork) {
  propose();
  const Outcome outcome = run(target() + " --review " + path("review.html"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string page = read_whole(path("review.html"));
  const auto plane = load_target(path("plane/target.toml"));
  for (const TargetFeature& feature : plane->features) {
    EXPECT_THAT(page, HasSubstr(feature.name + "</text>"));
    EXPECT_THAT(page, HasSubstr(feature.name + "</th>"));
  }
  for (const char* side : {"above", "below", "port", "starboard", "ahead", "behind"}) {
    EXPECT_THAT(page, HasSubstr(std::string("<h3>from ") + side));
  }
  EXPECT_THAT(page, AllOf(HasSubstr("data:image/png;base64,"), Not(HasSubstr("src=\"http")),
                          Not(HasSubstr("{{"))));
  EXPECT_THAT(run(target() + " --review " + path("review.txt")).output, HasSubstr(".html"));
  EXPECT_THAT(run("target " + path("plane.obj") + " --review " + path("bare.html")).output,
              HasSubstr("has no features"));
}

TEST_F(TargetReview, FeaturesAreDroppedAndAddedInPlace) {
  propose();
  const auto before = load_target(path("plane/target.toml"));
  const std::string first = before->features.front().name;
  const Outcome outcome = run(target() + " --drop " + first + " --add 0,0,0.6,belly");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              AllOf(HasSubstr("dropped    " + first), HasSubstr("added      belly")));
  const auto after = load_target(path("plane/target.toml"));
  ASSERT_EQ(after->features.size(), before->features.size());
  EXPECT_EQ(after->features.front().name, before->features[1].name);
  EXPECT_EQ(after->features.back().name, "belly");
  EXPECT_EQ(after->features.back().kind, FeatureKind::kContour);
}

TEST_F(TargetReview, AChangeThatCannotBeLeavesTheFileAsItWas) {
  propose();
  const std::string text = target_text();
  const std::string name = load_target(path("plane/target.toml"))->features.front().name;
  for (const auto& [change, problem] :
       {std::pair<std::string, std::string>("--drop nobody", "no such feature"),
        {"--drop " + name + " nobody", "no such feature"},
        {"--add 1,2", "must be x,y,z"},
        {"--add 1,2,x", "must be x,y,z"},
        {"--add 0,0,0.6," + name, "of that name"},
        {"--add 50,0,0", "off the mesh"}}) {
    const Outcome outcome = run(target() + " " + change);
    EXPECT_EQ(outcome.exit_code, 1) << change;
    EXPECT_THAT(outcome.output, HasSubstr(problem)) << change;
    EXPECT_EQ(target_text(), text) << change;
  }
  EXPECT_THAT(run("target " + path("plane.obj") + " --drop x").output, HasSubstr("target.toml"));
}

}  // namespace
}  // namespace sightline
