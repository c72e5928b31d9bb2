// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The renderer against closed forms: what it draws must lie where the camera says.
#include "renderer/renderer.h"

#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "renderer/edge_errors.h"
#include "renderer/visibility.h"
#include "scenes/builders/cube.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"
#include "scenes/random/random.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

// An icosahedron refined and pushed onto the sphere; its facets lie inside by at most the sagitta.
Mesh sphere_mesh(double radius_m, int refinements) {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> v;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      v.emplace_back(0, a, b);
      v.emplace_back(a, b, 0);
      v.emplace_back(b, 0, a);
    }
  }
  std::vector<std::array<int, 3>> faces;
  for (int i = 0; i < 12; ++i) {
    for (int j = i + 1; j < 12; ++j) {
      for (int k = j + 1; k < 12; ++k) {
        const auto is_edge = [&](int a, int b) {
          return std::abs((v[a] - v[b]).norm() - 2) < 1e-9;
        };
        if (!is_edge(i, j) || !is_edge(j, k) || !is_edge(k, i)) continue;
        const bool is_outward = (v[j] - v[i]).cross(v[k] - v[i]).dot(v[i]) > 0;
        faces.push_back(is_outward ? std::array{i, j, k} : std::array{i, k, j});
      }
    }
  }
  for (int step = 0; step < refinements; ++step) {
    std::map<std::pair<int, int>, int> middle_of;
    const auto middle = [&](int a, int b) {
      const auto [at, is_new] = middle_of.emplace(std::minmax(a, b), static_cast<int>(v.size()));
      if (is_new) v.push_back((v[a] + v[b]) / 2);
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
    for (Eigen::Vector3d& vertex : v) vertex.normalize();
  }
  Mesh mesh;
  mesh.parts = {{"sphere", 1.0}};
  for (const Eigen::Vector3d& vertex : v) mesh.vertices.push_back(radius_m * vertex.normalized());
  for (const auto& face : faces) mesh.triangles.push_back({.vertex = face, .part = 0});
  compute_corner_normals(mesh, std::numbers::pi);
  return mesh;
}

TEST(Renderer, ASpheresDiscHasTheAreaAndCentroidOfItsEllipse) {
  constexpr double kRadius = 2.0, kDistance = 200.0;
  constexpr int kRefinements = 6;
  const Pose pose = at(1.234, -0.777, kDistance);
  const Scene scene = coverage_scene(sphere_mesh(kRadius, kRefinements), pose);
  Renderer renderer;
  const cv::Mat image = renderer.render_linear(scene);
  const cv::Moments moments = cv::moments(image);

  // The outline of a sphere is the cone |x|^2 (d^2 - R^2) = (x . c)^2 cut by the image plane; for a
  // centre direction c/d at angle a off the axis it is an ellipse of half-axes
  // A = f cos b sin b / (cos^2 a - sin^2 b), B = f sin b / sqrt(cos^2 a - sin^2 b), sin b = R/d,
  // and its centre lies at f tan a cos^2 a / (cos^2 a - sin^2 b) from the principal point.
  const double d = pose.translation.norm();
  const double cos2_a = std::pow(pose.translation.z() / d, 2);
  const double sin2_b = std::pow(kRadius / d, 2);
  const double f = scene.camera.fx_px;
  const double major = f * std::sqrt(sin2_b * (1 - sin2_b)) / (cos2_a - sin2_b);
  const double minor = f * std::sqrt(sin2_b / (cos2_a - sin2_b));
  const double area = std::numbers::pi * major * minor;
  const Eigen::Vector2d direction = pose.translation.head<2>().normalized();
  const double tan_a = pose.translation.head<2>().norm() / pose.translation.z();
  const Eigen::Vector2d centre =
      Eigen::Vector2d(255.5, 255.5) + f * tan_a * cos2_a / (cos2_a - sin2_b) * direction;

  // Facets of edge e cut the disc's area by a fraction of about (e/R)^2 / 12; e = 1.05 R / 2^n.
  const double facets = std::pow(1.05 / (1 << kRefinements), 2) / 12;
  EXPECT_NEAR(moments.m00 / area, 1, facets + 1e-4);
  EXPECT_NEAR(moments.m10 / moments.m00, centre.x(), 0.005);
  EXPECT_NEAR(moments.m01 / moments.m00, centre.y(), 0.005);
}

