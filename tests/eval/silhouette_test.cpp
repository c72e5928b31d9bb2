// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/silhouette.h"

#include <map>
#include <string>

#include <gtest/gtest.h>

#include "eval/target_report.h"

namespace sightline {
namespace {

std::map<std::string, SilhouetteOffset> offsets_of(const char* name) {
  const auto target = load_target(name);
  const auto offsets = silhouette_offsets(*target);
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

TEST(Silhouette, IsSaidOfEveryFeature) {
  TargetArguments arguments;
  arguments.target = "boeing707";
  const std::string text = report_target(arguments);
  EXPECT_NE(text.find("feature                         views  median px  max px"),
            std::string::npos);
  EXPECT_NE(text.find("\nnose                              "), std::string::npos);
}

}  // namespace
}  // namespace sightline
