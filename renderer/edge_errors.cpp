// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/edge_errors.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "renderer/sample_pattern.h"
#include "scenes/builders/cube.h"

namespace sightline {
namespace {

// Nearer to an axis the few steps that an edge takes over the lattice do not average out.
constexpr double kGeneralSlope = 0.05;
constexpr size_t kLeastPoints = 20;  // of an edge whose position means something

// cv::convexHull takes float: good enough to say which vertices, not where.
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

OutlineEdge measure_edge(const cv::Mat& linear, const Eigen::Vector2d& begin,
                         const Eigen::Vector2d& end, const Eigen::Vector2d& inside) {
  constexpr int kReach = 6;     // pixels summed on either side
  constexpr double kEndPx = 8;  // stay away from the corners
  OutlineEdge edge{begin, end, {}};
  const Eigen::Vector2d d = end - begin;
  const int along = std::abs(d.y()) > std::abs(d.x()) ? 1 : 0;
  const int across = 1 - along;
  edge.slope = std::abs(d[across] / d[along]);
  const bool is_inside_above = inside[across] > ((begin + end) / 2)[across];
  const int size[2] = {linear.cols, linear.rows};
  const double low = std::max(std::min(begin[along], end[along]) + kEndPx, 0.0);
  const double high = std::min(std::max(begin[along], end[along]) - kEndPx, size[along] - 1.0);
  for (int step = static_cast<int>(std::ceil(low)); step <= high; ++step) {
    const double predicted = begin[across] + d[across] * (step - begin[along]) / d[along];
    const int centre = static_cast<int>(std::lround(predicted));
    if (centre < kReach || centre >= size[across] - kReach) continue;
    double covered = 0;
    for (int j = -kReach; j <= kReach; ++j) {
      covered +=
          across == 0 ? linear.at<float>(step, centre + j) : linear.at<float>(centre + j, step);
    }
    Eigen::Vector2d point;
    point[along] = step;
    point[across] =
        is_inside_above ? centre + kReach + 0.5 - covered : centre - kReach - 0.5 + covered;
    edge.measured.push_back(point);
    edge.position_error_px += point[across] - predicted;
  }
  if (edge.measured.empty()) return edge;
  const double cosine = std::abs(d[along]) / d.norm();  // from along a row to across the edge
  edge.position_error_px *= cosine / static_cast<double>(edge.measured.size());
  return edge;
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

class Rms {
 public:
  void add(double error) {
    sum2_ += error * error;
    ++count_;
  }
  double value() const { return count_ > 0 ? std::sqrt(sum2_ / count_) : 0; }
  int count() const { return count_; }

 private:
  double sum2_ = 0;
  int count_ = 0;
};

void add_vertices(const std::vector<OutlineEdge>& edges, Rms& error) {
  constexpr size_t kLeastPointsOfALine = 40;
  constexpr double kLeastSine = 0.5;
  for (size_t i = 0; i < edges.size(); ++i) {
    const OutlineEdge& a = edges[i];
    const OutlineEdge& b = edges[(i + 1) % edges.size()];
    if (std::min(a.measured.size(), b.measured.size()) < kLeastPointsOfALine) continue;
    const auto [point_a, along_a] = fit_line(a.measured);
    const auto [point_b, along_b] = fit_line(b.measured);
    const double sine = along_a.x() * along_b.y() - along_a.y() * along_b.x();
    if (std::abs(sine) < kLeastSine) continue;
    const Eigen::Vector2d to_b = point_b - point_a;
    const double step = (to_b.x() * along_b.y() - to_b.y() * along_b.x()) / sine;
    error.add((point_a + step * along_a - b.begin).norm());
  }
}

Scene white_cube(int samples_per_pixel) {
  Target cube{"cube", "", build_cube().mesh, {}, {}, Occluder({})};
  for (Part& part : cube.mesh.parts) part.albedo = 1;
  Scene scene;
  scene.target = std::make_shared<const Target>(std::move(cube));
  scene.camera = centred_camera(512, 512, 10000);
  scene.light.ambient = 1;
  scene.light.directional = 0;
  scene.background.level = 0;
  scene.samples_per_pixel = samples_per_pixel;
  return scene;
}

}  // namespace

std::vector<OutlineEdge> measure_outline(const Scene& scene, const cv::Mat& linear) {
  const std::vector<Eigen::Vector2d> hull = projected_hull(scene);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : hull) middle += corner / static_cast<double>(hull.size());
  std::vector<OutlineEdge> edges;
  for (size_t i = 0; i < hull.size(); ++i) {
    edges.push_back(measure_edge(linear, hull[i], hull[(i + 1) % hull.size()], middle));
  }
  return edges;
}

EdgeErrors measure_edge_errors(Renderer& renderer, int samples_per_pixel, int poses) {
  Scene scene = white_cube(samples_per_pixel);
  RandomStream stream(1, "edge errors", 0);
  Rms general, axis, vertex;
  for (int i = 0; i < poses; ++i) {
    scene.cam_from_target.translation = {stream.uniform(-0.5, 0.5), stream.uniform(-0.5, 0.5), 60};
    scene.cam_from_target.rotation = stream.rotation();
    const auto turned = measure_outline(scene, renderer.render_linear(scene));
    for (const OutlineEdge& edge : turned) {
      if (edge.measured.size() < kLeastPoints || edge.slope < kGeneralSlope) continue;
      general.add(edge.position_error_px);
    }
    add_vertices(turned, vertex);
    // Seen face on, all four edges of the outline are parallel to the axes.
    scene.cam_from_target.rotation = Eigen::Matrix3d::Identity();
    for (const OutlineEdge& edge : measure_outline(scene, renderer.render_linear(scene))) {
      axis.add(edge.position_error_px);
    }
  }
  return {general.value(), axis.value(), vertex.value(),
          general.count(), axis.count(), vertex.count()};
}

EdgeErrors promised_edge_errors(int samples_per_pixel) {
  // Along an axis 1 / (count sqrt(12)), and a fifth more for the luck of the poses; the others as
  // measured on some thousand edges, and half more.
  const double axis_px = 1.2 / (sample_pattern(samples_per_pixel).count * std::sqrt(12.0));
  const auto promise = [axis_px](double general_px, double vertex_px) {
    return EdgeErrors{general_px, axis_px, vertex_px};
  };
  switch (samples_per_pixel) {
    case 1:
      return promise(0.050, 0.25);
    case 4:
      return promise(0.020, 0.09);
    case 8:
      return promise(0.008, 0.05);
    case 16:
      return promise(0.005, 0.02);
    case 32:
      return promise(0.003, 0.012);
    case 64:
      return promise(0.001, 0.005);
    default:
      return promise(0.0003, 0.0015);
  }
}

}  // namespace sightline
