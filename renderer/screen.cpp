// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

namespace sightline {
namespace {

constexpr int kMaxCuts = 40;  // of one triangle, in succession: each halves an edge
// Of the farthest depth: triangles with a nearer corner would reach far beyond the image, where
// double precision is coarse, and are cut too.
constexpr double kCutFraction = 1e-4;

// Farther out than this no lens that turns rays (a fisheye) is drawn: 89.9 degrees.
constexpr double kFarthestNormalised = 573;

// Twice what the canvas would show without its lens: models that bend the image alone are of no use
// farther out. The others end where rays do.
double farthest_normalised(const Camera& camera, const PixelBox& canvas) {
  if (std::holds_alternative<KannalaBrandt>(camera.lens)) return kFarthestNormalised;
  const Eigen::Array2d focal(camera.fx_px, camera.fy_px);
  const Eigen::Array2d centre(camera.cx_px, camera.cy_px);
  const Eigen::Array2d low(canvas.left - 0.5, canvas.top - 0.5);
  const Eigen::Array2d high(canvas.right - 0.5, canvas.bottom - 0.5);
  const Eigen::Array2d reach = ((low - centre) / focal).abs().max(((high - centre) / focal).abs());
  return 2 * reach.matrix().norm();
}

std::array<Eigen::Vector3d, 3> corners_of(const Mesh& mesh, const Pose& cam_from_mesh,
                                          const Triangle& triangle) {
  const auto [a, b, c] = triangle.vertex;
  return {cam_from_mesh * mesh.vertices[a], cam_from_mesh * mesh.vertices[b],
          cam_from_mesh * mesh.vertices[c]};
}

// True where a corner lies nearer than that, or behind the camera.
bool has_corner_before(double depth_m, const Mesh& mesh, const Pose& cam_from_mesh,
                       const Triangle& triangle) {
  const auto corners = corners_of(mesh, cam_from_mesh, triangle);
  return std::any_of(corners.begin(), corners.end(),
                     [depth_m](const Eigen::Vector3d& x) { return x.z() < depth_m; });
}

}  // namespace

double reference_depth_m(const Mesh& mesh, const Pose& cam_from_mesh) {
  if (cam_from_mesh.translation.z() > 0) return cam_from_mesh.translation.z();
  double farthest = 0;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    farthest = std::max(farthest, (cam_from_mesh * vertex).z());
  }
  return farthest > 0 ? farthest : 1;
}

struct Screen::LensPoint {
  Eigen::Vector2d normalised;  // without the lens
  Eigen::Vector2d pixel;       // through it
  double nearness;
  uint32_t index;  // of its point on the screen
};

Screen::Screen(const Camera& camera, const PixelBox& canvas, double reference_m)
    : camera_(camera), canvas_(canvas), reference_m_(reference_m) {
  if (is_straight(camera)) return;
  if (std::holds_alternative<KannalaBrandt>(camera.lens)) {
    max_chord_error_px_ = kMaxFisheyeChordErrorPx;
  }
  const Eigen::Array2d low(canvas.left - 0.5, canvas.top - 0.5);
  const Eigen::Array2d high(canvas.right - 0.5, canvas.bottom - 0.5);
  fold_radius_ = fold_radius(camera.lens, farthest_normalised(camera, canvas));
  min_normalised_.setConstant(std::numeric_limits<double>::infinity());
  max_normalised_ = -min_normalised_;
  constexpr int kStepsPerSide = 64;
  const auto extend = [&](double x, double y) {
    const auto seen = normalised_from_pixel(camera_, {x, y});
    const Eigen::Vector2d all(fold_radius_, fold_radius_);
    min_normalised_ = min_normalised_.cwiseMin(seen ? *seen : -all);
    max_normalised_ = max_normalised_.cwiseMax(seen ? *seen : all);
  };
  for (int i = 0; i <= kStepsPerSide; ++i) {
    const Eigen::Array2d at = low + (high - low) * i / kStepsPerSide;
    extend(at.x(), low.y());
    extend(at.x(), high.y());
    extend(low.x(), at.y());
    extend(high.x(), at.y());
  }
  // The border's curve between the steps.
  const Eigen::Vector2d margin = 0.02 * (max_normalised_ - min_normalised_);
  min_normalised_ -= margin;
  max_normalised_ += margin;
}

