// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/image_bound.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "scenes/files/input_error.h"
#include "tests/registration/scenes_for_registration.h"

namespace sightline {
namespace {

constexpr double kContrast = 200;  // grey levels
constexpr double kNoise = 3;
constexpr double kPixelVariance = 1.0 / 12;  // of the box that a pixel is, px^2

// A flat white shape in the middle of the image, facing the camera, 0.1 m to 10 px.
Scene flat_scene(const Mesh& mesh) {
  Scene scene = coverage_scene(mesh, at(0, 0, 10), 1000);
  scene.camera = centred_camera(256, 256, 1000);
  scene.light.ambient = kContrast / 255;
  scene.background.level = 0.05;  // black tells nothing
  scene.light.ambient += scene.background.level;
  scene.sensor.bits = 16;
  scene.sensor.psf_sigma_px = 0.9;
  scene.sensor.read_noise_grey = kNoise;
  return scene;
}

// The information of an edge's place across it, a pixel of its length, in closed form: the blurred
// edge is C Phi(x / s), and the integral of its squared derivative C^2 / (2 sqrt(pi) s).
double edge_information(const Sensor& sensor) {
  const double blur = std::sqrt(sensor.psf_sigma_px * sensor.psf_sigma_px + kPixelVariance);
  return kContrast * kContrast / (2 * std::sqrt(std::numbers::pi) * blur) / (kNoise * kNoise);
}

// The information of a shift to the right in pixels, all else known.
double shift_information(const Scene& scene, const ImageBoundOptions& options = {}) {
  Renderer renderer;
  const auto covariance = image_bounds(scene, renderer, options).known_light;
  EXPECT_TRUE(covariance);
  const double px_per_m = scene.camera.fx_px / scene.cam_from_target.translation.z();
  return covariance->inverse()(3, 3) / (px_per_m * px_per_m);
}

Mesh disc(double radius_m, int corners) {
  Mesh mesh;
  mesh.parts = {{"disc", 1.0}};
  mesh.vertices.push_back({0, 0, 0});
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    mesh.vertices.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle), 0});
    mesh.triangles.push_back({.vertex = {0, 1 + (i + 1) % corners, 1 + i}, .part = 0});
  }
  compute_corner_normals(mesh, 0.1);
  return mesh;
}

TEST(ImageBound, AnEdgeIsKnownAsItsClosedFormSays) {
  Scene scene = flat_scene(plate(1));
  // Oblique to the pixels, so that their samples know the edges well. Edges of 100 px: two that a
  // shift crosses by its cosine, two by its sine.
  scene.cam_from_target = at(0, 0, 10, {0, 0, 0.3});
  const double expected = 2 * 100 * edge_information(scene.sensor);
  EXPECT_NEAR(shift_information(scene), expected, 0.02 * expected);
  scene.sensor.read_noise_grey = 2 * kNoise;
  EXPECT_NEAR(shift_information(scene), expected / 4, 0.02 * expected / 4);
}

TEST(ImageBound, ADiscIsKnownAsItsClosedFormSays) {
  constexpr double kRadiusPx = 60;
  const auto scene_of = [](int corners) {
    Scene scene = flat_scene(disc(kRadiusPx / 100, corners));
    scene.cam_from_target = at(0, 0, 10, {0.2, 0.3, 0});
    return scene;
  };
  // Its roll is known by its corners alone, which must be few enough to be seen. The integral of
  // the squared cosine along a circle is pi r; a turned one is an ellipse of axes r cos(turn).
  const double circle =
      std::numbers::pi * kRadiusPx * edge_information(flat_scene(plate(1)).sensor);
  EXPECT_NEAR(shift_information(scene_of(12)), circle, 0.06 * circle);
}

TEST(ImageBound, StepsAndSamplesHaveConverged) {
  const Scene scene = brick_scene();
  const double value = shift_information(scene);
  EXPECT_NEAR(shift_information(scene, {.step_px = 0.2}), value, 0.02 * value);
  EXPECT_NEAR(shift_information(scene, {.samples_per_pixel = 256}), value, 0.02 * value);
  EXPECT_GT(std::abs(shift_information(scene, {.step_px = 3}) - value), 0.1 * value);
}

TEST(ImageBound, WhatIsUnknownCosts) {
  Renderer renderer;
  const ImageBounds bounds = image_bounds(brick_scene(), renderer);
  ASSERT_TRUE(bounds.known_light && bounds.unknown_light && bounds.outline);
  const auto angle_sd = [](const Matrix6d& c) {
    return std::sqrt(c.topLeftCorner<3, 3>().trace());
  };
  EXPECT_LE(angle_sd(*bounds.known_light), angle_sd(*bounds.unknown_light));
  EXPECT_LT(angle_sd(*bounds.unknown_light), angle_sd(*bounds.outline));
}

TEST(ImageBound, PhotonsAndRoundingAreNoise) {
  const auto sd = [](const Scene& scene) {
    Renderer renderer;
    return std::sqrt((*image_bounds(scene, renderer).known_light)(3, 3));
  };
  Scene scene = brick_scene();
  const double plain = sd(scene);
  scene.sensor.full_well_electrons = 1000;
  EXPECT_GT(sd(scene), 1.2 * plain);
  scene.sensor = {};
  scene.sensor.bits = 4;  // steps of 17 grey levels: 4.9 of noise
  EXPECT_NEAR(sd(scene) / plain, std::sqrt((9 + 289.0 / 12) / (9 + 1.0 / 12)), 0.02);
}

TEST(ImageBound, AnImageWithoutContrastDeterminesNothing) {
  Scene scene = coverage_scene(brick(), brick_scene().cam_from_target, 1300);
  scene.camera = brick_scene().camera;
  scene.light.ambient = 0.15;
  scene.background.level = 0.15;
  Renderer renderer;
  const ImageBounds bounds = image_bounds(scene, renderer);
  EXPECT_FALSE(bounds.known_light);
  EXPECT_FALSE(bounds.unknown_light);
  EXPECT_FALSE(bounds.outline);
  scene.background.level = 0.5;
  EXPECT_TRUE(image_bounds(scene, renderer).known_light);
}

TEST(ImageBound, ASceneThatCannotBeImagedIsRefused) {
  Scene scene = brick_scene();
  scene.cam_from_target.translation.z() = -10;
  Renderer renderer;
  EXPECT_THROW(image_bounds(scene, renderer), InputError);
}

}  // namespace
}  // namespace sightline
