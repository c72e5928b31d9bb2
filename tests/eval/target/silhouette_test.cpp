// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/target/silhouette.h"

#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "eval/target/target_report.h"
#include "tests/features/plate.h"

namespace sightline {
namespace {

std::map<std::string, SilhouetteOffset> offsets_of(const char* name) {
  const auto target = load_target(name);
  std::vector<int> features(target->features.size());
  std::iota(features.begin(), features.end(), 0);
  const auto offsets = silhouette_offsets(*target, features, views_all_round(*target));
  std::map<std::string, SilhouetteOffset> by_name;
  for (size_t i = 0; i < offsets.size(); ++i) by_name[target->features[i].name] = offsets[i];
  return by_name;
}

TEST(Silhouette, OfSharpEdgesIsTheEdges) {
  for (const auto& [name, offset] : offsets_of("cube")) {
    EXPECT_GT(offset.views, kSilhouetteViews / 3) << name;
    EXPECT_LT(offset.median_px, 1e-6) << name;
    // A face seen all but edge-on has two outlines, nearer each other than can be told apart.
    EXPECT_LT(offset.greatest_px, 0.3) << name;
  }
}

TEST(Silhouette, OfARoundedLeadingEdgeLiesBesideTheCreaseOfASharpTrailingEdgeLess) {
  const auto offsets = offsets_of("boeing707");
  for (const std::string of : {"wing_tip_", "tailplane_tip_"}) {
    const SilhouetteOffset& leading = offsets.at(of + "le_port");
    const SilhouetteOffset& trailing = offsets.at(of + "te_port");
    EXPECT_GT(leading.median_px, 0.01);
    EXPECT_LT(leading.median_px, 1);
    EXPECT_GT(leading.median_px, trailing.median_px);
    EXPECT_GE(leading.greatest_px, leading.median_px);
    // The same in metres: of 400 px to the box's diagonal of some 66 m.
    EXPECT_NEAR(leading.median_m / leading.median_px, 66.0 / kSilhouetteSizePx, 0.01);
  }
  EXPECT_EQ(offsets.at("nacelle_front_1").views, 0) << "no point of an outline";
}

// A point of a plate, 0.2 m from its border, by whose outline it is known.
Target plate_with_point() {
  Target plate = plate_target();
  TargetFeature point;
  point.name = "point";
  point.position_m = {kPlateHalfM - 0.2, 0.123, 0};
  point.parts = {"plate"};
  plate.features = {point};
  plate.shapes = feature_shapes(plate.mesh, plate.features);
  return plate;
}

TEST(Silhouette, OfAPointInsideItsOutlineIsTheDistanceToThat) {
  const Target plate = plate_with_point();
  const std::vector<int> point = {0};
  const std::vector<TargetView> near = {{plate_camera(), plate_pose(20)}};  // 10 px a metre
  const SilhouetteOffset offset = silhouette_offsets(plate, point, near).at(0);
  EXPECT_EQ(offset.views, 1);
  EXPECT_NEAR(offset.median_px, 2, 1e-6);
  EXPECT_NEAR(offset.greatest_m, 0.2, 1e-7);

  // With one from twice as far: half as many pixels and as many metres.
  std::vector<TargetView> both = {near[0], near[0]};
  both[1].cam_from_target.translation *= 2;
  const SilhouetteOffset of_both = silhouette_offsets(plate, point, both).at(0);
  EXPECT_EQ(of_both.views, 2);
  EXPECT_NEAR(of_both.median_px, 1.5, 1e-6);
  EXPECT_NEAR(of_both.greatest_px, 2, 1e-6);
  EXPECT_NEAR(of_both.median_m, 0.2, 1e-7);

  // From behind the plate is not there.
  std::vector<TargetView> behind = near;
  behind[0].cam_from_target.translation *= -1;
  EXPECT_EQ(silhouette_offsets(plate, point, behind).at(0).views, 0);
  EXPECT_TRUE(silhouette_offsets(plate, {}, near).empty());
}

TEST(Silhouette, IsSaidOfEveryFeature) {
  TargetArguments arguments;
  arguments.target = "boeing707";
  const std::string text = report_target(arguments).text;
  EXPECT_NE(text.find("feature                         views  median px  max px"),
            std::string::npos);
  EXPECT_NE(text.find("\nnose                              "), std::string::npos);
}

}  // namespace
}  // namespace sightline
