// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Light that is more than one distant point: closed forms of what it does to surfaces.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "renderer/environment.h"
#include "renderer/renderer.h"
#include "renderer/shading.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;
constexpr double kSinglePrecision = 2e-6;

std::shared_ptr<const cv::Mat> panorama_of(cv::Mat picture) {
  return std::make_shared<const cv::Mat>(std::move(picture));
}

std::shared_ptr<const cv::Mat> even_panorama(const cv::Scalar& blue_green_red) {
  return panorama_of(cv::Mat(32, 64, CV_32FC3, blue_green_red));
}

// White above the horizon, black below.
std::shared_ptr<const cv::Mat> upper_half() {
  cv::Mat picture(32, 64, CV_32FC3, cv::Scalar::all(0));
  picture.rowRange(0, 16) = cv::Scalar::all(1);
  return panorama_of(picture);
}

// A plate that fills the image, in colour, with no light but what a test gives it.
Scene dark_plate(const Pose& pose, const Material& material = {}) {
  Mesh mesh = plate(10);
  mesh.parts[0].material = material;
  Scene scene;
  scene.target = target_of(std::move(mesh));
  scene.camera = centred_camera(32, 32, 400);
  scene.cam_from_target = pose;
  scene.light.ambient = 0;
  scene.light.directional = 0;
  scene.background.level = 0;
  scene.colouring.mode = ColourMode::kRgb;
  return scene;
}

cv::Vec3f lit_middle(Renderer& renderer, const Scene& scene) {
  return renderer.render_linear(scene).at<cv::Vec3f>(16, 16);
}

cv::Vec3f lit_middle(const Scene& scene) {
  Renderer renderer;
  return lit_middle(renderer, scene);
}

Material glossy(double metallic, double roughness) {
  Material material;
  material.has_gloss = true;
  material.metallic = metallic;
  material.roughness = roughness;
  return material;
}

TEST(Surroundings, AnEvenPanoramaIsTheEvenGlow) {
  Renderer renderer;
  const auto panorama = even_panorama(cv::Scalar::all(1.2));
  for (const Material& material : {Material{}, glossy(0, 0.3), glossy(1, 0.7), glossy(0.5, 0)}) {
    Scene glow = dark_plate(at(0, 0, 20, {0.4, 0.5, 0}), material);
    Scene round = glow;
    glow.light.ambient = 0.6;
    round.environment.light = panorama;
    round.environment.strength = 0.5;
    const cv::Vec3f expected = lit_middle(renderer, glow);
    const cv::Vec3f found = lit_middle(renderer, round);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], kSinglePrecision);
    EXPECT_GT(expected[0], 0.3);
  }
}

TEST(Surroundings, NoSurfaceSendsBackMoreThanAFurnaceHas) {
  Renderer renderer;
  const auto furnace = even_panorama(cv::Scalar::all(0.5));
  for (const double metallic : {0.0, 1.0}) {
    for (const double roughness : {0.0, 0.2, 0.5, 1.0}) {
      for (const double tilt : {0.0, 0.8, 1.4}) {
        Scene scene = dark_plate(at(0, 0, 20, {0, tilt, 0}), glossy(metallic, roughness));
        scene.environment.light = furnace;
        const float seen = lit_middle(renderer, scene)[1];
        // Microfacets of one reflection lose what they would send to each other: up to two thirds
        // of a rough metal's. The table of integrals is good to 0.003.
        EXPECT_LE(seen, 0.5 + 0.003) << metallic << " " << roughness << " " << tilt;
        EXPECT_GT(seen, metallic > 0 ? 0.15 : 0.48);
      }
    }
  }
}

TEST(Surroundings, ChannelsKeepTheirOwn) {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.environment.light = even_panorama({0.1, 0.2, 0.3});
  const cv::Vec3f seen = lit_middle(scene);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], 0.1 * (c + 1), kSinglePrecision);
}

TEST(Surroundings, InGreyTheyCountByTheirLuminance) {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.colouring.mode = ColourMode::kGrey;
  scene.environment.light = even_panorama({0.1, 0.2, 0.3});
  const double expected = 0.0722 * 0.1 + 0.7152 * 0.2 + 0.2126 * 0.3;
  EXPECT_NEAR(Renderer().render_linear(scene).at<float>(16, 16), expected, kSinglePrecision);
}

TEST(Surroundings, InGreyTheyMayBeBrighterThanWhite) {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.colouring.mode = ColourMode::kGrey;
  scene.environment.light = even_panorama(cv::Scalar::all(3));
  scene.environment.strength = 0.25;
  EXPECT_NEAR(Renderer().render_linear(scene).at<float>(16, 16), 0.75, kSinglePrecision);
}

