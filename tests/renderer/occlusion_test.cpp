// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What bodies keep from each other: ambient occlusion against form factors in closed form (J.
// Howell, A catalog of radiation configuration factors), and soft shadows against all triangles.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "renderer/disc_shadow.h"
#include "renderer/open_sky.h"
#include "renderer/renderer.h"
#include "renderer/truth.h"
#include "scenes/files/assets.h"
#include "scenes/random/random.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
// Of 128 directions above a surface none weighs more than 1 / 64; an outline is known to a few.
constexpr double kLattice = 0.02;
const Eigen::Vector3d kTowardsCamera(0, 0, -1);

// A floor that faces the camera, 20 m wide and 20 m before it, and one more plate.
Scene floor_and(const Pose& cam_from_plate, double plate_m) {
  Scene scene = coverage_scene(plate(20), at(0, 0, 20));
  scene.others.push_back({target_of(plate(plate_m)), cam_from_plate, true});
  scene.light.is_glow_occluded = true;
  return scene;
}

OpenSky floor_sky(const Scene& scene) {
  return OpenSky(placed_bodies(scene, scene.cam_from_target), 0);
}

double share_at(const OpenSky& sky, const Eigen::Vector3d& x) {
  return sky.share(x, kTowardsCamera, kTowardsCamera);
}

// A wall of height 20 and width 20 on the floor, as a point `d` before its middle sees it.
double hidden_by_wall(double d) {
  const double slanted = std::hypot(d, 20);
  return (std::atan(10 / d) - d / slanted * std::atan(10 / slanted)) / kHalfTurn;
}

TEST(OpenSky, AWallHidesWhatItsFormFactorSays) {
  const OpenSky sky = floor_sky(floor_and(at(0, -5, 10, {kHalfTurn / 2, 0, 0}), 20));
  for (const double d : {0.3, 1.0, 3.0, 8.0}) {
    EXPECT_NEAR(share_at(sky, {0, d - 5, 0}), 1 - hidden_by_wall(d), kLattice) << d;
  }
  EXPECT_NEAR(hidden_by_wall(1e-3), 0.5, 1e-3);  // of a corner half the sky is open
  EXPECT_NEAR(share_at(sky, {0, -4.8, 0}), 0.5, kLattice);
}

// A square of side 2 a at height h over a point hides four times what one of its quarters does. A
// point is asked from 1.5 texels above it, here 0.12 m.
TEST(OpenSky, ARoofHidesWhatItsFormFactorSays) {
  for (const double h : {5.0, 8.0}) {
    const double side = 2 / h, slanted = std::hypot(1, side);
    const double hidden = 4 / kHalfTurn * side / slanted * std::atan(side / slanted);
    const OpenSky sky = floor_sky(floor_and(at(0, 0, 20 - h), 4));
    EXPECT_NEAR(share_at(sky, {0, 0, 0}), 1 - hidden, kLattice) << h;
  }
}

TEST(OpenSky, OfSomethingConvexItIsOpen) {
  Scene scene = coverage_scene(load_target("cube")->mesh, at(0.1, 0.2, 20, {0.4, 0.5, 0.6}));
  scene.camera = centred_camera(64, 64, 800);
  const cv::Mat open = Renderer().render_linear(scene);
  scene.light.is_glow_occluded = true;
  EXPECT_EQ(cv::norm(open, Renderer().render_linear(scene), cv::NORM_INF), 0);
}

// In pictures the glow alone is dimmed, whatever else lights the floor, in grey and in colour.
TEST(OpenSky, DimsTheGlowAndNothingElse) {
  Scene scene = floor_and(at(0, -5, 10, {kHalfTurn / 2, 0, 0}), 20);
  scene.camera = centred_camera(9, 9, 400);
  Renderer renderer;
  const auto middle = [&](ColourMode mode) -> double {
    scene.colouring.mode = mode;
    const cv::Mat image = renderer.render_linear(scene);
    return mode == ColourMode::kGrey ? image.at<float>(4, 4) : image.at<cv::Vec3f>(4, 4)[1];
  };
  for (const bool has_detail : {false, true}) {
    scene.light.ambient = 0.4;
    scene.light.directional = 0.3;
    scene.light.to_light_in_cam = kTowardsCamera;
    scene.light.casts_shadow = has_detail;
    const double expected = 0.4 * (1 - hidden_by_wall(5)) + 0.3;
    for (const ColourMode mode : {ColourMode::kGrey, ColourMode::kRgb}) {
      EXPECT_NEAR(middle(mode), expected, 0.4 * kLattice);
    }
  }
  scene.light.is_glow_occluded = false;
  EXPECT_NEAR(middle(ColourMode::kGrey), 0.7, 1e-6);
}

