// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures in colour: closed forms of what stands in which pixel.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/renderer.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

// Textures are kept in linear light of 16 bits, and looked up in single precision.
constexpr double kRounding = 0.5 / 65535 + 2e-6;

RandomStream no_noise() {
  return RandomStream(1, "sensor", 0);
}

double linear(int code) {
  const double encoded = code / 255.0;
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

// Every texel another colour, so that one that is mistaken for another shows.
std::shared_ptr<const Texture> many_colours(int width, int height) {
  Texture texture{.name = "t", .width = width, .height = height, .rgba = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int c :
           {20 + 200 * x / width, 30 + 200 * y / height, 40 + 13 * (x + y) % 200, 255}) {
        texture.rgba.push_back(static_cast<uint8_t>(c));
      }
    }
  }
  return std::make_shared<const Texture>(std::move(texture));
}

// A square in z = 0 that is seen from -z with its picture upright: u along x, v along y (down).
Mesh painted_plate(double side_m, std::shared_ptr<const Texture> texture) {
  Mesh mesh = plate(side_m);
  mesh.textures = {std::move(texture)};
  Material material;
  material.base_texture.texture = 0;
  mesh.parts[0].material = material;
  for (const Triangle& triangle : mesh.triangles) {
    Coat coat;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d& x = mesh.vertices[triangle.vertex[c]];
      coat.uv[c] = (x.head<2>() / side_m).array().cast<float>() + 0.5f;
    }
    mesh.coats.push_back(coat);
  }
  return mesh;
}

// Bright enough to keep the numbers apart, and all of it even.
Scene colour_scene(Mesh mesh, const Pose& pose, double focal_px) {
  Scene scene = coverage_scene(std::move(mesh), pose, focal_px);
  scene.colouring.mode = ColourMode::kRgb;
  scene.sensor.psf_sigma_px = 0;
  scene.sensor.read_noise_grey = 0;
  return scene;
}

// 1 m a side at 10 m, on 256 px: its edges lie between pixels 127 and 128, 383 and 384.
Scene upright(int texels) {
  return colour_scene(painted_plate(1, many_colours(texels, texels)), at(0, 0, 10), 2560);
}

// A plate whose occlusion texture has one red everywhere, its strength that of the material.
Scene occluded(int red, double strength) {
  Texture texture{.name = "t", .width = 1, .height = 1, .rgba = {}};
  for (const int c : {red, 255, 255, 255}) texture.rgba.push_back(static_cast<uint8_t>(c));
  texture.is_srgb = false;
  Mesh mesh = painted_plate(1, std::make_shared<const Texture>(std::move(texture)));
  Material& material = *mesh.parts[0].material;
  material.base_texture = {};
  material.occlusion_texture.texture = 0;
  material.occlusion_strength = strength;
  return colour_scene(std::move(mesh), at(0, 0, 10), 2560);
}

float middle_red(const Scene& scene) {
  return Renderer().render_linear(scene).at<cv::Vec3f>(250, 260)[2];
}

TEST(Occlusion, TakesItsShareOfTheLightFromAllAround) {
  for (const int red : {0, 51, 255}) {
    for (const double strength : {0.0, 0.5, 1.0}) {
      Scene scene = occluded(red, strength);
      scene.light.ambient = 0.5;
      const double share = 1 + strength * (red / 255.0 - 1);
      EXPECT_NEAR(middle_red(scene), 0.5 * share, kRounding) << red << " " << strength;
      // Lights that come from somewhere are not dimmed.
      scene.light.directional = 0.3;
      scene.light.second = 0.1;
      EXPECT_NEAR(middle_red(scene), 0.5 * share + 0.4, kRounding) << red << " " << strength;
    }
  }
}

TEST(Occlusion, TakesItOfAPanoramaAndOfGloss) {
  for (const bool has_gloss : {false, true}) {
    const auto seen = [&](int red) {
      Scene scene = occluded(red, 1);
      Mesh mesh = scene.target->mesh;
      mesh.parts[0].material->has_gloss = has_gloss;
      mesh.parts[0].material->roughness = 0.5;
      scene.target = target_of(std::move(mesh));
      scene.light.ambient = 0;
      scene.environment.light =
          std::make_shared<const cv::Mat>(32, 64, CV_32FC3, cv::Scalar::all(0.5));
      return middle_red(scene);
    };
    EXPECT_GT(seen(255), 0.4);
    EXPECT_NEAR(seen(102), 0.4 * seen(255), kRounding);
  }
}