// Light of many colours from all that has one: two distant lights, highlights and a lamp.
Scene coloured_lights() {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.light.directional = 0.2;
  scene.light.specular = 0.1;
  scene.light.colour = {1, 0.5, 0.25};
  scene.light.second = 0.3;
  scene.light.second_colour = {0.2, 0.4, 0.8};
  return scene;
}

double luminance_of(const cv::Vec3f& blue_green_red) {
  return 0.0722 * blue_green_red[0] + 0.7152 * blue_green_red[1] + 0.2126 * blue_green_red[2];
}

TEST(LightColours, InGreyTheyCountByTheirLuminance) {
  Scene scene = coloured_lights();
  Renderer renderer;
  const double expected = luminance_of(lit_middle(renderer, scene));
  EXPECT_GT(expected, 0.2);
  scene.colouring.mode = ColourMode::kGrey;
  EXPECT_NEAR(renderer.render_linear(scene).at<float>(16, 16), expected, kSinglePrecision);
}

TEST(LightColours, InGreyLampsDoTheSame) {
  Scene scene = coloured_lights();
  Lamp lamp;
  lamp.strength = 0.3;
  lamp.distance_m = 20;
  lamp.colour = {0.1, 0.9, 0.3};
  scene.lamps = {lamp};
  Renderer renderer;
  const double expected = luminance_of(lit_middle(renderer, scene));
  scene.colouring.mode = ColourMode::kGrey;
  EXPECT_NEAR(renderer.render_linear(scene).at<float>(16, 16), expected, kSinglePrecision);
}

TEST(LightColours, InGreyAnEmissionCountsByItsLuminance) {
  Material material;
  material.emissive = {0.4, 0.2, 0.1};
  Scene scene = dark_plate(at(0, 0, 20), material);
  scene.colouring.mode = ColourMode::kGrey;
  Renderer renderer;
  const auto seen = [&] { return renderer.render_linear(scene).at<float>(16, 16); };
  EXPECT_NEAR(seen(), 0.2126 * 0.4 + 0.7152 * 0.2 + 0.0722 * 0.1, kSinglePrecision);
  // Of a texture that is not drawn the factor alone says nothing.
  material.emissive_texture.texture = 0;
  Mesh mesh = scene.target->mesh;
  mesh.parts[0].material = material;
  scene.target = target_of(std::move(mesh));
  scene.colouring.draws_textures = false;
  EXPECT_EQ(seen(), 0);
}

// Of half a white sphere a surface whose normal is t from its middle sees (1 + cos t) / 2.
TEST(Surroundings, OfHalfASphereADullSurfaceSeesWhatItIsTurnedTo) {
  const EnvironmentLight light(upper_half());
  constexpr double kTexels = 0.004;  // the sum over 64 x 32 of a cosine, and the look-up between
  for (const double t : {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.1}) {
    const Eigen::Vector3d normal(std::sin(t) * 0.6, -std::cos(t), std::sin(t) * 0.8);
    EXPECT_NEAR(light.dull(normal)[0], (1 + std::cos(t)) / 2, kTexels) << t;
  }
}

TEST(Surroundings, AGlossySurfaceSeesTheHorizonAsBlurredAsItIsRough) {
  EnvironmentLight light(upper_half());
  const Eigen::Vector3d above = Eigen::Vector3d(1, -0.5, 0).normalized();
  const Eigen::Vector3d level(0.6, 0, 0.8);
  double last = 1 + 1e-6;
  for (const double roughness : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    EXPECT_NEAR(light.glossy(level, roughness)[1], 0.5, 0.01) << roughness;  // by symmetry
    const double seen = light.glossy(above, roughness)[1];
    EXPECT_LT(seen, last + 1e-6) << roughness;
    last = seen;
  }
  EXPECT_NEAR(light.glossy(above, 0)[1], 1, kSinglePrecision);
  EXPECT_LT(last, 0.95);
}

// A panorama whose red grows around the camera, so that a direction can be told by it.
std::shared_ptr<const cv::Mat> ramp() {
  cv::Mat picture(256, 512, CV_32FC3);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      picture.at<cv::Vec3f>(v, u) = {0.5f, static_cast<float>(v + 0.5) / 256,
                                     static_cast<float>(u + 0.5) / 512};
    }
  }
  return panorama_of(picture);
}