// Kept while bodies stand as they did, made anew when they do not.
TEST(OpenSky, IsThatOfTheSceneAndNotOfTheLast) {
  Renderer renderer;
  Scene scene = floor_and(at(0, -5, 10, {kHalfTurn / 2, 0, 0}), 20);
  scene.camera = centred_camera(9, 9, 400);
  const auto middle = [&] { return renderer.render_linear(scene).at<float>(4, 4); };
  const float before = middle();
  EXPECT_EQ(middle(), before);
  EXPECT_NEAR(before, 1 - hidden_by_wall(5), kLattice);
  scene.others.front().cam_from_target.translation.y() = -2;
  EXPECT_NEAR(middle(), 1 - hidden_by_wall(2), kLattice);
  scene.others.clear();
  EXPECT_EQ(middle(), 1);
}

// Of a target alone a sky is kept whatever its pose, and says the same wherever it was made.
TEST(OpenSky, DoesNotDependOnThePictureBefore) {
  Mesh corner = plate(20);
  for (const auto& [x, z] : {std::pair{-10, 0}, {10, 0}, {10, -20}, {-10, -20}}) {
    corner.vertices.emplace_back(x, -5, z);
  }
  corner.triangles.push_back({.vertex = {4, 6, 5}, .part = 0});
  corner.triangles.push_back({.vertex = {4, 7, 6}, .part = 0});
  compute_corner_normals(corner, 0.1);
  Scene scene = coverage_scene(corner, at(0, 0, 60, {0.3, 0.2, 0.7}));
  scene.camera = centred_camera(32, 32, 80);
  scene.light.is_glow_occluded = true;
  const cv::Mat fresh = Renderer().render_linear(scene);
  Renderer renderer;
  Scene other = scene;
  other.cam_from_target = at(1, 2, 50, {-0.4, 0.5, 0.1});
  EXPECT_GT(cv::norm(renderer.render_linear(other), fresh, cv::NORM_INF), 0.1);
  EXPECT_EQ(cv::norm(renderer.render_linear(scene), fresh, cv::NORM_INF), 0);
}

// The maps of many bodies are coarser.
TEST(OpenSky, OfManyBodiesIsRight) {
  Scene scene = floor_and(at(0, -5, 10, {kHalfTurn / 2, 0, 0}), 20);
  const std::shared_ptr<const Target> plate_below = target_of(plate(1));
  for (int i = 0; i < 30; ++i) scene.others.push_back({plate_below, at(i, 0, 30), true});
  SkyMemory skies;
  skies.turn_to(scene);
  for (const double d : {1.0, 3.0, 8.0}) {
    const double share = skies.of(0)->share({0, d - 5, 0}, kTowardsCamera, kTowardsCamera);
    EXPECT_NEAR(share, 1 - hidden_by_wall(d), kLattice) << d;
  }
  scene.light.is_glow_occluded = false;
  skies.turn_to(scene);
  EXPECT_EQ(skies.of(0), nullptr);
}

// A point of a mesh's triangle, drawn.
Eigen::Vector3d point_on(const Mesh& mesh, int triangle, RandomStream& random) {
  Eigen::Vector3d weights(random.uniform(0, 1), random.uniform(0, 1), 0);
  if (weights.sum() > 1) weights.head<2>() = Eigen::Vector2d(1, 1) - weights.head<2>();
  weights[2] = 1 - weights.sum();
  const auto& corner = mesh.triangles[static_cast<size_t>(triangle)].vertex;
  return weights[0] * mesh.vertices[corner[0]] + weights[1] * mesh.vertices[corner[1]] +
         weights[2] * mesh.vertices[corner[2]];
}

