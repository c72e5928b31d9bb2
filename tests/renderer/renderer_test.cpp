// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The renderer against closed forms: what it draws must lie where the camera says.
#include "renderer/renderer.h"

#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "scenes/builders/cube.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

std::shared_ptr<const Target> target_of(Mesh mesh) {
  Occluder occluder(mesh);
  return std::make_shared<const Target>(
      Target{"test", "", std::move(mesh), {}, {}, std::move(occluder)});
}

// Everything white on black without shading: the image is the share of each pixel that is covered.
Scene coverage_scene(Mesh mesh, const Pose& cam_from_target, double focal_px = 10000) {
  for (Part& part : mesh.parts) part.albedo = 1;
  Scene scene;
  scene.target = target_of(std::move(mesh));
  scene.camera = centred_camera(512, 512, focal_px);
  scene.cam_from_target = cam_from_target;
  scene.light = {.to_light_in_cam = -Eigen::Vector3d::UnitZ(), .ambient = 1, .directional = 0};
  scene.background.level = 0;
  scene.samples_per_pixel = 16;
  return scene;
}

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

Pose at(double x, double y, double z, const Eigen::Vector3d& rotation_rad = {0, 0, 0}) {
  return {rotation_from_vector(rotation_rad), {x, y, z}};
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

// One edge of the target's outline: where the camera puts its ends, and where the image has it, row
// by row or column by column.
struct OutlineEdge {
  Eigen::Vector2d begin, end;             // projected vertices of the convex hull, in its order
  std::vector<Eigen::Vector2d> measured;  // points of the edge in the image
  std::vector<double> error_px;           // of each, across the row or column
};

// The projected vertices of the convex hull in order. cv::convexHull takes float: good enough to
// say which vertices, not where.
std::vector<Eigen::Vector2d> projected_hull(const Scene& scene) {
  std::vector<Eigen::Vector2d> exact;
  std::vector<cv::Point2f> rounded;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    exact.push_back(*project(scene.camera, scene.cam_from_target * vertex));
    rounded.emplace_back(static_cast<float>(exact.back().x()),
                         static_cast<float>(exact.back().y()));
  }
  std::vector<int> order;
  cv::convexHull(rounded, order);
  std::vector<Eigen::Vector2d> hull;
  for (const int i : order) hull.push_back(exact[i]);
  return hull;
}

// An image of coverage counts area: the sum over a few pixels across the edge says where it passes.
OutlineEdge measure_edge(const cv::Mat& image, const Eigen::Vector2d& begin,
                         const Eigen::Vector2d& end, const Eigen::Vector2d& inside) {
  constexpr int kReach = 6;     // pixels summed on either side
  constexpr double kEndPx = 8;  // stay away from the corners
  OutlineEdge edge{begin, end, {}, {}};
  const Eigen::Vector2d d = end - begin;
  const int along = std::abs(d.y()) > std::abs(d.x()) ? 1 : 0;
  const int across = 1 - along;
  const bool is_inside_above = inside[across] > ((begin + end) / 2)[across];
  const double low = std::min(begin[along], end[along]) + kEndPx;
  const double high = std::max(begin[along], end[along]) - kEndPx;
  for (int step = static_cast<int>(std::ceil(low)); step <= high; ++step) {
    const double predicted = begin[across] + d[across] * (step - begin[along]) / d[along];
    const int centre = static_cast<int>(std::lround(predicted));
    double covered = 0;
    for (int j = -kReach; j <= kReach; ++j) {
      covered +=
          across == 0 ? image.at<float>(step, centre + j) : image.at<float>(centre + j, step);
    }
    Eigen::Vector2d point;
    point[along] = step;
    point[across] =
        is_inside_above ? centre + kReach + 0.5 - covered : centre - kReach - 0.5 + covered;
    edge.measured.push_back(point);
    edge.error_px.push_back(point[across] - predicted);
  }
  return edge;
}

std::vector<OutlineEdge> measure_outline(const Scene& scene, const cv::Mat& image) {
  const std::vector<Eigen::Vector2d> hull = projected_hull(scene);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : hull) middle += corner / static_cast<double>(hull.size());
  std::vector<OutlineEdge> edges;
  for (size_t i = 0; i < hull.size(); ++i) {
    edges.push_back(measure_edge(image, hull[i], hull[(i + 1) % hull.size()], middle));
  }
  return edges;
}

struct Rms {
  double sum2 = 0;
  int count = 0;
  void add(double error) {
    sum2 += error * error;
    ++count;
  }
  double value() const { return std::sqrt(sum2 / count); }
};

// An edge's position is its mean error across itself over its length; its slope is 0 along an axis,
// 1 along a diagonal.
struct EdgePosition {
  double error_px;
  double slope;
};

std::vector<EdgePosition> edge_positions(const Scene& scene, const cv::Mat& image) {
  std::vector<EdgePosition> positions;
  for (const OutlineEdge& edge : measure_outline(scene, image)) {
    if (edge.error_px.size() < 20) continue;
    double mean = 0;
    for (const double error : edge.error_px) mean += error / edge.error_px.size();
    const Eigen::Vector2d d = (edge.end - edge.begin).cwiseAbs();
    const double cosine = d.maxCoeff() / d.norm();  // from along a row to across the edge
    positions.push_back({mean * cosine, d.minCoeff() / d.maxCoeff()});
    if (std::abs(mean) > 0.15) cv::imwrite(testing::TempDir() + "renderer_edges.png", image * 255);
  }
  return positions;
}

Pose random_pose(RandomStream& stream) {
  Pose pose = at(stream.uniform(-0.5, 0.5), stream.uniform(-0.5, 0.5), 60);
  pose.rotation = stream.rotation();
  return pose;
}

