// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Surfaces that show what is behind them: closed forms of what a pixel holds.
#include <array>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "renderer/renderer.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

constexpr double kPaintRounding = 2e-6;  // of single precision, over a few layers

struct Pane {
  double z_m;
  std::array<double, 4> base;
  AlphaMode mode;
};

// Squares of 1 m one behind the other, seen from -z, each on 256 px in the middle of the image.
Mesh panes(const std::vector<Pane>& wanted) {
  Mesh mesh;
  for (const Pane& pane : wanted) {
    const auto first = static_cast<int>(mesh.vertices.size());
    const auto part = static_cast<int>(mesh.parts.size());
    Mesh one = plate(1);
    for (Eigen::Vector3d& x : one.vertices) mesh.vertices.emplace_back(x.x(), x.y(), pane.z_m);
    for (Triangle& triangle : one.triangles) {
      for (int& vertex : triangle.vertex) vertex += first;
      triangle.part = part;
      mesh.triangles.push_back(triangle);
    }
    Material material;
    material.base = pane.base;
    material.alpha_mode = pane.mode;
    mesh.parts.push_back({"pane", 1, material});
  }
  return mesh;
}

Scene scene_of(Mesh mesh, ColourMode mode = ColourMode::kRgb) {
  Scene scene = coverage_scene(std::move(mesh), at(0, 0, 10), 2560);
  scene.colouring.mode = mode;
  scene.background.level = 0.4;
  return scene;
}

cv::Vec3f middle_of(const Scene& scene) {
  return Renderer().render_linear(scene).at<cv::Vec3f>(250, 260);
}

void expect_rgb(const cv::Vec3f& pixel, const Eigen::Array3d& rgb) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[2 - c], rgb[c], kPaintRounding) << "channel " << c;
}

constexpr Pane kRed{-0.02, {1, 0, 0, 0.25}, AlphaMode::kBlend};
constexpr Pane kGreen{-0.01, {0, 1, 0, 0.5}, AlphaMode::kBlend};
constexpr Pane kBlue{0, {0, 0, 1, 0.1}, AlphaMode::kOpaque};

TEST(SeeThrough, LayersAreBlendedByDepthWhateverTheirOrderInTheFile) {
  const Eigen::Array3d expected(0.25, 0.75 * 0.5, 0.75 * 0.5);
  expect_rgb(middle_of(scene_of(panes({kRed, kGreen, kBlue}))), expected);
  expect_rgb(middle_of(scene_of(panes({kBlue, kRed, kGreen}))), expected);
  // Another order in depth is another colour.
  Pane farther = kRed;
  farther.z_m = -0.005;
  expect_rgb(middle_of(scene_of(panes({farther, kGreen, kBlue}))), {0.125, 0.5, 0.375});
}

TEST(SeeThrough, WhatIsBehindAllIsTheBackground) {
  expect_rgb(middle_of(scene_of(panes({kRed, kGreen}))),
             {0.25 + 0.375 * 0.4, 0.375 + 0.375 * 0.4, 0.375 * 0.4});
}

TEST(SeeThrough, WhatIsOpaqueShowsNothing) {
  Pane opaque = kRed;
  opaque.mode = AlphaMode::kOpaque;
  expect_rgb(middle_of(scene_of(panes({opaque, kGreen, kBlue}))), {1, 0, 0});
}

TEST(SeeThrough, InGreyAllIsOpaque) {
  const Scene scene = scene_of(panes({kRed, kGreen, kBlue}), ColourMode::kGrey);
  EXPECT_EQ(Renderer().render_linear(scene).at<float>(250, 260), 1);
}

TEST(SeeThrough, TheTruthSeesTheNearest) {
  const Frame frame = Renderer().render(scene_of(panes({kBlue, kRed})), RandomStream(1, "n", 0));
  EXPECT_EQ(frame.part_ids.at<uint16_t>(250, 260), 2);
  EXPECT_NEAR(frame.depth_m.at<double>(250, 260), 9.98, 1e-9);
}