Eigen::Vector2d Screen::normalised(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d straight((pixel.x() - camera_.cx_px) / camera_.fx_px,
                                 (pixel.y() - camera_.cy_px) / camera_.fy_px);
  if (is_straight(camera_)) return straight;
  return normalised_from_pixel(camera_, pixel).value_or(straight);
}

Screen::LensPoint Screen::add_bent_point(const Eigen::Vector2d& normalised, double nearness,
                                         ScreenMesh& out) const {
  const Eigen::Vector2d pixel = pixel_from_normalised(camera_, normalised);
  out.points.push_back({pixel.x(), pixel.y(), nearness});
  return {normalised, pixel, nearness, static_cast<uint32_t>(out.points.size() - 1)};
}

double Screen::chord_error_px(const LensPoint& a, const LensPoint& b) const {
  // In one order whatever the triangle, so that neighbours agree on where an edge is cut.
  const bool is_ordered =
      std::pair(a.normalised.x(), a.normalised.y()) < std::pair(b.normalised.x(), b.normalised.y());
  const LensPoint& from = is_ordered ? a : b;
  const LensPoint& to = is_ordered ? b : a;
  double worst2 = 0;
  for (const double t : {0.25, 0.5, 0.75}) {
    const Eigen::Vector2d on_edge = from.normalised + t * (to.normalised - from.normalised);
    const Eigen::Vector2d on_chord = from.pixel + t * (to.pixel - from.pixel);
    worst2 = std::max(worst2, (pixel_from_normalised(camera_, on_edge) - on_chord).squaredNorm());
  }
  return std::sqrt(worst2);
}

// NOLINTNEXTLINE(misc-no-recursion): bounded by kMaxCuts.
void Screen::append_bent(const LensPoint& a, const LensPoint& b, const LensPoint& c, uint32_t id,
                         int depth, ScreenMesh& out) const {
  const Eigen::Vector2d low = a.normalised.cwiseMin(b.normalised).cwiseMin(c.normalised);
  const Eigen::Vector2d high = a.normalised.cwiseMax(b.normalised).cwiseMax(c.normalised);
  if ((low.array() > max_normalised_.array()).any() ||
      (high.array() < min_normalised_.array()).any()) {
    return;
  }
  const Eigen::Vector2d nearest = Eigen::Vector2d::Zero().cwiseMax(low).cwiseMin(high);
  if (nearest.norm() >= fold_radius_) return;
  const double errors[3] = {chord_error_px(a, b), chord_error_px(b, c), chord_error_px(c, a)};
  const int worst = static_cast<int>(std::max_element(errors, errors + 3) - errors);
  if (errors[worst] <= max_chord_error_px_ || depth == kMaxCuts) {
    for (const LensPoint* p : {&a, &b, &c}) {
      if (p->normalised.norm() >= fold_radius_) return;
    }
    out.triangles.push_back({{a.index, b.index, c.index}, id});
    return;
  }
  const LensPoint* p[3] = {&a, &b, &c};
  const LensPoint& from = *p[worst];
  const LensPoint& to = *p[(worst + 1) % 3];
  const LensPoint& opposite = *p[(worst + 2) % 3];
  // Nearness, 1/z, is linear in normalised coordinates.
  const LensPoint middle =
      add_bent_point((from.normalised + to.normalised) / 2, (from.nearness + to.nearness) / 2, out);
  append_bent(from, middle, opposite, id, depth + 1, out);
  append_bent(middle, to, opposite, id, depth + 1, out);
}