TEST(Renderer, APlanesDepthIsThatOfTheRay) {
  // One tilted face of a cube fills the image; its depth is known in closed form.
  const Pose pose = at(0.02, -0.01, 40, {0.4, -0.3, 0.2});
  Scene scene = coverage_scene(build_cube().mesh, pose, 40000);
  Renderer renderer;
  const Frame frame = renderer.render(scene, RandomStream(1, "sensor", 0));
  // The face towards the camera: of the six outward normals the one most against the view.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double least = 1;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d n = sign * pose.rotation.col(axis);
      if (n.z() < least) {
        least = n.z();
        normal = n;
      }
    }
  }
  const double offset = normal.dot(pose.translation) + 0.5;
  double worst = 0;
  int seen = 0;
  for (int v = 100; v < 400; v += 3) {
    for (int u = 100; u < 400; u += 3) {
      const auto ray = *normalised_from_pixel(scene.camera, {u, v});
      const double z = offset / normal.dot(Eigen::Vector3d(ray.x(), ray.y(), 1));
      const Eigen::Vector3d x_in_target =
          inverse(pose) * Eigen::Vector3d(z * ray.x(), z * ray.y(), z);
      if (x_in_target.cwiseAbs().maxCoeff() > 0.5 + 1e-9) continue;  // another face
      worst = std::max(worst, std::abs(frame.depth_m.at<double>(v, u) - z));
      ++seen;
    }
  }
  EXPECT_GT(seen, 2000);
  EXPECT_LT(worst, 1e-5);
  EXPECT_GT(worst, 0);  // not a comparison of a thing with itself
}

TEST(Renderer, DepthAndIdsOfTheBackgroundAreZero) {
  const Scene scene = coverage_scene(build_cube().mesh, at(0, 0, 100));
  const Frame frame = Renderer().render(scene, RandomStream(1, "sensor", 0));
  EXPECT_EQ(frame.depth_m.at<double>(0, 0), 0);
  EXPECT_EQ(frame.part_ids.at<uint16_t>(0, 0), 0);
  EXPECT_NE(frame.part_ids.at<uint16_t>(256, 256), 0);
  EXPECT_EQ(frame.truth.target().visible_pixels, cv::countNonZero(frame.part_ids));
  EXPECT_EQ(frame.truth.target().visible_pixels, cv::countNonZero(frame.depth_m));
  // 1 m at 99.5 m (the near face) with f = 10000 px.
  EXPECT_NEAR(frame.truth.target().visible_box.width, 10000 / 99.5, 1);
}

Pose random_pose(RandomStream& stream) {
  Pose pose = at(stream.uniform(-0.5, 0.5), stream.uniform(-0.5, 0.5), 60);
  pose.rotation = stream.rotation();
  return pose;
}

// Root mean square of where the outline's edges lie, against where the camera says.
double outline_error_px(const Scene& scene, const cv::Mat& linear) {
  double sum2 = 0;
  int count = 0;
  for (const OutlineEdge& edge : measure_outline(scene, linear)) {
    if (edge.measured.size() < 20) continue;
    sum2 += edge.position_error_px * edge.position_error_px;
    ++count;
  }
  return std::sqrt(sum2 / count);
}

TEST(Renderer, AnOutlineATenthOfAPixelOffWouldBeSeen) {
  Renderer renderer;
  RandomStream stream(1, "poses", 0);
  Scene scene = coverage_scene(build_cube().mesh, random_pose(stream));
  const cv::Mat image = renderer.render_linear(scene);
  EXPECT_LT(outline_error_px(scene, image), 0.01);
  scene.camera.cx_px += 0.1;  // what a half-hearted half-pixel convention would do
  scene.camera.cy_px -= 0.1;
  EXPECT_GT(outline_error_px(scene, image), 0.05);
}