TEST(Surroundings, AMirrorShowsWhatLiesWhereItTurnsTheEye) {
  // Turned by 0.3 about the camera's y, a mirror before the camera shows what lies at 0.6 from
  // the camera's back, on the side that it is turned to.
  Scene scene = dark_plate(at(0, 0, 20, {0, 0.3, 0}), glossy(1, 0));
  scene.camera = centred_camera(33, 33, 4000);
  scene.environment.light = ramp();
  const cv::Vec3f seen = lit_middle(scene);
  const double turn = 0.5 - (std::numbers::pi - 0.6) / (2 * std::numbers::pi);
  EXPECT_NEAR(seen[2], turn, 0.002);  // from the left, which is the panorama's left
  EXPECT_NEAR(seen[1], 0.5, 0.002);
}

TEST(Surroundings, TurnedTogetherTheyAndTheTargetLookTheSame) {
  Material half = glossy(0.4, 0.4);
  Scene scene = dark_plate(at(0, 0, 20, {0.5, 0, 0}), half);
  scene.environment.light = upper_half();
  Renderer renderer;
  const cv::Vec3f upright = lit_middle(renderer, scene);
  // A quarter turn about the camera's axis takes the whole scene with it.
  Scene rolled = scene;
  rolled.environment.roll_deg = 90;
  EXPECT_GT(std::abs(lit_middle(renderer, rolled)[1] - upright[1]), 0.05);
  rolled.cam_from_target.rotation =
      rotation_from_vector({0, 0, kQuarter}) * rolled.cam_from_target.rotation;
  EXPECT_NEAR(lit_middle(renderer, rolled)[1], upright[1], 0.003);
}

TEST(Surroundings, TheBackgroundIsThePanoramaAlongEachRay) {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.target = target_of(plate(0.1));
  scene.camera = centred_camera(65, 33, 40);
  scene.background.kind = BackgroundKind::kEnvironment;
  scene.environment.light = ramp();
  Renderer renderer;
  const auto red_at = [&](int u) { return renderer.render_linear(scene).at<cv::Vec3f>(4, u)[2]; };
  for (const int u : {0, 20, 64}) {
    const double ray = std::atan2(u - 32, 40);
    EXPECT_NEAR(red_at(u), 0.5 + ray / (2 * std::numbers::pi), 1e-4) << u;
  }
  scene.environment.yaw_deg = 36;  // what lay in the middle moves right
  EXPECT_NEAR(red_at(32), 0.4, 1e-4);
  scene.environment.yaw_deg = 0;
  scene.environment.pitch_deg = 18;  // ... up: the middle shows what lay below
  EXPECT_NEAR(renderer.render_linear(scene).at<cv::Vec3f>(12, 32)[1],
              0.6 - std::atan2(4, 40) / std::numbers::pi, 0.002);
}

// The part of a disc's area that a straight edge at `t` radii from its middle leaves.
double part_of_disc(double t) {
  t = std::clamp(t, -1.0, 1.0);
  return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / std::numbers::pi;
}

// A long plate whose edge lies 1 m before a wall, the light's middle along the camera's axis but
// for a little to the side, so that the camera sees the shadow beside the plate. Along a row, the
// part of the light that reaches the wall, and where it is seen from the edge of the shadow's
// middle, m.
struct Penumbra {
  std::vector<double> part, from_edge_m;
};

Penumbra penumbra_of(ColourMode mode, double radius_deg, int samples) {
  constexpr double kDepth = 20, kGap = 1, kEdge = 0.05;
  Scene scene = coverage_scene(plate(1), at(0, 0, kDepth), 10000);
  scene.camera = centred_camera(256, 16, 10000);
  scene.colouring.mode = mode;
  scene.samples_per_pixel = samples;
  // Its right edge is at kEdge - 0.1: hidden from the camera is what lies left of there.
  scene.others.push_back({target_of(plate(4)), at(kEdge - 0.1 - 2, 0, kDepth - kGap), true});
  scene.light = {.to_light_in_cam = Eigen::Vector3d(-0.1, 0, -kGap).normalized(),
                 .ambient = 0,
                 .directional = 0.8,
                 .casts_shadow = true,
                 .radius_deg = radius_deg};
  const cv::Mat image = Renderer().render_linear(scene);
  const double lit = -0.8 * scene.light.to_light_in_cam.z();
  Penumbra out;
  for (int u = 128; u < 256; ++u) {
    const double value =
        mode == ColourMode::kGrey ? image.at<float>(8, u) : image.at<cv::Vec3f>(8, u)[1];
    out.part.push_back(value / lit);
    out.from_edge_m.push_back((u - 127.5) / 10000 * kDepth - kEdge);
  }
  return out;
}

