// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/shading.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "pose/angles.h"

namespace sightline {
namespace {

// Of a disc's points each shadow may have texels so much larger: their roundings average out.
constexpr double kDiscTexels = 4;

// Rows: two axes across the light's rays, then the direction to the light.
Eigen::Matrix3d light_axes(const Eigen::Vector3d& to_light) {
  Eigen::Matrix3d axes;
  const Eigen::Vector3d across = to_light.unitOrthogonal();
  axes << across.transpose(), to_light.cross(across).transpose(), to_light.transpose();
  return axes;
}

// Directions to points of the light's disc, which stand for equal parts of it.
std::vector<Eigen::Vector3d> points_of_disc(const Light& light, int count) {
  constexpr double kGoldenAngle = 2.39996322972865332;
  const Eigen::Matrix3d axes = light_axes(light.to_light_in_cam);
  const double rim = std::tan(light.radius_deg * kDegree);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double radius = rim * std::sqrt((i + 0.5) / count);
    const Eigen::Vector3d across(radius * std::cos(i * kGoldenAngle),
                                 radius * std::sin(i * kGoldenAngle), 1);
    points.push_back((axes.transpose() * across).normalized());
  }
  return points;
}

}  // namespace

Eigen::Vector3d winding_normal(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
  return (mesh.vertices[triangle.vertex[1]] - a).cross(mesh.vertices[triangle.vertex[2]] - a);
}

RayHits::RayHits(const PlacedBody& body)
    : body_(body),
      body_from_cam_(body.cam_from_body.rotation.transpose()),
      eye_in_body_(inverse(body.cam_from_body).translation) {}

SurfacePoint RayHits::on(int triangle, const Eigen::Vector2d& normalised) const {
  const Mesh& mesh = *body_.mesh;
  const auto& corner = mesh.triangles[triangle].vertex;
  const Eigen::Vector3d ray = body_from_cam_ * Eigen::Vector3d(normalised.x(), normalised.y(), 1);
  const Eigen::Vector3d a = mesh.vertices[corner[0]] - eye_in_body_;
  const Eigen::Vector3d b = mesh.vertices[corner[1]] - eye_in_body_;
  const Eigen::Vector3d c = mesh.vertices[corner[2]] - eye_in_body_;
  // The volumes that the ray spans with the edges; their sum is the winding normal along the ray.
  const Eigen::Vector3d across = c.cross(ray);
  Eigen::Vector3d volumes(b.dot(across), -a.dot(across), a.cross(b).dot(ray));
  SurfacePoint point;
  point.triangle = triangle;
  point.is_front = volumes.sum() < 0;
  if (point.is_front) volumes = -volumes;
  volumes = volumes.cwiseMax(0);
  const double sum = volumes.sum();
  // Seen exactly edge-on there is nothing to divide by.
  point.weights = sum > 0 ? Eigen::Vector3d(volumes / sum) : Eigen::Vector3d::Constant(1.0 / 3);
  return point;
}

double RayHits::depth_m(const SurfacePoint& point) const {
  return (body_.cam_from_body * in_body(point)).z();
}

Eigen::Vector3d RayHits::in_body(const SurfacePoint& point) const {
  const Mesh& mesh = *body_.mesh;
  const auto& corner = mesh.triangles[point.triangle].vertex;
  return point.weights[0] * mesh.vertices[corner[0]] + point.weights[1] * mesh.vertices[corner[1]] +
         point.weights[2] * mesh.vertices[corner[2]];
}

ShadowMap::ShadowMap(const std::vector<PlacedBody>& bodies, size_t receiver,
                     const Eigen::Vector3d& to_light_in_cam, double texel_m, int max_texels) {
  const Eigen::Matrix3d light_from_cam = light_axes(to_light_in_cam);
  const PlacedBody& body = bodies[receiver];
  light_from_body_ = light_from_cam * body.cam_from_body.rotation;
  Eigen::AlignedBox3d extent;
  for (const Eigen::Vector3d& vertex : body.mesh->vertices)
    extent.extend(light_from_body_ * vertex);
  const double size_m = extent.sizes().head<2>().maxCoeff();
  texel_m_ = std::max(texel_m, size_m / (max_texels - 2));
  if (!(texel_m_ > 0)) texel_m_ = 1;
  side_ = std::min(static_cast<int>(std::ceil(size_m / texel_m_)) + 2, max_texels);
  origin_ = extent.min();
  // Depths are written in single precision.
  double depth_m = extent.sizes().z();
  const PixelBox box{0, 0, side_, side_};
  std::vector<ScreenTriangle> triangles;
  for (const PlacedBody& caster : bodies) {
    const Eigen::Matrix3d turn = light_from_cam * caster.cam_from_body.rotation;
    const Eigen::Vector3d shift =
        light_from_cam * (caster.cam_from_body.translation - body.cam_from_body.translation) -
        origin_;
    std::vector<ScreenPoint> points;
    for (const Eigen::Vector3d& vertex : caster.mesh->vertices) {
      const Eigen::Vector3d x = turn * vertex + shift;
      points.push_back({x.x() / texel_m_, x.y() / texel_m_, x.z()});
      depth_m = std::max(depth_m, std::abs(x.z()));
    }
    for (const Triangle& triangle : caster.mesh->triangles) {
      const auto [a, b, c] = triangle.vertex;
      triangles.push_back({{points[a], points[b], points[c]}, 1});
    }
  }
  tolerance_m_ = 4 * std::numeric_limits<float>::epsilon() * depth_m + 1e-5 * size_m;
  nearest_.assign(static_cast<size_t>(side_) * side_, -std::numeric_limits<float>::max());
  VisibleStrip strip;
  const std::unique_ptr<SamplePainter> painter = make_own_painter();
  painter->start(triangles, box, sample_pattern(1));
  while (painter->next(strip)) {
    const size_t first = static_cast<size_t>(strip.box.top) * side_;
    const size_t count = static_cast<size_t>(strip.box.height()) * side_;
    for (size_t i = 0; i < count; ++i) {
      if (strip.is_touched[i]) nearest_[first + i] = strip.nearness[i];
    }
  }
}