TEST(Renderer, ShadesByTheLightsAngle) {
  Mesh mesh = build_cube().mesh;
  for (Part& part : mesh.parts) part.albedo = 0.5;
  Scene scene = coverage_scene(mesh, at(0, 0, 60));
  for (Part& part : mesh.parts) part.albedo = 0.5;
  scene.target = target_of(mesh);
  const double angle = 0.6;
  scene.light = {.to_light_in_cam = {std::sin(angle), 0, -std::cos(angle)},
                 .ambient = 0.2,
                 .directional = 0.7};
  const cv::Mat image = Renderer().render_linear(scene);
  EXPECT_NEAR(image.at<float>(256, 256), 0.5 * (0.2 + 0.7 * std::cos(angle)), 2e-5);
}

TEST(Renderer, TheBackOfAnOpenSheetIsLitLikeItsFront) {
  Mesh front = build_cube().mesh;
  Mesh back = front;
  for (Triangle& triangle : back.triangles) {
    std::swap(triangle.vertex[0], triangle.vertex[1]);
    for (Eigen::Vector3d& normal : triangle.normal) normal = -normal;
  }
  Renderer renderer;
  const Pose pose = at(0, 0, 60, {0.3, 0.5, 0.1});
  Scene scene = coverage_scene(front, pose);
  scene.light = {.to_light_in_cam = Eigen::Vector3d(0.3, -0.4, -0.8).normalized()};
  const cv::Mat image = renderer.render_linear(scene);
  scene.target = target_of(back);
  for (Part& part : back.parts) part.albedo = 1;
  scene.target = target_of(back);
  EXPECT_LT(cv::norm(image, renderer.render_linear(scene), cv::NORM_INF), 1e-4);
}

TEST(Renderer, TilesOfALargeImageFitTogether) {
  // At 64 samples a pixel an image wider than 512 px takes several framebuffers.
  Scene scene = coverage_scene(build_cube().mesh, at(0.1, -0.05, 6, {0.3, 0.4, 0.5}), 3000);
  scene.camera = centred_camera(900, 800, 3000);
  scene.samples_per_pixel = 64;
  Renderer renderer;
  const cv::Mat tiled = renderer.render_linear(scene);
  scene.samples_per_pixel = 16;
  const cv::Mat whole = renderer.render_linear(scene);
  EXPECT_NEAR(cv::sum(tiled)[0] / cv::sum(whole)[0], 1, 1e-4);
  EXPECT_LT(cv::norm(tiled, whole, cv::NORM_INF), 0.15);  // edges differ by the samples alone
}

TEST(Renderer, TheSameSceneGivesTheSameFrame) {
  const Scene scene = coverage_scene(build_cube().mesh, at(0, 0, 60, {0.3, 0.5, 0.1}));
  const Frame a = Renderer().render(scene, RandomStream(1, "sensor", 5));
  const Frame b = Renderer().render(scene, RandomStream(1, "sensor", 5));
  const Frame other = Renderer().render(scene, RandomStream(1, "sensor", 6));
  EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.part_ids, b.part_ids, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a.depth_m, b.depth_m, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(a.image, other.image, cv::NORM_INF), 0);
}

TEST(Renderer, JpegLosesWhatItsQualitySaysAndItsFileIsThatOfThePicture) {
  Scene scene = coverage_scene(build_cube().mesh, at(0, 0, 60, {0.3, 0.5, 0.1}));
  scene.sensor.read_noise_grey = 5;
  scene.colouring.mode = ColourMode::kRgb;
  const auto rendered = [&](int quality) {
    scene.sensor.jpeg_quality = quality;
    return Renderer().render(scene, RandomStream(1, "sensor", 5));
  };
  const Frame whole = rendered(0);
  EXPECT_TRUE(whole.colour_jpeg.empty());
  const auto loss = [&whole](const Frame& other) {
    return cv::norm(whole.colour, other.colour, cv::NORM_L1) /
           static_cast<double>(3 * whole.colour.total());
  };
  const Frame fine = rendered(100), coarse = rendered(30);
  EXPECT_LT(loss(fine), 2);  // colours have half the resolution at any quality
  EXPECT_GT(loss(coarse), loss(fine) + 1);
  EXPECT_EQ(cv::norm(decode_picture(coarse.colour_jpeg).pixels, coarse.colour, cv::NORM_INF), 0);
}