// Nearer to an axis the few steps that an edge takes over the sampling grid do not average out.
constexpr double kGeneralSlope = 0.05;

TEST(Renderer, GeneralEdgesOfACubeLieWhereTheCameraSays) {
  Renderer renderer;
  Rms error;
  RandomStream stream(1, "poses", 0);
  for (int i = 0; i < 40; ++i) {
    const Scene scene = coverage_scene(build_cube().mesh, random_pose(stream));
    for (const EdgePosition& edge : edge_positions(scene, renderer.render_linear(scene))) {
      if (edge.slope > kGeneralSlope) error.add(edge.error_px);
    }
  }
  EXPECT_GT(error.count, 150);
  EXPECT_LT(error.value(), 0.02);
}

TEST(Renderer, AnOutlineATenthOfAPixelOffWouldBeSeen) {
  Renderer renderer;
  RandomStream stream(1, "poses", 0);
  Scene scene = coverage_scene(build_cube().mesh, random_pose(stream));
  const cv::Mat image = renderer.render_linear(scene);
  scene.camera.cx_px += 0.1;  // what a half-hearted half-pixel convention would do
  scene.camera.cy_px -= 0.1;
  Rms error;
  for (const EdgePosition& edge : edge_positions(scene, image)) error.add(edge.error_px);
  EXPECT_GT(error.value(), 0.05);
}

TEST(Renderer, AxisAlignedEdgesLieWithinTheSamplingGrid) {
  Renderer renderer;
  Rms error;
  RandomStream stream(2, "poses", 0);
  for (int i = 0; i < 60; ++i) {
    // Seen face on, all four edges of the outline are parallel to the axes.
    const Pose pose = at(stream.uniform(-0.5, 0.5), stream.uniform(-0.5, 0.5), 60);
    const Scene scene = coverage_scene(build_cube().mesh, pose);
    for (const EdgePosition& edge : edge_positions(scene, renderer.render_linear(scene))) {
      error.add(edge.error_px);
    }
  }
  // Four columns of samples a pixel: the error is uniform over a quarter pixel. Sixty poses give
  // 240 edges, so the measured RMS is within 10 % of that.
  const double grid_px = 1 / (4 * std::sqrt(12.0));
  EXPECT_EQ(error.count, 240);
  EXPECT_LT(error.value(), 1.1 * grid_px);
  EXPECT_GT(error.value(), 0.5 * grid_px);  // the measurement can see errors of this size
}

// A line through measured points: a point of it and its direction.
std::pair<Eigen::Vector2d, Eigen::Vector2d> fit_line(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  return {mean, eigen.eigenvectors().col(1)};
}

TEST(Renderer, CubeCornersLieWhereTheCameraSays) {
  Renderer renderer;
  Rms error;
  RandomStream stream(3, "poses", 0);
  for (int i = 0; i < 20; ++i) {
    const Scene scene = coverage_scene(build_cube().mesh, random_pose(stream));
    const auto edges = measure_outline(scene, renderer.render_linear(scene));
    for (size_t j = 0; j < edges.size(); ++j) {
      const OutlineEdge& a = edges[j];
      const OutlineEdge& b = edges[(j + 1) % edges.size()];
      if (a.measured.size() < 40 || b.measured.size() < 40) continue;
      const auto [point_a, along_a] = fit_line(a.measured);
      const auto [point_b, along_b] = fit_line(b.measured);
      const double sine = along_a.x() * along_b.y() - along_a.y() * along_b.x();
      if (std::abs(sine) < 0.5) continue;
      const Eigen::Vector2d to_b = point_b - point_a;
      const double step = (to_b.x() * along_b.y() - to_b.y() * along_b.x()) / sine;
      error.add((point_a + step * along_a - b.begin).norm());
    }
  }
  EXPECT_GT(error.count, 40);
  EXPECT_LT(error.value(), 0.02);
}

TEST(Renderer, MoreSamplesGiveBetterEdges) {
  Renderer renderer;
  RandomStream stream(4, "poses", 0);
  std::map<int, Rms> errors;
  for (int i = 0; i < 5; ++i) {
    const Pose pose = random_pose(stream);
    for (const int samples : {1, 4, 16, 64}) {
      Scene scene = coverage_scene(build_cube().mesh, pose);
      scene.samples_per_pixel = samples;
      for (const OutlineEdge& edge : measure_outline(scene, renderer.render_linear(scene))) {
        for (const double error : edge.error_px) errors[samples].add(error);
      }
    }
  }
  EXPECT_LT(errors[4].value(), errors[1].value());
  EXPECT_LT(errors[16].value(), errors[4].value());
  EXPECT_LT(errors[64].value(), errors[16].value());
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

TEST(Renderer, SaysWhyASceneCannotBeImaged) {
  Renderer renderer;
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(0, 0, -60))),
               InputError);
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(0, 0, 0.2))),
               InputError);
  EXPECT_THROW(renderer.render_linear(coverage_scene(build_cube().mesh, at(50, 0, 60))),
               InputError);
  Scene distorted = coverage_scene(build_cube().mesh, at(0, 0, 60));
  distorted.camera.distortion.k1 = 0.1;
  EXPECT_THROW(renderer.render_linear(distorted), InputError);
}

TEST(Renderer, ATargetPartlyOutsideTheImageIsDrawnInPart) {
  const Scene scene = coverage_scene(build_cube().mesh, at(1.5, 0, 60));
  const Frame frame = Renderer().render(scene, RandomStream(1, "sensor", 0));
  EXPECT_EQ(frame.truth.target().visible_box.br().x, 512);
  EXPECT_GT(frame.truth.target().visible_pixels, 0);
}

}  // namespace
}  // namespace sightline