// A pane whose left half is there and whose right half is not, before a blue one.
Mesh masked(double cutoff) {
  Mesh mesh = panes({{-0.01, {1, 1, 1, 1}, AlphaMode::kMask}, kBlue});
  mesh.textures = {
      std::make_shared<const Texture>(Texture{"t", 2, 1, true, {255, 0, 0, 204, 255, 0, 0, 51}})};
  Material& material = *mesh.parts[0].material;
  material.alpha_cutoff = cutoff;
  material.base_texture = {.texture = 0, .is_nearest = true};
  for (const Triangle& triangle : mesh.triangles) {
    Coat coat;
    for (size_t c = 0; c < 3; ++c) {
      const Eigen::Vector3d& x = mesh.vertices[static_cast<size_t>(triangle.vertex[c])];
      coat.uv[c] = x.head<2>().cast<float>() + Eigen::Vector2f::Constant(0.5f);
    }
    mesh.coats.push_back(coat);
  }
  return mesh;
}

TEST(SeeThrough, AMaskIsThereWhereItReachesItsCutoff) {
  const auto halves = [](double cutoff) {
    const cv::Mat image = Renderer().render_linear(scene_of(masked(cutoff)));
    return std::pair{image.at<cv::Vec3f>(250, 200), image.at<cv::Vec3f>(250, 300)};
  };
  const auto [left, right] = halves(0.5);
  expect_rgb(left, {1, 0, 0});
  expect_rgb(right, {0, 0, 1});
  expect_rgb(halves(0.1).second, {1, 0, 0});
  expect_rgb(halves(0.9).first, {0, 0, 1});
}

int part_in_the_middle(Scene scene, TruthSurface sees) {
  scene.colouring.truth_sees = sees;
  Renderer renderer;
  return renderer.render(scene, RandomStream(1, "sensor", 0)).part_ids.at<uint16_t>(250, 260);
}

TEST(SeeThrough, TheTruthSeesTheNearestOrWhatLetsNoLightThrough) {
  const Scene scene = scene_of(panes({kRed, kGreen, kBlue}));
  EXPECT_EQ(part_in_the_middle(scene, TruthSurface::kNearest), 1);
  EXPECT_EQ(part_in_the_middle(scene, TruthSurface::kOpaque), 3);
  // With nothing opaque behind it is the nearest pane after all, unless that is not seen.
  const Scene glass = scene_of(panes({kRed, kGreen}));
  EXPECT_EQ(part_in_the_middle(glass, TruthSurface::kOpaque), 1);
  const Pane nothing{-0.03, {1, 1, 1, 0}, AlphaMode::kBlend};
  EXPECT_EQ(part_in_the_middle(scene_of(panes({nothing, kRed})), TruthSurface::kNearest), 1);
  EXPECT_EQ(part_in_the_middle(scene_of(panes({nothing, kRed})), TruthSurface::kOpaque), 2);
  // A mask is there or not.
  const Pane hole{-0.03, {1, 1, 1, 0.4}, AlphaMode::kMask};
  const Pane sheet{-0.03, {1, 1, 1, 0.6}, AlphaMode::kMask};
  EXPECT_EQ(part_in_the_middle(scene_of(panes({hole, kBlue})), TruthSurface::kOpaque), 2);
  EXPECT_EQ(part_in_the_middle(scene_of(panes({sheet, kBlue})), TruthSurface::kOpaque), 1);
}

TEST(SeeThrough, DepthIsOfTheSurfaceThatTheIdsSay) {
  Scene scene = scene_of(panes({kRed, kBlue}));
  scene.colouring.truth_sees = TruthSurface::kOpaque;
  const Frame frame = Renderer().render(scene, RandomStream(1, "sensor", 0));
  EXPECT_NEAR(frame.depth_m.at<double>(250, 260), 10, 1e-9);  // kBlue's
  EXPECT_EQ(frame.truth.target().visible_pixels, cv::countNonZero(frame.part_ids == 2));
}

// The same with a part of one side.
Mesh with_one_side(Mesh mesh, int part = 0) {
  mesh.parts[static_cast<size_t>(part)].material->is_two_sided = false;
  return mesh;
}

constexpr Pane kWhite{-0.01, {1, 1, 1, 1}, AlphaMode::kOpaque};

Scene from_behind(Scene scene) {
  scene.cam_from_target = at(0, 0, 10, {0, std::numbers::pi, 0});
  return scene;
}

Frame seen_frame(const Scene& scene) {
  return Renderer().render(scene, RandomStream(1, "sensor", 0));
}

