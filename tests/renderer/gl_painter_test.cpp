// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The same frames drawn by our own rasteriser and by OpenGL, in both ways to a context.
#include "renderer/gl_painter.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "renderer/renderer.h"
#include "scenes/builders/cube.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

Scene boeing(int samples_per_pixel) {
  Scene scene;
  scene.target = load_target("boeing707");
  scene.camera = centred_camera(256, 256, 5000);
  scene.cam_from_target = at(1, -2, 1150, {-0.35, 0.5, 0.7});
  scene.others.push_back({load_target("cube"), at(3, 2, 600, {0.3, 0.4, 0}), true});
  scene.light.to_light_in_cam = Eigen::Vector3d(-0.5, -0.7, -0.6).normalized();
  scene.light.casts_shadow = true;
  scene.samples_per_pixel = samples_per_pixel;
  return scene;
}

class GlPainterOf : public testing::TestWithParam<GlChoice> {};

TEST_P(GlPainterOf, SeesWhatOurOwnSees) {
  std::unique_ptr<Renderer> gl;
  try {
    gl = std::make_unique<Renderer>(RendererOptions{.gl = GetParam()});
  } catch (const GraphicsError& error) {
    GTEST_SKIP() << error.what();
  }
  Renderer own;
  for (const int samples : {1, 4, 16, 64}) {
    const Scene scene = boeing(samples);
    const cv::Mat ours = own.render_linear(scene);
    const cv::Mat theirs = gl->render_linear(scene);
    // OpenGL rounds vertices to 1/256 of the distance between samples: on an edge one sample in
    // some 100 differs, and where surfaces touch the nearer may be another.
    EXPECT_LT(cv::norm(ours, theirs, cv::NORM_L1) / (256 * 256), 5e-4 / samples + 1e-4) << samples;
    const cv::Mat differs = cv::abs(ours - theirs) > 1.01 / samples;
    EXPECT_LT(cv::countNonZero(differs), 256 * 256 / 2000) << samples;
    const Frame our_frame = own.render(scene, RandomStream(1, "sensor", 0));
    const Frame their_frame = gl->render(scene, RandomStream(1, "sensor", 0));
    EXPECT_EQ(cv::norm(our_frame.part_ids, their_frame.part_ids, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(our_frame.body_ids, their_frame.body_ids, cv::NORM_INF), 0);
  }
  // A difference would be seen: a tenth of a pixel.
  Scene moved = boeing(16);
  const cv::Mat theirs = gl->render_linear(moved);
  moved.cam_from_target.translation.x() += 0.1 * 1150 / 5000;
  EXPECT_GT(cv::norm(own.render_linear(moved), theirs, cv::NORM_L1) / (256 * 256), 5e-4);
}

TEST_P(GlPainterOf, SeesNoBacksOfWhatHasOneSide) {
  std::unique_ptr<Renderer> gl;
  try {
    gl = std::make_unique<Renderer>(RendererOptions{.gl = GetParam()});
  } catch (const GraphicsError& error) {
    GTEST_SKIP() << error.what();
  }
  Mesh mesh = plate(1);
  mesh.parts[0].material.emplace().is_two_sided = false;
  for (const double turn : {0.0, 3.0}) {
    Scene scene = coverage_scene(mesh, at(0, 0, 10, {0, turn, 0}), 2560);
    EXPECT_EQ(cv::countNonZero(gl->render_linear(scene)) > 0, turn == 0);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryContext, GlPainterOf,
                         testing::Values(GlChoice::kOsMesa, GlChoice::kEgl));

TEST(GlPainter, BothContextsSeeTheSame) {
  std::unique_ptr<Renderer> osmesa, egl;
  try {
    osmesa = std::make_unique<Renderer>(RendererOptions{.gl = GlChoice::kOsMesa});
    egl = std::make_unique<Renderer>(RendererOptions{.gl = GlChoice::kEgl});
  } catch (const GraphicsError& error) {
    GTEST_SKIP() << error.what();
  }
  // In turn, so that each finds the other's context gone.
  for (const int samples : {1, 16}) {
    const Scene scene = boeing(samples);
    EXPECT_EQ(cv::norm(osmesa->render_linear(scene), egl->render_linear(scene), cv::NORM_INF), 0);
  }
  EXPECT_NE(osmesa->description(), egl->description());
}

TEST(GlPainter, LargeImagesAreCutIntoTiles) {
  std::unique_ptr<Renderer> gl;
  try {
    gl = std::make_unique<Renderer>(RendererOptions{.gl = GlChoice::kAuto});
  } catch (const GraphicsError& error) {
    GTEST_SKIP() << error.what();
  }
  Scene scene = coverage_scene(build_cube().mesh, at(0.1, -0.05, 6, {0.3, 0.4, 0.5}), 3000);
  scene.camera = centred_camera(900, 800, 3000);
  scene.samples_per_pixel = 16;
  const cv::Mat ours = Renderer().render_linear(scene);
  EXPECT_LT(cv::norm(ours, gl->render_linear(scene), cv::NORM_INF), 0.07);  // one sample
}

TEST(GlChoice, HasANameEach) {
  EXPECT_EQ(gl_choice("egl"), GlChoice::kEgl);
  EXPECT_EQ(gl_choice("none"), GlChoice::kNone);
  EXPECT_FALSE(gl_choice("vulkan"));
}

}  // namespace
}  // namespace sightline