bool ShadowMap::is_lit(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
  const Eigen::Vector3d at = light_from_body_ * x - origin_;
  const int column = static_cast<int>(std::lround(at.x() / texel_m_));
  const int row = static_cast<int>(std::lround(at.y() / texel_m_));
  if (column < 0 || row < 0 || column >= side_ || row >= side_) return true;
  const Eigen::Vector3d n = light_from_body_ * normal;
  // Edge-on to the light a plane has no depth at the texel's centre, and takes no light.
  if (n.z() == 0) return true;
  const double plane_m =
      at.z() - (n.x() * (column * texel_m_ - at.x()) + n.y() * (row * texel_m_ - at.y())) / n.z();
  return nearest_[static_cast<size_t>(row) * side_ + column] <= plane_m + tolerance_m_;
}

Shadow::Shadow(const std::vector<PlacedBody>& bodies, size_t receiver, const Light& light,
               double texel_m, int samples_per_pixel)
    : samples_(samples_per_pixel) {
  if (!(light.radius_deg > 0)) {
    maps_.emplace_back(bodies, receiver, light.to_light_in_cam, texel_m, kMaxTexels);
    return;
  }
  for (const Eigen::Vector3d& to_point : points_of_disc(light, kDiscPoints)) {
    maps_.emplace_back(bodies, receiver, to_point, kDiscTexels * texel_m, kMaxDiscTexels);
  }
}

double Shadow::lit_share(const Eigen::Vector3d& x, const Eigen::Vector3d& normal,
                         int sample) const {
  if (maps_.size() == 1) return maps_.front().is_lit(x, normal) ? 1 : 0;
  const int points = static_cast<int>(maps_.size());
  int lit = 0, asked = 0;
  for (int i = sample % points; asked == 0 || i < points; i += samples_, ++asked) {
    if (maps_[static_cast<size_t>(i)].is_lit(x, normal)) ++lit;
  }
  return static_cast<double>(lit) / asked;
}

Shader::Shader(const PlacedBody& body, const Light& light, std::unique_ptr<const Shadow> shadow)
    : hits_(body),
      light_(light),
      to_light_(body.cam_from_body.rotation.transpose() * light.to_light_in_cam),
      to_second_(body.cam_from_body.rotation.transpose() * light.to_second_in_cam),
      shadow_(std::move(shadow)) {}

bool Shader::has_detail() const {
  return shadow_ != nullptr || light_.specular > 0 || hits_.body().stripe_contrast > 0;
}

double Shader::grey(const SurfacePoint& point, int sample) const {
  const PlacedBody& body = hits_.body();
  const Mesh& mesh = *body.mesh;
  const Triangle& triangle = mesh.triangles[point.triangle];
  Eigen::Vector3d normal = point.weights[0] * triangle.normal[0] +
                           point.weights[1] * triangle.normal[1] +
                           point.weights[2] * triangle.normal[2];
  // A back face is the inside of an open mesh: it is lit as a sheet of paper is.
  if (!point.is_front) normal = -normal;
  const double length = normal.norm();
  double towards_light = length > 0 ? normal.dot(to_light_) / length : 0;
  double even = light_.ambient;
  if (light_.second > 0 && length > 0) {
    even += light_.second * std::max(0.0, normal.dot(to_second_) / length);
  }
  double albedo = mesh.parts[triangle.part].albedo;
  if (!has_detail()) {
    return albedo * (even + light_.directional * std::max(0.0, towards_light));
  }
  const Eigen::Vector3d x = hits_.in_body(point);
  if (body.stripe_contrast > 0 &&
      static_cast<int64_t>(std::floor(x.x() / body.stripe_m)) % 2 != 0) {
    albedo *= 1 - body.stripe_contrast;
  }
  double lit = towards_light > 0 ? 1 : 0;
  if (lit > 0 && shadow_ != nullptr) {
    lit = shadow_->lit_share(x, winding_normal(mesh, triangle), sample);
  }
  if (!(lit > 0)) return albedo * even;
  double grey = albedo * (even + light_.directional * towards_light * lit);
  if (light_.specular > 0) {
    const Eigen::Vector3d half_way = (hits_.eye_in_body() - x).normalized() + to_light_;
    const double cosine = std::max(0.0, normal.dot(half_way) / (length * half_way.norm()));
    grey += lit * light_.specular * std::pow(cosine, light_.shininess);
  }
  return grey;
}

}  // namespace sightline