// Four times what the canvas shows on either side, or what the lens may show of it.
ViewPyramid Screen::pyramid(double near_m) const {
  if (!is_straight(camera_)) return {near_m, min_normalised_, max_normalised_};
  constexpr double kAround = 4;
  const Eigen::Array2d focal(camera_.fx_px, camera_.fy_px);
  const Eigen::Array2d centre(camera_.cx_px, camera_.cy_px);
  const Eigen::Array2d size(canvas_.width(), canvas_.height());
  const Eigen::Array2d corner(canvas_.left, canvas_.top);
  return {near_m, ((corner - kAround * size - centre) / focal).matrix(),
          ((corner + (1 + kAround) * size - centre) / focal).matrix()};
}

void Screen::append_cut(const std::array<Eigen::Vector3d, 3>& corners, double near_m, uint32_t id,
                        ScreenMesh& out) const {
  const std::vector<Eigen::Vector3d> polygon = clipped(corners, pyramid(near_m));
  const auto nearness = [&](const Eigen::Vector3d& x) { return reference_m_ / x.z() - 1; };
  const bool is_bent = !is_straight(camera_);
  const auto first = static_cast<uint32_t>(out.points.size());
  std::vector<LensPoint> bent;
  for (const Eigen::Vector3d& x : polygon) {
    if (is_bent) {
      bent.push_back(add_bent_point(x.head<2>() / x.z(), nearness(x), out));
    } else {
      out.points.push_back({camera_.fx_px * x.x() / x.z() + camera_.cx_px,
                            camera_.fy_px * x.y() / x.z() + camera_.cy_px, nearness(x)});
    }
  }
  for (uint32_t i = 2; i < polygon.size(); ++i) {
    if (is_bent) {
      append_bent(bent[0], bent[i - 1], bent[i], id, 0, out);
    } else {
      out.triangles.push_back({{first, first + i - 1, first + i}, id});
    }
  }
}

void Screen::append(const Mesh& mesh, const Pose& cam_from_mesh, uint32_t first_id,
                    ScreenMesh& out) const {
  const bool is_bent = !is_straight(camera_);
  const auto first = static_cast<uint32_t>(out.points.size());
  // Of the first body alone: to reserve for each would copy all before it each time.
  if (out.points.empty()) out.points.reserve(mesh.vertices.size());
  std::vector<LensPoint> bent;
  if (is_bent) bent.reserve(mesh.vertices.size());
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3d x_in_cam = cam_from_mesh * vertex;
    nearest = std::min(nearest, x_in_cam.z());
    farthest = std::max(farthest, x_in_cam.z());
    const double inverse_z = 1 / x_in_cam.z();
    const double nearness = reference_m_ * inverse_z - 1;
    if (is_bent) {
      bent.push_back(add_bent_point(x_in_cam.head<2>() * inverse_z, nearness, out));
    } else {
      out.points.push_back({camera_.fx_px * x_in_cam.x() * inverse_z + camera_.cx_px,
                            camera_.fy_px * x_in_cam.y() * inverse_z + camera_.cy_px, nearness});
    }
  }
  if (!(farthest > 0)) return;  // all of it is behind the camera
  const double near_m = kNearFraction * farthest;
  const bool is_in_front = nearest >= near_m;
  if (out.triangles.empty()) out.triangles.reserve(mesh.triangles.size());
  const Eigen::Vector3d eye = inverse(cam_from_mesh).translation;
  const std::vector<bool> one_sided = one_sided_parts(mesh);
  uint32_t id = first_id - 1;
  for (const Triangle& triangle : mesh.triangles) {
    ++id;
    const bool is_one_sided = !one_sided.empty() && one_sided[triangle.part];
    if (is_one_sided && is_seen_from_behind(mesh, triangle, eye)) continue;
    const auto [a, b, c] = triangle.vertex;
    if (!is_in_front && has_corner_before(kCutFraction * farthest, mesh, cam_from_mesh, triangle)) {
      append_cut(corners_of(mesh, cam_from_mesh, triangle), near_m, id, out);
    } else if (is_bent) {
      append_bent(bent[a], bent[b], bent[c], id, 0, out);
    } else {
      out.triangles.push_back({{first + a, first + b, first + c}, id});
    }
  }
}

}  // namespace sightline
