// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/shading.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "scenes/mesh/mesh_soup.h"

namespace sightline {
namespace {

// Of a disc the shadow maps may have texels so much larger: the roundings of a wide one's average
// out, and rays find the outlines of a narrow one.
constexpr double kDiscTexels = 4;

}  // namespace

Eigen::Vector3d winding_normal(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
  return (mesh.vertices[triangle.vertex[1]] - a).cross(mesh.vertices[triangle.vertex[2]] - a);
}

Eigen::Vector3d facing_normal(const Mesh& mesh, const Triangle& triangle, bool is_front) {
  const Eigen::Vector3d normal = winding_normal(mesh, triangle);
  return is_front ? normal : Eigen::Vector3d(-normal);
}

Eigen::Vector3d lit_normal(const Mesh& mesh, const SurfacePoint& point) {
  const auto& corners = mesh.triangles[point.triangle].normal;
  const Eigen::Vector3d normal =
      point.weights[0] * corners[0] + point.weights[1] * corners[1] + point.weights[2] * corners[2];
  // A back face is the inside of an open mesh: it is lit as a sheet of paper is.
  return point.is_front ? normal : Eigen::Vector3d(-normal);
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
  const Eigen::Vector3d across = c.cross(ray);
  return surface_point(triangle, {b.dot(across), -a.dot(across), a.cross(b).dot(ray)});
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

double grey_of(const Eigen::Vector3d& light) {
  // Of white all of it: the shares add up to 1 but for rounding.
  if (light == Eigen::Vector3d::Ones()) return 1;
  return kLuminanceShares[0] * light[0] + kLuminanceShares[1] * light[1] +
         kLuminanceShares[2] * light[2];
}

Shadow::Shadow(const std::vector<PlacedBody>& bodies, size_t receiver, const Light& light,
               double texel_m, int samples_per_pixel)
    : samples_(samples_per_pixel) {
  const bool has_disc = light.radius_deg > 0;
  const Eigen::Vector3d& to_middle = light.to_light_in_cam;
  const bool is_narrow =
      has_disc && DiscShadow::is_narrow(bodies, receiver, to_middle, light.radius_deg);
  if (!has_disc) {
    maps_.emplace_back(bodies, receiver, to_middle, texel_m, kMaxTexels);
    return;
  }
  points_ = kDiscPoints;
  const std::vector<Eigen::Vector3d> points =
      points_of_disc(to_middle, light.radius_deg, kDiscPoints);
  if (is_narrow) {
    maps_.emplace_back(bodies, receiver, to_middle, kDiscTexels * texel_m, kMaxDiscTexels);
    disc_.emplace(bodies, receiver, to_middle, light.radius_deg, maps_.front(), points);
    return;
  }
  for (const Eigen::Vector3d& to_point : points) {
    maps_.emplace_back(bodies, receiver, to_point, kDiscTexels * texel_m, kMaxDiscTexels);
  }
}

bool Shadow::is_lit(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int triangle,
                    int point) const {
  return disc_ ? disc_->is_lit(x, triangle, point)
               : maps_[static_cast<size_t>(point)].is_lit(x, normal);
}

double Shadow::lit_share(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int triangle,
                         int sample) const {
  if (points_ == 1) return maps_.front().is_lit(x, normal) ? 1 : 0;
  if (disc_ && !disc_->may_be_soft(x)) {
    // A map as coarse as this takes the foot of something steep for a shadow.
    constexpr double kFootTexels = 8;
    const ShadowMap& map = maps_.front();
    if (map.is_lit(x, normal)) return 1;
    if (map.height_over_m(x) > kFootTexels * map.texel_m()) return 0;
  }
  int lit = 0, asked = 0;
  for (int i = sample % points_; asked == 0 || i < points_; i += samples_, ++asked) {
    if (is_lit(x, normal, triangle, i)) ++lit;
  }
  return static_cast<double>(lit) / asked;
}

Light in_grey(Light light) {
  const double share = grey_of(light.colour);
  light.directional *= share;
  light.specular *= share;
  light.second *= grey_of(light.second_colour);
  light.colour.setOnes();
  light.second_colour.setOnes();
  return light;
}

Shader::Shader(const PlacedBody& body, const Light& light, std::unique_ptr<const Shadow> shadow,
               BodySky* sky)
    : hits_(body),
      light_(in_grey(light)),
      to_light_(body.cam_from_body.rotation.transpose() * light.to_light_in_cam),
      to_second_(body.cam_from_body.rotation.transpose() * light.to_second_in_cam),
      shadow_(std::move(shadow)),
      sky_(sky) {}

bool Shader::has_detail() const {
  return shadow_ != nullptr || light_.specular > 0 || hits_.body().stripe_contrast > 0;
}

double Shader::sky_share(const SurfacePoint& point) const {
  if (sky_ == nullptr) return 1;
  const Mesh& mesh = *hits_.body().mesh;
  const Triangle& triangle = mesh.triangles[point.triangle];
  return sky_->share(hits_.in_body(point), facing_normal(mesh, triangle, point.is_front),
                     lit_normal(mesh, point));
}

double Shader::grey(const SurfacePoint& point, int sample, double sky) const {
  const PlacedBody& body = hits_.body();
  const Mesh& mesh = *body.mesh;
  const Triangle& triangle = mesh.triangles[point.triangle];
  const Eigen::Vector3d normal = lit_normal(mesh, point);
  const double length = normal.norm();
  double towards_light = length > 0 ? normal.dot(to_light_) / length : 0;
  double even = light_.ambient * sky;
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
    lit = shadow_->lit_share(x, winding_normal(mesh, triangle), point.triangle, sample);
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