TEST(Colour, TexelsAreTheSquaresThatTheyMustBe) {
  Scene scene = upright(8);  // 32 px a texel
  Mesh mesh = scene.target->mesh;
  mesh.parts[0].material->base_texture.is_nearest = true;
  scene.target = target_of(mesh);
  const cv::Mat image = Renderer().render_linear(scene);
  ASSERT_EQ(image.type(), CV_32FC3);
  const Texture& texture = *mesh.textures[0];
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const bool is_on = u >= 128 && u < 384 && v >= 128 && v < 384;
      const size_t texel = is_on ? 4 * static_cast<size_t>((v - 128) / 32 * 8 + (u - 128) / 32) : 0;
      for (int c = 0; c < 3; ++c) {  // OpenCV has blue first
        const double expected = is_on ? linear(texture.rgba[texel + static_cast<size_t>(c)]) : 0;
        ASSERT_NEAR(image.at<cv::Vec3f>(v, u)[2 - c], expected, kRounding) << u << " " << v;
      }
    }
  }
}

TEST(Colour, BetweenMiddlesOfTexelsItBlends) {
  const cv::Mat image = Renderer().render_linear(upright(8));
  // Texels' middles lie at 143.5 + 32 i; samples about a pixel centre are symmetric, so a linear
  // blend over the pixel is the one at its centre.
  const auto red = [](int i) { return linear(20 + 200 * i / 8); };
  for (int u = 144; u < 175; ++u) {
    const double share = (u - 143.5) / 32;
    const double expected = red(0) + share * (red(1) - red(0));
    EXPECT_NEAR(image.at<cv::Vec3f>(200, u)[2], expected, 1e-3 * (red(1) - red(0))) << u;
  }
}

// The column where the red of row v passes half way from one side to the other.
double crossing(const cv::Mat& image, int v, double low, double high) {
  double light = 0;
  for (int u = 0; u < image.cols; ++u) light += (image.at<cv::Vec3f>(v, u)[2] - low) / (high - low);
  return image.cols - 0.5 - light;
}

TEST(Colour, AnEdgeOfPrintLiesWhereItsPointsAreProjected) {
  // Left half of the plate dark, right half bright; the plate is slanted and fills the image.
  Texture halves{.name = "h", .width = 2, .height = 1, .rgba = {0, 0, 0, 255, 255, 255, 255, 255}};
  Mesh mesh = painted_plate(4, std::make_shared<const Texture>(halves));
  mesh.parts[0].material->base_texture.is_nearest = true;
  mesh.parts[0].material->base_texture.wrap_u = Wrap::kClamp;
  const Pose pose = at(0.013, 0.02, 10, {0.3, 0.5, 0.2});
  Scene scene = colour_scene(mesh, pose, 5000);
  scene.camera = centred_camera(96, 96, 5000);
  scene.samples_per_pixel = 256;
  const cv::Mat image = Renderer().render_linear(scene);
  for (const int v : {8, 47, 90}) {
    // The print's edge is x = 0 of the plate: where its line meets the row.
    const Eigen::Vector2d a = *project(scene.camera, pose * Eigen::Vector3d(0, -1, 0));
    const Eigen::Vector2d b = *project(scene.camera, pose * Eigen::Vector3d(0, 1, 0));
    const double u = a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    EXPECT_NEAR(crossing(image, v, 0, 1), u, 0.01) << v;
  }
}

TEST(Colour, ChequersFarAwayAreTheirMeanInLinearLight) {
  // 512 texels a side, dark and bright in turns; the mean of their light, not of their codes.
  constexpr int kTexels = 512;
  Texture chequers{.name = "c", .width = kTexels, .height = kTexels, .rgba = {}};
  for (int i = 0; i < kTexels * kTexels; ++i) {
    const bool is_bright = (i / kTexels + i % kTexels) % 2 == 0;
    for (const int c : {is_bright ? 240 : 40, is_bright ? 200 : 0, 10, 255}) {
      chequers.rgba.push_back(static_cast<uint8_t>(c));
    }
  }
  const auto texture = std::make_shared<const Texture>(std::move(chequers));
  const double half_code = 0.5 / 255 * 2.4;               // a level's rounding, in light at most
  for (const double distance_m : {40.0, 160.0, 640.0}) {  // 8, 32 and 128 texels a pixel
    const cv::Mat image = Renderer().render_linear(
        colour_scene(painted_plate(1, texture), at(0, 0, distance_m), 2560));
    const cv::Vec3f middle = image.at<cv::Vec3f>(256, 256);
    EXPECT_NEAR(middle[2], (linear(240) + linear(40)) / 2, half_code) << distance_m;
    EXPECT_NEAR(middle[1], (linear(200) + linear(0)) / 2, half_code) << distance_m;
    EXPECT_NEAR(middle[0], linear(10), half_code) << distance_m;
  }
}