TEST(OneSided, ABackIsNotThereInPicturesAndTruth) {
  for (const ColourMode mode : {ColourMode::kGrey, ColourMode::kRgb}) {
    const Scene front = scene_of(with_one_side(panes({kWhite})), mode);
    EXPECT_EQ(seen_frame(front).part_ids.at<uint16_t>(250, 260), 1);
    const Scene back = from_behind(front);
    const cv::Mat light = Renderer().render_linear(back).reshape(1);
    EXPECT_EQ(cv::norm(light - 0.4f, cv::NORM_INF), 0);
    const Frame frame = seen_frame(back);
    EXPECT_EQ(cv::countNonZero(frame.part_ids), 0);
    EXPECT_EQ(cv::countNonZero(frame.depth_m), 0);
    EXPECT_EQ(frame.truth.target().visible_pixels, 0);
    EXPECT_EQ(frame.truth.target().amodal_pixels, 0);
    EXPECT_EQ(
        seen_frame(from_behind(scene_of(panes({kWhite}), mode))).part_ids.at<uint16_t>(250, 260),
        1);
  }
}

TEST(OneSided, ABackShowsWhatIsBehindItAndItsFeatures) {
  // From behind the blue pane is the farther one.
  Pane farther = kBlue;
  farther.z_m = -0.02;
  TargetFeature feature;
  feature.name = "on the blue pane";
  feature.position_m = {0.1, 0.1, farther.z_m};
  feature.clearance_m = 1e-4;
  for (const bool has_back : {false, true}) {
    Mesh mesh = panes({kWhite, farther});
    if (!has_back) mesh = with_one_side(std::move(mesh));
    Scene scene = from_behind(scene_of(mesh));
    scene.target = target_of(mesh, {feature});
    expect_rgb(middle_of(scene), has_back ? Eigen::Array3d(1, 1, 1) : Eigen::Array3d(0, 0, 1));
    const Frame frame = seen_frame(scene);
    EXPECT_EQ(frame.part_ids.at<uint16_t>(250, 260), has_back ? 1 : 2);
    EXPECT_NEAR(frame.depth_m.at<double>(250, 260), has_back ? 10.01 : 10.02, 1e-9);
    EXPECT_EQ(frame.truth.target().features[0].is_visible, !has_back);
  }
}

TEST(OneSided, AFrontHidesAsItDid) {
  expect_rgb(middle_of(scene_of(with_one_side(panes({kWhite, kBlue})))), {1, 1, 1});
  const Occluder occluder(with_one_side(panes({kWhite})));
  const Eigen::Vector3d eye(0, 0, -10);
  EXPECT_TRUE(occluder.hides({0.1, 0.1, 0}, eye, 1e-4));
  EXPECT_FALSE(occluder.hides({0.1, 0.1, -0.02}, -eye, 1e-4));
}

// Through a lens that bends it, and reaching behind the camera, a triangle is cut: the rule is that
// of the whole.
TEST(OneSided, CutTrianglesFollowTheRuleOfTheWhole) {
  for (const double turn : {0.0, std::numbers::pi}) {
    Scene scene = scene_of(with_one_side(panes({kWhite})));
    scene.camera = centred_camera(128, 128, 60);
    scene.camera.lens = KannalaBrandt{};
    scene.cam_from_target = at(0, 0, 0.5, {0, turn, 0});
    EXPECT_EQ(seen_frame(scene).part_ids.at<uint16_t>(64, 64), turn == 0 ? 1 : 0);
    // Its near side lies behind the camera.
    scene.cam_from_target = at(0, 0, 0.3, {0, turn + 1.2, 0});
    EXPECT_EQ(cv::countNonZero(seen_frame(scene).part_ids) > 0, turn == 0);
  }
}

TEST(OneSided, ABackBlocksLightAllTheSame) {
  // The light comes from the camera; of the pane before the blue one it sees the back.
  const auto lit = [](bool casts_shadow) {
    Mesh mesh = panes({{0, {1, 1, 1, 1}, AlphaMode::kOpaque}});
    for (Triangle& triangle : mesh.triangles) {
      std::swap(triangle.vertex[0], triangle.vertex[1]);
      std::swap(triangle.normal[0], triangle.normal[1]);
      for (Eigen::Vector3d& normal : triangle.normal) normal = -normal;
    }
    Scene scene = scene_of(panes({kBlue}), ColourMode::kGrey);
    scene.others.push_back({target_of(with_one_side(std::move(mesh))), at(0, 0, 9.5), true});
    scene.light.ambient = 0.2;
    scene.light.directional = 0.5;
    scene.light.casts_shadow = casts_shadow;
    return Renderer().render_linear(scene).at<float>(250, 260);
  };
  EXPECT_NEAR(lit(false), 0.7, kPaintRounding);
  EXPECT_NEAR(lit(true), 0.2, kPaintRounding);
}

}  // namespace
}  // namespace sightline
