// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/colour_resolver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "renderer/truth.h"

namespace sightline {
namespace {

constexpr double kShadowTexelPx = 0.1;  // as the image sees it, where ShadowMap can hold that many

// The shorter half axis of the ellipse that a linear map makes of the unit circle.
double minor_axis(const Eigen::Matrix2d& map) {
  const double squares = map.squaredNorm();
  const double determinant = map.determinant();
  const double root = std::sqrt(std::max(0.0, squares * squares - 4 * determinant * determinant));
  return std::sqrt(std::max(0.0, (squares - root) / 2));
}

}  // namespace

std::unique_ptr<const ShadowMap> shadow_on(const std::vector<PlacedBody>& bodies, size_t body,
                                           const Scene& scene) {
  if (!scene.light.casts_shadow) return nullptr;
  const double px_per_m =
      std::max(scene.camera.fx_px, scene.camera.fy_px) / bodies[body].cam_from_body.translation.z();
  return std::make_unique<ShadowMap>(bodies, body, scene.light.to_light_in_cam,
                                     kShadowTexelPx / px_per_m);
}

ColourResolver::ColourResolver(const std::vector<PlacedBody>& bodies, const Scene& scene,
                               const Screen& screen, const SamplePattern& pattern,
                               TextureCache& textures)
    : bodies_(bodies),
      camera_(scene.camera),
      screen_(screen),
      pattern_(pattern),
      sample_levels_(static_cast<float>(std::log2(pattern.count) / 2)),
      seen_(static_cast<size_t>(pattern.count)) {
  const bool is_grey = scene.colouring.mode == ColourMode::kGrey;
  for (size_t b = 0; b < bodies.size(); ++b) {
    shaders_.emplace_back(bodies[b], scene.light, is_grey, scene.colouring.draws_textures,
                          shadow_on(bodies, b, scene), textures);
  }
}

void ColourResolver::enter_pixel(int x, int y) {
  known_ = 0;
  centre_ = screen_.normalised({static_cast<double>(x), static_cast<double>(y)});
  per_pixel_ = Eigen::Vector2d(1 / camera_.fx_px, 1 / camera_.fy_px).asDiagonal();
  if (is_straight(camera_)) return;
  // Within a pixel the lens is its derivative: off by some 1e-4 px.
  per_pixel_ = per_pixel_ * lens_jacobian(camera_, centre_).inverse();
}

const CarriedValues& ColourResolver::carried_by(uint32_t id, const ColourShader& shader,
                                                int triangle) {
  const auto known = carried_.find(id);
  if (known != carried_.end()) return known->second;
  return carried_.emplace(id, shader.carried(triangle)).first->second;
}

// What a pixel's neighbourhood sees of what the triangle carries, and how fine its texture is
// there.
void ColourResolver::carry(Seen& seen, int sample) {
  const CarriedValues& values = carried_by(seen.id, *seen.shader, seen.triangle);
  Eigen::Matrix3d rays;  // at the centre, by x and by y of the offset
  rays << centre_.x(), per_pixel_(0, 0), per_pixel_(0, 1), centre_.y(), per_pixel_(1, 0),
      per_pixel_(1, 1), 1, 0, 0;
  seen.uv = values.uv * rays;
  seen.has_colours = seen.shader->has_colours(seen.triangle);
  if (seen.has_colours) seen.colours = values.colours * rays;
  seen.least_uv = values.least_uv;
  seen.greatest_uv = values.greatest_uv;
  const TextureRef* texture = seen.shader->finest_texture(seen.triangle);
  if (texture == nullptr) return;
  const Eigen::Vector3d at = seen.uv * Eigen::Vector3d(1, pattern_.x[sample], pattern_.y[sample]);
  const Eigen::Vector2d uv = at.head<2>() / at.z();
  const Eigen::Matrix2d uv_from_px =
      (seen.uv.topRightCorner<2, 2>() - uv * seen.uv.bottomRightCorner<1, 2>()) / at.z();
  const auto& m = texture->texture_from_uv;
  Eigen::Matrix2d texture_from_uv;
  texture_from_uv << m[0], m[1], m[3], m[4];
  const Eigen::Vector2d texels = seen.shader->texels(seen.triangle);
  const double footprint = minor_axis(texels.asDiagonal() * texture_from_uv * uv_from_px);
  seen.level = static_cast<float>(std::log2(footprint)) - sample_levels_;
}

ColourResolver::PaintPoint ColourResolver::paint_at(const Seen& seen, int sample) const {
  PaintPoint point;
  if (!seen.is_painted) return point;
  const double x = pattern_.x[sample];
  const double y = pattern_.y[sample];
  const Eigen::Vector3d at = seen.uv.col(0) + seen.uv.col(1) * x + seen.uv.col(2) * y;
  const double per_weight = 1 / at.z();
  // A sample of a lens's chords may lie off the triangle by some 1e-4 px, much seen edge-on.
  const Eigen::Vector2d uv = at.head<2>() * per_weight;
  point.uv = uv.cwiseMax(seen.least_uv).cwiseMin(seen.greatest_uv).cast<float>();
  if (!seen.has_colours) return point;
  const Eigen::Vector3d colour =
      (seen.colours.col(0) + seen.colours.col(1) * x + seen.colours.col(2) * y).head<3>() *
      per_weight;
  point.colour = colour.array().max(0).min(1).cast<float>();
  return point;
}

ColourLight ColourResolver::light_at(const Seen& seen, int sample, const PaintPoint& paint) const {
  const Eigen::Vector2d offset(pattern_.x[sample], pattern_.y[sample]);
  const SurfacePoint point = seen.shader->hits().on(seen.triangle, centre_ + per_pixel_ * offset);
  // Lit once a pixel, a gloss texture is looked up for all of it.
  return seen.shader->light_at(point, paint.uv, seen.level + sample_levels_);
}

// Sees a triangle for the first time in this pixel.
void ColourResolver::meet(uint32_t id, int sample, Seen& seen) {
  const size_t b = body_of(bodies_, id);
  seen.id = id;
  seen.triangle = static_cast<int>(id - bodies_[b].first_id);
  seen.shader = &shaders_[b];
  seen.is_painted = seen.shader->is_painted(seen.triangle);
  seen.has_colours = false;
  seen.emits = seen.shader->emits(seen.triangle);
  seen.level = 0;
  seen.factor = seen.shader->base_factor(seen.triangle).head<3>();
  if (seen.is_painted) carry(seen, sample);
  const PaintPoint paint = paint_at(seen, sample);
  seen.light = light_at(seen, sample, paint);
  seen.is_plain = !seen.is_painted && !seen.shader->has_detail();
  if (seen.is_plain) seen.plain = light_of(seen, seen.light, paint);
}

Eigen::Array3f ColourResolver::light_of(const Seen& seen, const ColourLight& light,
                                        const PaintPoint& paint) const {
  Eigen::Array3f base = seen.factor * paint.colour;
  if (seen.is_painted) {
    base *= seen.shader->texel_at(seen.triangle, paint.uv, seen.level).head<3>();
  }
  Eigen::Array3f sent = base * light.of_base + light.own;
  if (seen.emits) sent += seen.shader->emission_at(seen.triangle, paint.uv, seen.level);
  return sent.min(1.0f);
}

// The entry of a triangle in this pixel; what neighbouring samples see is looked at first.
const ColourResolver::Seen& ColourResolver::entry_of(uint32_t id, int sample) {
  if (known_ > 0 && seen_[last_].id == id) return seen_[last_];
  for (last_ = 0; last_ < known_; ++last_) {
    if (seen_[last_].id == id) return seen_[last_];
  }
  meet(id, sample, seen_[known_]);
  ++known_;
  return seen_[last_];
}

Eigen::Array3f ColourResolver::mean(int x, int y, const uint32_t* ids,
                                    const Eigen::Array3f& background) {
  enter_pixel(x, y);
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (int k = 0; k < pattern_.count; ++k) {
    if (ids[k] == 0) {
      sum += background.cast<double>();
      continue;
    }
    const Seen& seen = entry_of(ids[k], k);
    if (seen.is_plain) {
      sum += seen.plain.cast<double>();
      continue;
    }
    const PaintPoint paint = paint_at(seen, k);
    const bool has_detail = seen.shader->has_detail();
    const ColourLight light = has_detail ? light_at(seen, k, paint) : seen.light;
    sum += light_of(seen, light, paint).cast<double>();
  }
  return (sum / pattern_.count).cast<float>();
}

}  // namespace sightline
