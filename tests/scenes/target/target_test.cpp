// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/target.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/builders/cube.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/target/target_memory.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kHead =
    "name = 'box'\n[mesh]\nfile = 'cube.glb'\nforward = '+z'\nup = '+y'\n";
constexpr const char* kVertex =
    "[[feature]]\nname = 'v'\nkind = 'line_intersection'\nposition_m = [0.5, 0.5, 0.5]\n"
    "edges_m = [[[0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]], [[0.5, 0.5, 0.5], [0.5, -0.5, 0.5]]]\n";

class TargetFile : public testing::Test {
 protected:
  TargetFile() { write_glb(build_cube().mesh, folder_.path() / "cube.glb"); }

  std::shared_ptr<const Target> load(const std::string& text) const {
    return load_target(folder_.write("target.toml", text).string());
  }
  std::string target_error(const std::string& text) const {
    return error_of([&] { load(text); });
  }

  TemporaryFolder folder_;
};

TEST_F(TargetFile, LoadsMeshAndFeatures) {
  const auto target = load(std::string(kHead) + kVertex);
  EXPECT_EQ(target->name, "box");
  ASSERT_EQ(target->features.size(), 1u);
  EXPECT_EQ(target->features[0].kind, FeatureKind::kLineIntersection);
  EXPECT_EQ(target->features[0].edges[1].end_m, Eigen::Vector3d(0.5, -0.5, 0.5));
}

TEST_F(TargetFile, ErrorsSayWhatIsWrong) {
  const std::string head = kHead;
  EXPECT_THAT(target_error("name = 'x'\n[mesh]\n"), HasSubstr("mesh.file is missing"));
  EXPECT_THAT(target_error("name = 'x'\n[mesh]\nfile = 'no.glb'\n"), HasSubstr("no.glb"));
  EXPECT_THAT(
      target_error(head + "[[feature]]\nname = 'v'\nkind = 'lines'\nposition_m = [0, 0, 0]\n"),
      HasSubstr("kind"));
  EXPECT_THAT(target_error(head + kVertex + kVertex), HasSubstr("given twice"));
  EXPECT_THAT(target_error(head + "colour = 3\n"), HasSubstr("mesh.colour is not a known key"));
  std::string elsewhere = kVertex;
  elsewhere.replace(elsewhere.find("[0.5, 0.5, 0.5]"), 15, "[0.5, 0.5, 0.6]");
  EXPECT_THAT(target_error(head + elsewhere), HasSubstr("must begin at position_m"));
}

TEST_F(TargetFile, AFeatureOffTheMeshIsRefusedByName) {
  const std::string head = kHead;
  const auto corner = [](const std::string& x) {
    return "[[feature]]\nname = 'tip'\nkind = 'corner'\nposition_m = [" + x + ", 0.5, 0.5]\n";
  };
  // 1 % of the size is 0.0173 m.
  EXPECT_EQ(target_error(head + corner("0.517")), "");
  EXPECT_THAT(target_error(head + corner("0.518")),
              testing::AllOf(HasSubstr("feature[0].position_m"), HasSubstr("\"tip\""),
                             HasSubstr("0.018 m off the mesh")));
  EXPECT_EQ(target_error(head + corner("0.518") + "clearance_m = 0.02\n"), "");
  EXPECT_THAT(target_error(head + kVertex + corner("9")), HasSubstr("feature[1]"));
}

TEST_F(TargetFile, EdgesThatDoNotMeetAreRefusedByName) {
  std::string apart = kVertex;
  apart.replace(apart.rfind("[[0.5, 0.5, 0.5]"), 16, "[[0.5, 0.4, 0.5]");
  EXPECT_THAT(target_error(std::string(kHead) + apart), HasSubstr("\"v\": edge 1"));
}

TEST_F(TargetFile, PartsOfAFeatureMustBeGivenAndKnown) {
  const std::string part = build_cube().mesh.parts.front().name;
  const auto feature = [](const std::string& kind, const std::string& parts) {
    return std::string(kHead) + "[[feature]]\nname = 'tip'\nkind = '" + kind +
           "'\nposition_m = [0.5, 0.5, 0.5]\n" + parts;
  };
  EXPECT_THAT(
      target_error(feature("contour", "")),
      testing::AllOf(HasSubstr("feature[0].parts"), HasSubstr("\"tip\" must name the parts")));
  EXPECT_THAT(target_error(feature("contour", "parts = []\n")), HasSubstr("must name the parts"));
  EXPECT_EQ(target_error(feature("contour", "parts = ['" + part + "']\n")), "");
  EXPECT_EQ(target_error(feature("corner", "")), "");
  const std::string misspelt = target_error(feature("contour", "parts = ['" + part + "x']\n"));
  EXPECT_THAT(misspelt, testing::AllOf(HasSubstr("of \"tip\" holds \"" + part + "x\""),
                                       HasSubstr("did you mean '" + part + "'")));
  EXPECT_THAT(misspelt, testing::Not(HasSubstr("\n")));
}

TEST_F(TargetFile, AMeshFileIsATargetWithoutFeatures) {
  const auto target = load_target((folder_.path() / "cube.glb").string());
  EXPECT_EQ(target->name, "cube");
  EXPECT_TRUE(target->features.empty());
}

TEST(Targets, AnUnknownNameGetsASuggestion) {
  try {
    load_target("boing707");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'boeing707'"));
  }
}