// Whether any other triangle stops the ray, by three equations a triangle (Cramer).
bool is_stopped(const Mesh& mesh, int own, const Eigen::Vector3d& x, const Eigen::Vector3d& ray,
                double tolerance) {
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (static_cast<int>(i) == own) continue;
    const auto& corner = mesh.triangles[i].vertex;
    const Eigen::Vector3d a = mesh.vertices[corner[0]];
    Eigen::Matrix3d edges;
    edges << mesh.vertices[corner[1]] - a, mesh.vertices[corner[2]] - a, -ray;
    const double determinant = edges.determinant();
    if (determinant == 0) continue;
    const Eigen::Vector3d at = edges.inverse() * (x - a);
    if (at[0] >= 0 && at[1] >= 0 && at[0] + at[1] <= 1 && at[2] > tolerance) return true;
  }
  return false;
}

// The airliner in the light of a disc: its shadows are what rays to the disc's points say, each
// against all triangles, one after the other.
TEST(DiscShadow, IsWhatAllTrianglesSay) {
  constexpr double kTexelM = 0.014;
  constexpr int kSurfacePoints = 20000, kOfEach = 12;
  constexpr int kAllPoints = 1;  // samples a pixel: one asks for all points
  const std::shared_ptr<const Target> target = load_target("boeing707");
  const Mesh& mesh = target->mesh;
  const std::vector<PlacedBody> bodies{{.mesh = &mesh, .cam_from_body = at(0, 0, 1400)}};
  const Eigen::Vector3d to_light = Eigen::Vector3d(0.5, -0.3, -0.6).normalized();
  const Light light{.to_light_in_cam = to_light, .casts_shadow = true, .radius_deg = 3};
  ASSERT_TRUE(DiscShadow::is_narrow(bodies, 0, to_light, light.radius_deg));
  EXPECT_FALSE(DiscShadow::is_narrow(bodies, 0, to_light, 10));
  const Shadow shadow(bodies, 0, light, kTexelM, kAllPoints);
  const std::vector<Eigen::Vector3d> points =
      points_of_disc(to_light, light.radius_deg, Shadow::kDiscPoints);
  const double tolerance_m = 1e-5 * 2 * radius_m(mesh);  // as shadow maps have it
  RandomStream random(5, "surface", 0);
  int partly_lit = 0, wholly = 0, shaded = 0;
  double difference = 0;
  for (int i = 0; i < kSurfacePoints && (partly_lit < kOfEach || wholly < kOfEach); ++i) {
    const int triangle = static_cast<int>(random.uniform(0, 1) * mesh.triangles.size());
    const Eigen::Vector3d normal = winding_normal(mesh, mesh.triangles[triangle]);
    if (normal.dot(to_light) < 0.1 * normal.norm()) continue;
    const Eigen::Vector3d x = point_on(mesh, triangle, random);
    const double found = shadow.lit_share(x, normal, triangle, 0);
    int& count = found > 0 && found < 1 ? partly_lit : wholly;
    if (count == kOfEach) continue;
    ++count;
    const auto lit = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& ray) {
      return !is_stopped(mesh, triangle, x, ray, tolerance_m);
    });
    difference += std::abs(found - static_cast<double>(lit) / Shadow::kDiscPoints);
    shaded += lit == 0 ? 1 : 0;
  }
  // What is lost lies in penumbras narrower than a fifth of a cell.
  EXPECT_LE(difference, 0.002 * 2 * kOfEach);
  EXPECT_EQ(partly_lit, kOfEach);
  EXPECT_EQ(wholly, kOfEach);
  EXPECT_GT(shaded, 1);
}