// A bent body with all that the light can do.
Scene grey_body() {
  Scene scene = coverage_scene(plate(1), at(0, 0, 10, {0.4, 0.3, 0}), 2560);
  Mesh mesh = scene.target->mesh;
  mesh.parts[0].albedo = 0.6;
  scene.target = target_of(mesh);
  scene.light = {.to_light_in_cam = Eigen::Vector3d(0.3, -0.2, -1).normalized(),
                 .ambient = 0.2,
                 .directional = 0.5,
                 .specular = 0.3};
  scene.background.kind = BackgroundKind::kSky;
  scene.background.level = 0.3;
  scene.sensor.read_noise_grey = 0;
  return scene;
}

TEST(Colour, WhatIsGreyIsTheGreyPictureThreeTimes) {
  Scene scene = grey_body();
  scene.livery = {.contrast = 0.5, .stripe_m = 0.1};
  scene.light.casts_shadow = true;
  scene.camera = centred_camera(256, 256, 1280);
  const Frame grey = Renderer().render(scene, no_noise());
  EXPECT_TRUE(grey.colour.empty());
  scene.colouring.mode = ColourMode::kRgb;
  const Frame colour = Renderer().render(scene, no_noise());
  ASSERT_EQ(colour.colour.type(), CV_8UC3);
  std::vector<cv::Mat> channels;
  cv::split(colour.colour, channels);
  for (const cv::Mat& channel : channels) {
    EXPECT_LE(cv::norm(channel, grey.image, cv::NORM_INF), 1);  // one code at a rounding's edge
  }
  EXPECT_LE(cv::norm(colour.image, grey.image, cv::NORM_INF), 1);
  EXPECT_EQ(cv::norm(colour.depth_m, grey.depth_m, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(colour.part_ids, grey.part_ids, cv::NORM_INF), 0);
}

// Of a plate before nothing, lit from in front.
TEST(Colour, ShadowsAndHighlightsFindThePrint) {
  Scene scene = upright(8);
  scene.light = {.to_light_in_cam = -Eigen::Vector3d::UnitZ(), .ambient = 0.3, .directional = 0.5};
  const cv::Mat plain = Renderer().render_linear(scene);
  scene.light.casts_shadow = true;
  EXPECT_LT(cv::norm(Renderer().render_linear(scene), plain, cv::NORM_INF), 1e-6);
  scene.light.specular = 0.1;
  EXPECT_GT(cv::norm(Renderer().render_linear(scene), plain, cv::NORM_INF), 0.05);
}

// Stripes finer than pixels: the samples of one triangle have lights of their own under print too.
TEST(Colour, WhitePrintIsSeenUnderTheLightOfEachSample) {
  Texture white{.name = "white", .width = 1, .height = 1, .rgba = {255, 255, 255, 255}};
  Mesh mesh = painted_plate(1, std::make_shared<const Texture>(std::move(white)));
  Scene scene = colour_scene(mesh, at(0, 0, 10, {0.4, 0.3, 0}), 2560);
  scene.livery = {.contrast = 0.5, .stripe_m = 0.003};
  scene.light = {.to_light_in_cam = Eigen::Vector3d(0.3, -0.2, -1).normalized(),
                 .ambient = 0.2,
                 .directional = 0.5,
                 .specular = 0.3};
  const cv::Mat printed = Renderer().render_linear(scene);
  mesh.parts[0].material->base_texture = {};
  mesh.coats.clear();
  scene.target = target_of(mesh);
  EXPECT_LT(cv::norm(printed, Renderer().render_linear(scene), cv::NORM_INF), 2 * kRounding);
}

TEST(Colour, WhatSurfacesSendByATextureIsThatPrintInFullLight) {
  Mesh mesh = painted_plate(1, many_colours(8, 8));
  Scene scene = colour_scene(mesh, at(0, 0, 10, {0.4, 0.3, 0}), 2560);
  scene.light = {.ambient = 1, .directional = 0};
  const cv::Mat lit = Renderer().render_linear(scene);
  Material& material = *mesh.parts[0].material;
  std::swap(material.emissive_texture, material.base_texture);
  material.emissive = {0.5, 0.5, 0.5};
  scene.target = target_of(mesh);
  scene.light.ambient = 0;
  cv::Mat halves = lit.clone();
  halves *= 0.5;
  EXPECT_GT(cv::norm(lit, cv::NORM_INF), 0.5);
  EXPECT_LT(cv::norm(Renderer().render_linear(scene) - halves, cv::NORM_INF), 2 * kRounding);
}

TEST(Colour, InGreyATextureIsItsLuminance) {
  Scene scene = upright(8);
  Mesh mesh = scene.target->mesh;
  mesh.parts[0].material->base_texture.is_nearest = true;
  scene.target = target_of(mesh);
  scene.colouring.mode = ColourMode::kGrey;
  const cv::Mat drawn = Renderer().render_linear(scene);
  ASSERT_EQ(drawn.type(), CV_32F);
  const auto* texel = &mesh.textures[0]->rgba[4 * (3 * 8 + 5)];
  EXPECT_NEAR(drawn.at<float>(128 + 3 * 32 + 9, 128 + 5 * 32 + 9),
              0.2126 * linear(texel[0]) + 0.7152 * linear(texel[1]) + 0.0722 * linear(texel[2]),
              kRounding);
  scene.colouring.draws_textures = false;
  const cv::Mat plain = Renderer().render_linear(scene);
  EXPECT_EQ(plain.at<float>(200, 200), 1);  // the factor alone
}

TEST(Colour, CornersColoursAreBlended) {
  Mesh mesh = plate(1);
  mesh.parts[0].material = Material{};
  for (const Triangle& triangle : mesh.triangles) {
    Coat coat;
    for (int c = 0; c < 3; ++c) {
      const double x = mesh.vertices[triangle.vertex[c]].x();
      coat.colour[c] = {static_cast<float>(x + 0.5), 0.5f, 0, 1};
    }
    mesh.coats.push_back(coat);
  }
  const cv::Mat image = Renderer().render_linear(colour_scene(mesh, at(0, 0, 10), 2560));
  for (const int u : {130, 200, 255, 380}) {
    EXPECT_NEAR(image.at<cv::Vec3f>(300, u)[2], (u - 127.5) / 256, 1e-4) << u;
    EXPECT_NEAR(image.at<cv::Vec3f>(300, u)[1], 0.5, kRounding);
    EXPECT_EQ(image.at<cv::Vec3f>(300, u)[0], 0);
  }
}

TEST(Colour, ANormalTextureTiltsTheLight) {
  // Even textures whose normals lean by 30 degrees to the right, and up.
  const double s = 0.5, c = std::sqrt(0.75);
  const auto code = [](double t) { return static_cast<uint8_t>(std::lround(255 * (t + 1) / 2)); };
  for (const bool is_up : {false, true}) {
    Mesh mesh = painted_plate(1, many_colours(2, 2));
    mesh.textures = {std::make_shared<const Texture>(
        Texture{"n", 1, 1, false, {code(is_up ? 0 : s), code(is_up ? s : 0), code(c), 255}})};
    mesh.parts[0].material = Material{};
    mesh.parts[0].material->normal_texture.texture = 0;
    Scene scene = colour_scene(mesh, at(0, 0, 10), 2560);
    scene.light = {.ambient = 0, .directional = 0.8};
    // The plate is seen from -z: right is x, up is -y.
    const Eigen::Vector3d leaning = is_up ? Eigen::Vector3d(0, -s, -c) : Eigen::Vector3d(s, 0, -c);
    const Eigen::Vector3d other = Eigen::Vector3d(-leaning.x(), -leaning.y(), leaning.z());
    for (const Eigen::Vector3d& light : {leaning, other}) {
      scene.light.to_light_in_cam = light;
      const double got = Renderer().render_linear(scene).at<cv::Vec3f>(300, 300)[1];
      EXPECT_NEAR(got, 0.8 * light.dot(leaning), 0.8 * 0.01) << is_up;  // codes are 1/127 apart
    }
  }
}

TEST(Colour, ASecondLightAndColouredOnesAdd) {
  Scene scene = colour_scene(plate(1), at(0, 0, 10), 2560);
  const Eigen::Vector3d aside = Eigen::Vector3d(0.6, 0, -0.8);
  scene.light = {.ambient = 0.1, .directional = 0.3, .second = 0.5, .to_second_in_cam = aside};
  scene.light.colour = {1, 0.5, 0};
  scene.light.second_colour = {0, 0.25, 1};
  const cv::Vec3f got = Renderer().render_linear(scene).at<cv::Vec3f>(300, 300);
  EXPECT_NEAR(got[2], 0.1 + 0.3, kRounding);
  EXPECT_NEAR(got[1], 0.1 + 0.3 * 0.5 + 0.5 * 0.8 * 0.25, kRounding);
  EXPECT_NEAR(got[0], 0.1 + 0.5 * 0.8, kRounding);
  scene.colouring.mode = ColourMode::kGrey;
  const double luminance = 0.2126 * got[2] + 0.7152 * got[1] + 0.0722 * got[0];
  EXPECT_NEAR(Renderer().render_linear(scene).at<float>(300, 300), luminance, kRounding);
}

TEST(Colour, GlossShowsTheLightWhereItIsMirrored) {
  // A plate that turns its normal half way between eye and light, smooth and then rough.
  Scene scene = colour_scene(plate(1), at(0, 0, 10), 2560);
  scene.light = {.to_light_in_cam = Eigen::Vector3d(0, 0, -1), .ambient = 0, .directional = 0.1};
  Mesh mesh = scene.target->mesh;
  const auto light_of = [&](double metallic, double roughness) {
    Material material;
    material.base = {0.5, 0.5, 0.5, 1};
    material.has_gloss = true;
    material.metallic = metallic;
    material.roughness = roughness;
    mesh.parts[0].material = material;
    scene.target = target_of(mesh);
    return Renderer().render_linear(scene).at<cv::Vec3f>(255, 255)[0];
  };
  // Facing all: D V = 1 / (4 pi a^2), Fresnel at normal incidence.
  const double a2 = std::pow(0.8, 4);
  EXPECT_NEAR(light_of(1, 0.8), 0.5 * 0.1 / (4 * a2), 1e-5);
  EXPECT_NEAR(light_of(0, 0.8), 0.96 * 0.5 * 0.1 + 0.04 * 0.1 / (4 * a2), 1e-5);
  EXPECT_GT(light_of(1, 0.3), light_of(1, 0.8));
}

TEST(Colour, EachChannelHasNoiseOfItsOwn) {
  Scene scene = colour_scene(plate(1), at(0, 0, 10), 2560);
  scene.background.level = 0.5;
  scene.sensor.read_noise_grey = 3;
  const Frame frame = Renderer().render(scene, no_noise());
  std::vector<cv::Mat> channels;
  cv::split(frame.colour(cv::Rect(0, 0, 512, 100)), channels);
  for (const int other : {1, 2}) {
    cv::Mat difference, mean, sd;
    channels[0].convertTo(difference, CV_32F);
    cv::subtract(difference, channels[static_cast<size_t>(other)], difference, cv::noArray(),
                 CV_32F);
    cv::meanStdDev(difference, mean, sd);
    // Two independent ones; five standard errors of 51200 pixels are 1.6 %.
    EXPECT_NEAR(sd.at<double>(0), 3 * std::numbers::sqrt2, 0.05 * 3 * std::numbers::sqrt2);
  }
}

// Gold and blue beside white, by the hue of what is far from grey.
TEST(Colour, ALiveryHasItsColours) {
  Scene scene;
  scene.target = load_target("boeing707_livery");
  scene.camera = centred_camera(320, 240, 6000);
  scene.cam_from_target = at(0, 0, 1400, {-1.2, 0, 0});
  scene.colouring.mode = ColourMode::kRgb;
  cv::Mat hsv;
  cv::cvtColor(Renderer().render(scene, no_noise()).colour, hsv, cv::COLOR_BGR2HSV);
  int gold = 0, blue = 0, white = 0;
  for (const cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(hsv)) {
    if (pixel[2] < 60) continue;
    if (pixel[1] < 25) ++white;
    if (pixel[1] < 110) continue;
    if (pixel[0] > 13 && pixel[0] < 30) ++gold;
    if (pixel[0] > 105 && pixel[0] < 128) ++blue;
  }
  EXPECT_GT(gold, 100);
  EXPECT_GT(blue, 60);
  EXPECT_GT(white, 500);
}

}  // namespace
}  // namespace sightline
