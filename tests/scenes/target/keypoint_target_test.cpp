// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Targets of keypoints alone, whose mesh nobody has.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/pose.h"
#include "scenes/builders/cube.h"
#include "scenes/files/input_error.h"
#include "scenes/scene/scene.h"
#include "scenes/target/target.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kPoints =
    "name = 'points'\n"
    "[[feature]]\nname = 'a'\nposition_m = [0.5, 0.5, 0.5]\n"
    "[[feature]]\nname = 'b'\nposition_m = [-0.5, 0.25, -0.5]\n";
constexpr const char* kMesh = "[mesh]\nfile = 'cube.glb'\nforward = '+z'\nup = '+y'\n";
constexpr const char* kLines =
    "[[feature]]\nname = 'v'\nkind = 'line_intersection'\nposition_m = [0, 0, 0]\n"
    "edges_m = [[[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0]]]\n";

class KeypointTarget : public testing::Test {
 protected:
  std::shared_ptr<const Target> load(const std::string& text) const {
    return load_target(folder_.write("target.toml", text).string());
  }
  std::string target_error(const std::string& text) const {
    return error_of([&] { load(text); });
  }

  TemporaryFolder folder_;
};

TEST_F(KeypointTarget, HasNamesAndPositionsAndNoMesh) {
  const auto target = load(std::string(kPoints) + kLines);
  EXPECT_FALSE(target->has_mesh());
  ASSERT_EQ(target->features.size(), 3u);
  EXPECT_EQ(target->features[0].name, "a");
  EXPECT_EQ(target->features[0].kind, FeatureKind::kCorner);
  EXPECT_EQ(target->features[1].position_m, Eigen::Vector3d(-0.5, 0.25, -0.5));
  EXPECT_EQ(target->features[2].kind, FeatureKind::kLineIntersection);
  EXPECT_EQ(target->features[2].edges[1].end_m, Eigen::Vector3d(0, 1, 0));
  // For the errors of a pose and for the room it takes, it is its keypoints.
  ASSERT_EQ(target->mesh.vertices.size(), 3u);
  EXPECT_EQ(target->mesh.vertices[1], target->features[1].position_m);
  EXPECT_EQ(bounds(target->mesh).min_m, Eigen::Vector3d(-0.5, 0, -0.5));
  const auto twice = scaled(target, 2);
  EXPECT_FALSE(twice->has_mesh());
  EXPECT_EQ(twice->features[1].position_m, Eigen::Vector3d(-1, 0.5, -1));
  EXPECT_EQ(twice->mesh.vertices[1], Eigen::Vector3d(-1, 0.5, -1));
  EXPECT_THAT(twice->shapes, IsEmpty());
}

TEST_F(KeypointTarget, SaysThatItCannotBeRendered) {
  EXPECT_THAT(why_not_renderable(*load(kPoints)), AllOf(HasSubstr("'points'"), HasSubstr("mesh")));
  EXPECT_EQ(why_not_renderable(*load_target("cube")), "");
}

// A mesh with the same points hides some of them from any side.
TEST_F(KeypointTarget, HidesNothing) {
  const auto cube = load_target("cube");
  std::string text = "name = 'corners'\n";
  for (const TargetFeature& feature : cube->features) {
    const Eigen::Vector3d& at = feature.position_m;
    text += "[[feature]]\nname = '" + feature.name + "'\nposition_m = [" + std::to_string(at.x()) +
            ", " + std::to_string(at.y()) + ", " + std::to_string(at.z()) + "]\n";
  }
  const auto corners = load(text);
  ASSERT_EQ(corners->features.size(), 8u);
  const Pose pose{rotation_from_vector({0.3, -0.5, 0.2}), {0, 0, 10}};
  int hidden_by_cube = 0;
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_FALSE(is_self_hidden(*corners, corners->features[i], pose)) << i;
    hidden_by_cube += is_self_hidden(*cube, cube->features[i], pose) ? 1 : 0;
  }
  EXPECT_EQ(hidden_by_cube, 1);
}

TEST_F(KeypointTarget, IsImagedWhereItsKeypointsAre) {
  Scene scene;
  scene.target = load(kPoints);
  scene.camera = centred_camera(64, 64, 100);
  scene.cam_from_target.translation = {0, 0, 10};
  EXPECT_EQ(why_not_imageable(scene), "");
  scene.cam_from_target.translation = {9, 0, 10};
  EXPECT_THAT(why_not_imageable(scene), HasSubstr("outside the image"));
  scene.cam_from_target.translation = {0, 0, 0.4};
  EXPECT_THAT(why_not_imageable(scene), HasSubstr("behind the camera"));
}

TEST_F(KeypointTarget, ErrorsSayWhatIsWrong) {
  write_glb(build_cube().mesh, folder_.path() / "cube.glb");
  EXPECT_THAT(target_error("name = 'x'\n"),
              AllOf(HasSubstr("mesh is missing"), HasSubstr("[[feature]]")));
  EXPECT_EQ(target_error(kPoints), "");
  const std::string points = kPoints;
  EXPECT_THAT(target_error(points + "kind = 'contour'\n"),
              AllOf(HasSubstr("kind"), HasSubstr("\"b\""), HasSubstr("no [mesh]")));
  EXPECT_THAT(target_error(points + "parts = ['wing']\n"),
              AllOf(HasSubstr("parts"), HasSubstr("\"b\""), HasSubstr("no [mesh]")));
  EXPECT_THAT(target_error(points + "kind = 'line'\n"), HasSubstr("kind"));
  EXPECT_THAT(target_error(points + "kind = 'line_intersection'\n"), HasSubstr("edges_m"));
  EXPECT_THAT(target_error(points + points.substr(points.find("[["))), HasSubstr("given twice"));
  EXPECT_THAT(target_error(points + "[mash]\nfile = 'cube.glb'\n"),
              HasSubstr("mash is not a known key"));
  // With a mesh a feature still has to say what it is.
  const std::string with_mesh = "name = 'x'\n" + std::string(kMesh) +
                                "[[feature]]\nname = 'a'\nposition_m = [0.5, 0.5, 0.5]\n";
  EXPECT_THAT(target_error(with_mesh), HasSubstr("kind is missing"));
  EXPECT_EQ(target_error(with_mesh + "kind = 'corner'\n"), "");
}

}  // namespace
}  // namespace sightline