TEST(Targets, AllThatShipLoad) {
  ASSERT_THAT(target_names(),
              testing::UnorderedElementsAre("boeing707", "boeing707_livery", "cube", "tango"));
  for (const std::string& name : target_names()) {
    const auto target = load_target(name);
    EXPECT_EQ(target->name, name);
    EXPECT_FALSE(target->description.empty());
    EXPECT_GE(target->features.size(), 5u);
  }
}

TEST(Targets, ACubeHidesItsFarVertex) {
  const auto cube = load_target("cube");
  // Seen along the diagonal from -x -y -z, only the opposite vertex (+,+,+) is hidden.
  const Eigen::Vector3d eye_in_target = Eigen::Vector3d(-10, -10.5, -11);
  Pose cam_from_target;
  cam_from_target.translation = -eye_in_target;
  int hidden = 0;
  for (const TargetFeature& feature : cube->features) {
    if (!is_self_hidden(*cube, feature, cam_from_target)) continue;
    ++hidden;
    EXPECT_EQ(feature.position_m, Eigen::Vector3d(0.5, 0.5, 0.5)) << feature.name;
  }
  EXPECT_EQ(hidden, 1);
}

TEST_F(TargetFile, OneSidedHolesAreSaidUnlessBacksAreSeen) {
  Mesh open = build_cube().mesh;
  for (Part& part : open.parts) part.material.emplace().is_two_sided = false;
  const std::string closed_file = (folder_.path() / "closed.glb").string();
  write_glb(open, closed_file);
  open.triangles.pop_back();
  const std::string open_file = (folder_.path() / "open.glb").string();
  write_glb(open, open_file);
  const auto said = [](const Mesh& mesh) { return fmt::format("{}", fmt::join(mesh.notes, "|")); };
  const auto closed = load_target(closed_file);
  EXPECT_THAT(said(closed->mesh), Not(HasSubstr("one-sided")));
  EXPECT_TRUE(one_sided_parts(closed->mesh).empty()) << "nobody sees a back of it";
  const auto with_hole = load_target(open_file);
  EXPECT_THAT(said(with_hole->mesh), AllOf(HasSubstr("3 open edges"), HasSubstr("backfaces")));
  EXPECT_FALSE(one_sided_parts(with_hole->mesh).empty());

  // The two sides of a sheet are closed together, and yet each is seen alone.
  Mesh sheet{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, .triangles = {}, .parts = open.parts};
  sheet.triangles = {{.vertex = {0, 1, 2}, .part = 0}, {.vertex = {0, 2, 1}, .part = 1}};
  compute_corner_normals(sheet, 0.1);
  const std::string sheet_file = (folder_.path() / "sheet.glb").string();
  write_glb(sheet, sheet_file);
  EXPECT_FALSE(one_sided_parts(load_target(sheet_file)->mesh).empty());

  MeshUse use;
  use.backfaces = "seen";
  const auto seen = load_target(open_file, use);
  EXPECT_THAT(said(seen->mesh), Not(HasSubstr("one-sided")));
  EXPECT_TRUE(one_sided_parts(seen->mesh).empty());
  use.backfaces = "sene";
  EXPECT_THAT(error_of([&] { load_target(open_file, use); }), HasSubstr("\"sene\""));
}

TEST_F(TargetFile, AFeatureIsHiddenWhereItsSurfaceIsNotDrawn) {
  constexpr const char* kSquare =
      "name = 'square'\n[mesh]\nfile = 'square.glb'\nforward = 'z'\nup = 'y'\n[[feature]]\n"
      "name = 'corner'\nkind = 'corner'\nposition_m = [1, 1, 0]\nclearance_m = ";
  Mesh square{
      .vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, .triangles = {}, .parts = {}};
  square.parts.emplace_back().material.emplace();
  square.triangles = {{.vertex = {0, 1, 2}}, {.vertex = {0, 2, 3}}};
  compute_corner_normals(square, 0.1);
  for (const bool has_back : {false, true}) {
    square.parts[0].material->is_two_sided = has_back;
    write_glb(square, folder_.path() / "square.glb");
    for (const char* clearance : {"1e-6", "0.01"}) {
      const auto target = load(std::string(kSquare) + clearance);
      Pose from_front;  // the normals are along z
      from_front.translation = {-0.3, -0.4, -10};
      Pose from_behind = from_front;
      from_behind.translation.z() = 10;
      EXPECT_FALSE(is_self_hidden(*target, target->features[0], from_front)) << clearance;
      EXPECT_EQ(is_self_hidden(*target, target->features[0], from_behind), !has_back) << clearance;
    }
  }
}

TEST_F(TargetFile, IsReadOnceWhileItIsRemembered) {
  const std::string mesh = (folder_.path() / "cube.glb").string();
  const std::string roundabout = (folder_.path() / "." / "cube.glb").string();
  const MeshUse in_feet{.forward = "", .up = "", .unit = "ft"};
  const auto before = load_target(mesh);
  std::shared_ptr<const Target> first;
  {
    const TargetMemory memory;
    {
      const TargetMemory inner;
      first = load_target(mesh);
    }
    EXPECT_EQ(load_target(roundabout), first);
    EXPECT_NE(load_target(mesh, in_feet), first);
    EXPECT_EQ(load_target(mesh, in_feet), load_target(mesh, in_feet));
    EXPECT_THAT(error_of([&] { load_target("none.glb"); }), HasSubstr("none.glb"));
  }
  EXPECT_NE(first, before);
  EXPECT_NE(load_target(mesh), first);
}

}  // namespace
}  // namespace sightline
