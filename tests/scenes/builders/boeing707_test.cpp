// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/boeing707.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/random/random.h"
#include "scenes/target/target.h"
#include "tests/scenes/builders/built_mesh.h"

namespace sightline {
namespace {

// A triangle's corners as micrometres with y multiplied by `side`, in an order that depends on the
// triangle alone.
std::array<std::array<int64_t, 3>, 3> corners_on_side(const Mesh& mesh, const Triangle& triangle,
                                                      int side) {
  std::array<std::array<int64_t, 3>, 3> corners;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d p = mesh.vertices[triangle.vertex[i]] * 1e6;
    corners[i] = {std::llround(p.x()), side * std::llround(p.y()), std::llround(p.z())};
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

const TargetFeature& feature_named(const std::vector<TargetFeature>& features,
                                   const std::string& name) {
  const auto found = std::find_if(features.begin(), features.end(),
                                  [&](const TargetFeature& f) { return f.name == name; });
  EXPECT_NE(found, features.end()) << name;
  return *found;
}

class Boeing707Test : public testing::Test {
 protected:
  const Mesh mesh_ = build_boeing707();
  const std::vector<TargetFeature> features_ = boeing707_features();

  Eigen::Vector3d position(const std::string& name) const {
    return feature_named(features_, name).position_m;
  }
};

TEST_F(Boeing707Test, HasThePublishedLengthAndSpan) {
  const Bounds box = bounds(mesh_);
  EXPECT_NEAR(box.max_m.x() - box.min_m.x(), 46.61, kGridM);
  EXPECT_NEAR(box.max_m.y() - box.min_m.y(), 44.42, kGridM);
  EXPECT_NEAR(box.max_m.x(), 22.0, kGridM);
}

TEST_F(Boeing707Test, HasThePublishedFuselageWidth) {
  double half_width_m = 0;
  double rear_m = 0;
  for (const Triangle& triangle : mesh_.triangles) {
    const std::string& part = mesh_.parts[triangle.part].name;
    if (part.rfind("fuselage", 0) != 0 && part != "tail_cone") continue;
    for (const int v : triangle.vertex) {
      half_width_m = std::max(half_width_m, mesh_.vertices[v].y());
      rear_m = std::min(rear_m, mesh_.vertices[v].x());
    }
  }
  EXPECT_NEAR(2 * half_width_m, 3.76, kGridM);
  EXPECT_NEAR(22.0 - rear_m, 44.35, kGridM);
}

TEST_F(Boeing707Test, FinTipIsThePublishedHeightAboveTheGround) {
  constexpr double kGroundBelowAxisM = 3.63;
  EXPECT_NEAR(-bounds(mesh_).min_m.z() + kGroundBelowAxisM, 12.93, kGridM);
}

TEST_F(Boeing707Test, OuterWingIsSwept35DegreesAtTheQuarterChord) {
  const Boeing707 d;
  const auto quarter = [&](double y_m) {
    return Eigen::Vector3d(0.75 * d.wing_leading_edge(y_m) + 0.25 * d.wing_trailing_edge(y_m));
  };
  const Eigen::Vector3d along = quarter(d.wing_kink_y_m) - quarter(d.span_m / 2);
  EXPECT_NEAR(std::atan2(along.x(), -along.y()) * kDegreesPerRadian, 35, 0.1);
}

TEST_F(Boeing707Test, WingHasThePublishedDihedral) {
  for (const char* edge : {"le", "te"}) {
    const TargetFeature& tip =
        feature_named(features_, std::string("wing_tip_") + edge + "_starboard");
    const Eigen::Vector3d out = tip.edges[0].begin_m - tip.edges[0].end_m;
    EXPECT_NEAR(std::atan2(-out.z(), out.y()) * kDegreesPerRadian, 7, 1e-4);
  }
}

TEST_F(Boeing707Test, NoVertexOfTheWingLiesAheadOfTheLeadingEdge) {
  const Boeing707 d;
  for (const Triangle& triangle : mesh_.triangles) {
    if (mesh_.parts[triangle.part].name.rfind("wing_starboard", 0) != 0) continue;
    for (const int v : triangle.vertex) {
      const Eigen::Vector3d& p = mesh_.vertices[v];
      ASSERT_LE(p.x(), d.wing_leading_edge(p.y()).x() + kGridM);
      ASSERT_GE(p.x(), d.wing_trailing_edge(p.y()).x() - kGridM);
    }
  }
}

TEST_F(Boeing707Test, TipsArePinchedToOneCrease) {
  const double tip_y_m = Boeing707{}.span_m / 2;
  const Eigen::Vector3d le = position("wing_tip_le_starboard");
  const Eigen::Vector3d along = (position("wing_tip_te_starboard") - le).normalized();
  int on_tip = 0;
  for (const Eigen::Vector3d& v : mesh_.vertices) {
    if (v.y() < tip_y_m - kGridM) continue;
    EXPECT_LT((v - le).cross(along).norm(), kGridM);
    ++on_tip;
  }
  EXPECT_GE(on_tip, 20);
}

TEST_F(Boeing707Test, LeadingEdgesAreSmoothAndTrailingEdgesSharp) {
  const Boeing707 d;
  const int leading = vertex_at(mesh_, d.wing_leading_edge(d.wing_kink_y_m));
  const int trailing = vertex_at(mesh_, d.wing_trailing_edge(d.wing_kink_y_m));
  ASSERT_GE(leading, 0);
  ASSERT_GE(trailing, 0);
  double least_cos_leading = 1;
  double greatest_z_trailing = -1;
  double least_z_trailing = 1;
  for (const Triangle& triangle : mesh_.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d& normal = triangle.normal[i];
      if (triangle.vertex[i] == leading) {
        least_cos_leading = std::min(least_cos_leading, normal.normalized().x());
      }
      if (triangle.vertex[i] != trailing) continue;
      greatest_z_trailing = std::max(greatest_z_trailing, normal.z());
      least_z_trailing = std::min(least_z_trailing, normal.z());
    }
  }
  EXPECT_GT(least_cos_leading, 0.7) << "the leading edge's normals point forward";
  EXPECT_GT(greatest_z_trailing, 0.9) << "one side of the trailing edge looks down";
  EXPECT_LT(least_z_trailing, -0.9) << "the other looks up";
}

TEST_F(Boeing707Test, IsSymmetric) {
  std::multiset<std::array<std::array<int64_t, 3>, 3>> as_is;
  std::multiset<std::array<std::array<int64_t, 3>, 3>> mirrored;
  for (const Triangle& triangle : mesh_.triangles) {
    as_is.insert(corners_on_side(mesh_, triangle, 1));
    mirrored.insert(corners_on_side(mesh_, triangle, -1));
  }
  EXPECT_TRUE(as_is == mirrored);
}

TEST_F(Boeing707Test, PartsLieOnTheSideTheyAreNamedFor) {
  std::map<std::string, double> mean_y_m;
  for (const Triangle& triangle : mesh_.triangles) {
    for (const int v : triangle.vertex) {
      mean_y_m[mesh_.parts[triangle.part].name] += mesh_.vertices[v].y();
    }
  }
  for (const char* port : {"wing_port_inner", "wing_port_outer", "tailplane_port", "nacelle_1",
                           "nacelle_2", "intake_1", "exhaust_2", "pylon_1"}) {
    EXPECT_LT(mean_y_m.at(port), 0) << port;
  }
  for (const char* starboard : {"wing_starboard_inner", "wing_starboard_outer",
                                "tailplane_starboard", "nacelle_3", "nacelle_4"}) {
    EXPECT_GT(mean_y_m.at(starboard), 0) << starboard;
  }
  EXPECT_GT(mean_y_m.at("nacelle_4"), mean_y_m.at("nacelle_3"));
  EXPECT_NEAR(mean_y_m.at("fin"), 0, 1e-6);
}

TEST_F(Boeing707Test, FirstFiveFeaturesAreThePapers) {
  std::vector<std::string> names;
  for (const TargetFeature& feature : features_) names.push_back(feature.name);
  names.resize(5);
  EXPECT_THAT(names,
              testing::ElementsAre("wing_tip_le_port", "wing_tip_te_port", "wing_tip_le_starboard",
                                   "wing_tip_te_starboard", "nose"));
  EXPECT_LT(position("wing_tip_le_port").y(), 0);
  EXPECT_GT(position("wing_tip_le_port").x(), position("wing_tip_te_port").x());
}

TEST_F(Boeing707Test, NoseIsTheForemostPoint) {
  EXPECT_EQ(bounds(mesh_).max_m.x(), position("nose").x());
}

TEST_F(Boeing707Test, NoseIsStillSeenWhenItPoints35DegreesAway) {
  const Eigen::Vector3d nose = position("nose");
  for (int roll_deg = 0; roll_deg < 360; roll_deg += 10) {
    const double roll_rad = roll_deg / kDegreesPerRadian;
    const Eigen::Vector3d side(0, std::cos(roll_rad), std::sin(roll_rad));
    const double away_rad = 35 / kDegreesPerRadian;
    const Eigen::Vector3d to_camera =
        std::cos(away_rad) * side - std::sin(away_rad) * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d beyond = nose + 1e-3 * to_camera;
    // The nose is convex: what leaves it outwards of one facet at the tip is outside.
    double greatest_height = -1;
    for (const Triangle& triangle : mesh_.triangles) {
      const bool is_at_tip = std::any_of(triangle.vertex.begin(), triangle.vertex.end(),
                                         [&](int v) { return mesh_.vertices[v] == nose; });
      if (!is_at_tip) continue;
      greatest_height = std::max(greatest_height, face_normal(mesh_, triangle).dot(beyond - nose));
    }
    EXPECT_GT(greatest_height, 0) << "seen from roll " << roll_deg;
  }
}

// The features that the mesh does not hide; from behind it hides the nose and the engines' fronts.
TEST_F(Boeing707Test, AtLeastFiveFeaturesAreSeenFromEverySide) {
  constexpr int kViews = 400;
  constexpr int kFewest = 5;
  const Occluder occluder(mesh_);
  size_t most_hidden = 0;
  for (int i = 0; i < kViews; ++i) {
    RandomStream stream(1, "views", static_cast<uint64_t>(i));
    const Eigen::Vector3d eye_m = 1400 * stream.rotation().col(0);
    const auto seen =
        std::count_if(features_.begin(), features_.end(), [&](const TargetFeature& feature) {
          return !occluder.hides(feature.position_m, eye_m, feature.clearance_m);
        });
    EXPECT_GE(seen, kFewest) << "from " << eye_m.transpose();
    most_hidden = std::max(most_hidden, features_.size() - static_cast<size_t>(seen));
  }
  EXPECT_GE(most_hidden, 5u) << "nothing is hidden from anywhere?";
}

TEST_F(Boeing707Test, IsSmallEnoughToRenderFast) {
  EXPECT_GT(mesh_.triangles.size(), 6000u);
  EXPECT_LT(mesh_.triangles.size(), 13000u);
}

}  // namespace
}  // namespace sightline