// Of a narrow disc by rays, of a wide one by shadow maps.
TEST(Disc, APenumbraIsAsWideAsTheDiscMakesIt) {
  // The light comes at a slant: the disc's shadow on the wall is longer by the slant's secant,
  // and the way from the edge to the wall too.
  const double slant = std::atan(0.1);
  for (const double radius_deg : {1.5, 5.0}) {
    // An edge divides 32 points of the disc; a pixel's samples, each of which sees some of them,
    // lie on either side. Shadow maps round to their texels beside that.
    const double points = (radius_deg < 2 ? 1.6 : 2.0) / Shadow::kDiscPoints;
    const double radius_m =
        std::tan(radius_deg * std::numbers::pi / 180) / std::pow(std::cos(slant), 2);
    for (const auto& [mode, samples] : {std::pair{ColourMode::kRgb, 4}, {ColourMode::kGrey, 64}}) {
      const Penumbra seen = penumbra_of(mode, radius_deg, samples);
      for (size_t i = 0; i < seen.part.size(); ++i) {
        ASSERT_NEAR(seen.part[i], part_of_disc(seen.from_edge_m[i] / radius_m), points)
            << radius_deg << " deg, " << i << ", " << samples << " samples";
      }
    }
  }
}

TEST(Disc, APointHasNone) {
  const Penumbra seen = penumbra_of(ColourMode::kGrey, 0, 16);
  int between = 0;
  for (const double part : seen.part) between += part > 0.01 && part < 0.99 ? 1 : 0;
  EXPECT_LE(between, 1);  // the pixel that the edge crosses
  EXPECT_EQ(seen.part.front(), 0);
  EXPECT_NEAR(seen.part.back(), 1, kSinglePrecision);
}

TEST(Lamp, ItsLightFallsWithTheSquareOfTheDistanceAndTheCosine) {
  for (const double depth : {5.0, 10.0, 20.0}) {
    Scene scene = dark_plate(at(0, 0, depth));
    scene.camera = centred_camera(33, 33, 400);
    scene.lamps = {{.position_in_cam_m = {3, 0, 0}, .strength = 0.4, .distance_m = 10}};
    const double squared = depth * depth + 9;
    const double expected = 0.4 * 100 / squared * depth / std::sqrt(squared);
    // Lit at the sample nearest to the pixel's middle, a tenth of a pixel from it.
    const double tenth = 0.1 / 400 * depth * 3 * 3 / squared;
    EXPECT_NEAR(lit_middle(scene)[0], std::min(1.0, expected), tenth) << depth;
    scene.colouring.mode = ColourMode::kGrey;
    EXPECT_NEAR(Renderer().render_linear(scene).at<float>(16, 16), std::min(1.0, expected), tenth);
    scene.lamps[0].position_in_cam_m.z() = 2 * depth;  // behind the plate
    EXPECT_EQ(Renderer().render_linear(scene).at<float>(16, 16), 0);
  }
}

TEST(Lamp, ItsConeEndsWhereItIsSaidAndItsColourIsItsOwn) {
  Scene scene = dark_plate(at(0, 0, 20));
  scene.camera = centred_camera(257, 33, 400);
  scene.lamps = {
      {.strength = 0.5, .distance_m = 20, .cone_deg = 10, .full_deg = 5, .colour = {1, 0.5, 0}}};
  const cv::Mat image = Renderer().render_linear(scene);
  const auto red_at = [&](double angle_deg) {
    const double u = 128 + 400 * std::tan(angle_deg * std::numbers::pi / 180);
    return image.at<cv::Vec3f>(16, static_cast<int>(std::lround(u)))[2];
  };
  EXPECT_NEAR(red_at(0), 0.5, 1e-5);
  EXPECT_NEAR(red_at(4.8), 0.5 * std::pow(std::cos(4.8 * std::numbers::pi / 180), 3), 1e-3);
  const double half_way = cone_share(scene.lamps[0], std::cos(7.5 * std::numbers::pi / 180));
  EXPECT_GT(half_way, 0.1);
  EXPECT_NEAR(red_at(7.5), 0.5 * half_way * std::pow(std::cos(7.5 * std::numbers::pi / 180), 3),
              0.01);
  EXPECT_EQ(red_at(10.5), 0);
  EXPECT_NEAR(image.at<cv::Vec3f>(16, 128)[1], 0.25, 1e-5);
  EXPECT_EQ(image.at<cv::Vec3f>(16, 128)[0], 0);
}

}  // namespace
}  // namespace sightline