// Rays to a wider disc, or past more triangles that stand as high, would take longer than maps.
TEST(DiscShadow, IsForFewTrianglesARay) {
  constexpr double kRadiusDeg = 3.5;
  const std::shared_ptr<const Target> cube = load_target("cube");
  Mesh body = cube->mesh;
  for (Eigen::Vector3d& vertex : body.vertices) vertex.z() *= 10;
  const std::vector<PlacedBody> bodies{{.mesh = &body, .cam_from_body = at(0, 0, 100)}};
  const Eigen::Vector3d end_on(0, 0, -1), side_on(0, -1, 0);
  EXPECT_FALSE(DiscShadow::is_narrow(bodies, 0, end_on, kRadiusDeg));
  EXPECT_TRUE(DiscShadow::is_narrow(bodies, 0, end_on, kRadiusDeg / 10));
  EXPECT_TRUE(DiscShadow::is_narrow(bodies, 0, side_on, kRadiusDeg));
  body = cube->mesh;
  EXPECT_TRUE(DiscShadow::is_narrow(bodies, 0, end_on, kRadiusDeg));
  body.triangles.resize(50000, body.triangles.front());
  EXPECT_FALSE(DiscShadow::is_narrow(bodies, 0, end_on, kRadiusDeg));
  EXPECT_TRUE(DiscShadow::is_narrow(bodies, 0, end_on, kRadiusDeg / 10));
}

// A white rectangle whose outside is towards -z.
Mesh strip(double length_m, double width_m) {
  Mesh mesh = plate(length_m);
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex.y() *= width_m / length_m;
  return mesh;
}

// A strut that lies between two rows of the shadow map's texels, 2 m over the floor.
TEST(DiscShadow, FindsWhatTheMapIsTooCoarseFor) {
  constexpr double kTexelM = 0.05, kMapTexelM = 4 * kTexelM;
  constexpr double kHeightM = 2, kWidthM = 0.05, kRadiusDeg = 1;
  constexpr double kShare = 3.2 / Shadow::kDiscPoints;
  const Mesh floor = plate(20), strut = strip(16, kWidthM);
  const double middle = kMapTexelM / 2;
  const Light light{.to_light_in_cam = kTowardsCamera, .radius_deg = kRadiusDeg};
  const auto lit = [&](const Pose& cam_from_strut, double y) {
    const std::vector<PlacedBody> bodies{
        {.mesh = &floor, .cam_from_body = at(0, 0, 20)},
        {.mesh = &strut, .cam_from_body = cam_from_strut, .first_id = 3}};
    const ShadowMap map(bodies, 0, light.to_light_in_cam, kMapTexelM, Shadow::kMaxDiscTexels);
    EXPECT_LT(map.height_over_m({1.03, y, 0}), kHeightM / 2) << "the map shows it";
    return Shadow(bodies, 0, light, kTexelM, 1).lit_share({1.03, y, 0}, kTowardsCamera, 0, 0);
  };
  // Of the disc it hides a strip through the middle.
  const double part = kWidthM / 2 / (kHeightM * std::tan(kRadiusDeg * kHalfTurn / 180));
  const double hidden = 2 / kHalfTurn * (std::asin(part) + part * std::sqrt(1 - part * part));
  const Pose over = at(0, middle, 20 - kHeightM);
  EXPECT_NEAR(lit(over, middle), 1 - hidden, kShare);
  EXPECT_EQ(lit(over, middle + 3 * kMapTexelM), 1);
  EXPECT_EQ(lit(at(0, middle, 20 + kHeightM), middle), 1) << "it lies below";
}

// A roof so wide that its far end is beyond any count of tiles shades all of them.
TEST(DiscShadow, IsCastByWhatEndsFarAway) {
  const Mesh floor = plate(20), roof = plate(1e12);
  const std::vector<PlacedBody> bodies{
      {.mesh = &floor, .cam_from_body = at(0, 0, 20)},
      {.mesh = &roof, .cam_from_body = at(0, 0, 18), .first_id = 3}};
  const ShadowMap map(bodies, 0, kTowardsCamera, 0.2, Shadow::kMaxDiscTexels);
  const DiscShadow shadow(bodies, 0, kTowardsCamera, 1, map,
                          points_of_disc(kTowardsCamera, 1, Shadow::kDiscPoints));
  for (const double x : {-9.0, 9.0}) {
    EXPECT_FALSE(shadow.is_lit({x, 3, 0}, 0, 0)) << x;
  }
}

}  // namespace
}  // namespace sightline