TEST(Renderer, SaysWhyASceneCannotBeImaged) {
  Renderer renderer;
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(0, 0, -60))),
               InputError);
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(0, 0, -2))), InputError);
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(50, 0, 60))),
               InputError);
  Scene scene = coverage_scene(build_cube().mesh, at(0, 0, 60));
  scene.samples_per_pixel = 17;
  EXPECT_THROW(renderer.render_linear(scene), InputError);
}

TEST(Renderer, ATargetPartlyOutsideTheImageIsDrawnInPart) {
  const Scene scene = coverage_scene(build_cube().mesh, at(1.5, 0, 60));
  const Frame frame = Renderer().render(scene, RandomStream(1, "sensor", 0));
  EXPECT_EQ(frame.truth.target().visible_box.br().x, 512);
  EXPECT_GT(frame.truth.target().visible_pixels, 0);
}

// Triangles that lie about at random, `count` of them from that one on.
ScreenMesh scattered(int first, int count) {
  ScreenMesh mesh;
  RandomStream stream(1, "triangles", 0);
  for (int i = 0; i < first + count; ++i) {
    const double x = stream.uniform(0, 64), y = stream.uniform(0, 64), nearness = stream.uniform();
    if (i < first) continue;
    const auto corner = static_cast<uint32_t>(mesh.points.size());
    mesh.points.insert(
        mesh.points.end(),
        {{x, y, nearness}, {x + 0.8, y + 0.1, nearness}, {x + 0.1, y + 0.9, nearness}});
    mesh.triangles.push_back({{corner, corner + 1, corner + 2}, static_cast<uint32_t>(i + 1)});
  }
  return mesh;
}

// What every sample of a canvas sees, row by row; 0 is nothing.
struct Seen {
  std::vector<uint32_t> ids;
  std::vector<float> nearness;
};

Seen seen_of(const ScreenMesh& mesh, const SamplePattern& pattern) {
  Seen seen;
  const std::unique_ptr<SamplePainter> painter = make_own_painter();
  VisibleStrip strip;
  painter->start(mesh, {0, 0, 64, 64}, pattern);
  while (painter->next(strip)) {
    for (size_t pixel = 0; pixel < strip.is_touched.size(); ++pixel) {
      for (size_t k = 0; k < static_cast<size_t>(pattern.count); ++k) {
        const size_t at = pixel * static_cast<size_t>(pattern.count) + k;
        seen.ids.push_back(strip.is_touched[pixel] ? strip.ids[at] : 0);
        seen.nearness.push_back(seen.ids.back() != 0 ? strip.nearness[at] : -1);
      }
    }
  }
  return seen;
}

// Hundreds of thousands are made ready in batches: what is seen of them is what is nearer of two
// halves that fit into one.
TEST(Painter, SeesManyTrianglesAsItSeesFew) {
  constexpr int kHalf = 200'000;
  const SamplePattern& pattern = sample_pattern(16);
  const Seen all = seen_of(scattered(0, 2 * kHalf), pattern);
  const Seen first = seen_of(scattered(0, kHalf), pattern);
  const Seen second = seen_of(scattered(kHalf, kHalf), pattern);
  int of_first = 0, of_second = 0, wrong = 0;
  for (size_t i = 0; i < all.ids.size(); ++i) {
    const bool is_second = second.nearness[i] > first.nearness[i];
    ++(is_second ? of_second : of_first);
    wrong += all.ids[i] != (is_second ? second : first).ids[i] ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(std::min(of_first, of_second), 16 * 64 * 64 / 4);  // either half alone would be wrong
}

}  // namespace
}  // namespace sightline
