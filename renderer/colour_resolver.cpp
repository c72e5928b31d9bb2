// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/colour_resolver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "renderer/opacity.h"
#include "renderer/truth.h"

namespace sightline {
namespace {

constexpr double kShadowTexelPx = 0.1;  // as the image sees it, where Shadow can hold that many

// The shorter half axis of the ellipse that a linear map makes of the unit circle.
double minor_axis(const Eigen::Matrix2d& map) {
  const double squares = map.squaredNorm();
  const double determinant = map.determinant();
  const double root = std::sqrt(std::max(0.0, squares * squares - 4 * determinant * determinant));
  return std::sqrt(std::max(0.0, (squares - root) / 2));
}

}  // namespace

std::unique_ptr<const Shadow> shadow_on(const std::vector<PlacedBody>& bodies, size_t body,
                                        const Scene& scene) {
  if (!scene.light.casts_shadow) return nullptr;
  const double px_per_m = std::max(scene.camera.fx_px, scene.camera.fy_px) /
                          reference_depth_m(*bodies[body].mesh, bodies[body].cam_from_body);
  return std::make_unique<Shadow>(bodies, body, scene.light, kShadowTexelPx / px_per_m,
                                  scene.samples_per_pixel);
}

EnvironmentLight* ColourMemory::environment_of(const Scene& scene) {
  if (!scene.environment.is_there()) return nullptr;
  if (environment == nullptr || environment->panorama() != scene.environment.light) {
    environment = std::make_unique<EnvironmentLight>(scene.environment.light);
  }
  return environment.get();
}

ColourResolver::ColourResolver(const std::vector<PlacedBody>& bodies, const Scene& scene,
                               const Screen& screen, const SamplePattern& pattern,
                               ColourMemory& memory)
    : bodies_(bodies),
      camera_(scene.camera),
      screen_(screen),
      pattern_(pattern),
      memory_(memory),
      sample_levels_(static_cast<float>(std::log2(pattern.count) / 2)),
      groups_(static_cast<size_t>(pattern.count)),
      entry_(groups_.size()),
      order_(groups_.size()),
      x_(groups_.size()),
      y_(groups_.size()),
      u_(groups_.size()),
      v_(groups_.size()),
      of_base_(4 * groups_.size()),
      own_(4 * groups_.size()),
      layer_(groups_.size()) {
  EnvironmentLight* panorama = memory.environment_of(scene);
  for (size_t b = 0; b < bodies.size(); ++b) {
    shaders_.emplace_back(bodies[b], scene, panorama, shadow_on(bodies, b, scene),
                          memory.skies.of(b), memory.textures);
  }
  memory.planes.clear();
  memory.plane_index.assign(bodies.back().first_id + bodies.back().mesh->triangles.size(), 0);
}

void ColourResolver::enter_pixel(int x, int y) {
  centre_ = screen_.normalised({static_cast<double>(x), static_cast<double>(y)});
  per_pixel_ = Eigen::Vector2d(1 / camera_.fx_px, 1 / camera_.fy_px).asDiagonal();
  if (is_straight(camera_)) return;
  // Within a pixel the lens is its derivative: off by some 1e-4 px.
  per_pixel_ = per_pixel_ * lens_jacobian(camera_, centre_).inverse();
}

// Sorts the samples by what they see.
void ColourResolver::group(const uint32_t* ids) {
  known_ = 0;
  size_t last = 0;
  for (int k = 0; k < pattern_.count; ++k) {
    if (known_ == 0 || groups_[last].id != ids[k]) {
      for (last = 0; last < known_ && groups_[last].id != ids[k];) ++last;
      if (last == known_) groups_[known_++] = {ids[k], 0, 0};
    }
    ++groups_[last].count;
    entry_[static_cast<size_t>(k)] = static_cast<int>(last);
  }
  int begin = 0;
  for (size_t g = 0; g < known_; ++g) {
    groups_[g].begin = begin;
    begin += groups_[g].count;
    groups_[g].count = 0;
  }
  for (int k = 0; k < pattern_.count; ++k) {
    Group& group = groups_[static_cast<size_t>(entry_[static_cast<size_t>(k)])];
    order_[static_cast<size_t>(group.begin + group.count++)] = k;
  }
}

Eigen::Vector3d ColourResolver::ray_of(int sample) const {
  const Eigen::Vector2d at =
      centre_ + per_pixel_ * Eigen::Vector2d(pattern_.x[sample], pattern_.y[sample]);
  return {at.x(), at.y(), 1};
}

const SurfacePlane& ColourResolver::plane_of(uint32_t id, const ColourShader& shader,
                                             int triangle) {
  int& index = memory_.plane_index[id];
  if (index == 0) {
    memory_.planes.push_back(shader.plane_of(triangle));
    index = static_cast<int>(memory_.planes.size());
  }
  return memory_.planes[static_cast<size_t>(index - 1)];
}

// Puts what the corners carry into painted_, as the group's samples see it. Returns how fine the
// texture is there, as a pixel sees it.
float ColourResolver::anchor(const Group& group, const SurfacePlane& plane, const Paint& paint) {
  const int first = order_[static_cast<size_t>(group.begin)];
  for (int i = 0; i < group.count; ++i) {
    const int k = order_[static_cast<size_t>(group.begin + i)];
    x_[static_cast<size_t>(i)] = pattern_.x[k] - pattern_.x[first];
    y_[static_cast<size_t>(i)] = pattern_.y[k] - pattern_.y[first];
  }
  const Eigen::Vector3d ray = ray_of(first);
  const Eigen::RowVector3d weights = plane.volumes.colwise().sum();
  const double per_weight = 1 / weights.dot(ray);
  const Eigen::RowVector2d weight_by = weights.head<2>() * per_weight * per_pixel_;
  painted_.count = group.count;
  painted_.x = x_.data();
  painted_.y = y_.data();
  painted_.weight_by_x = static_cast<float>(weight_by.x());
  painted_.weight_by_y = static_cast<float>(weight_by.y());
  const auto carried = [&](const Eigen::RowVector3d& value) -> Carried {
    const double at = value.dot(ray) * per_weight;
    const Eigen::RowVector2d by = value.head<2>() * per_weight * per_pixel_ - at * weight_by;
    return {static_cast<float>(at), static_cast<float>(by.x()), static_cast<float>(by.y())};
  };
  painted_.u = carried(plane.uv.row(0));
  painted_.v = carried(plane.uv.row(1));
  painted_.least_u = static_cast<float>(plane.least_uv.x());
  painted_.least_v = static_cast<float>(plane.least_uv.y());
  painted_.greatest_u = static_cast<float>(plane.greatest_uv.x());
  painted_.greatest_v = static_cast<float>(plane.greatest_uv.y());
  painted_.has_colours = paint.has_colours;
  if (paint.has_colours) {
    for (int c = 0; c < 4; ++c) painted_.colours[c] = carried(plane.colours.row(c));
  }
  uv_ = {std::clamp(painted_.u.at, painted_.least_u, painted_.greatest_u),
         std::clamp(painted_.v.at, painted_.least_v, painted_.greatest_v)};
  if (!paint.has_texture) return 0;
  Eigen::Matrix2d uv_from_px;
  uv_from_px << painted_.u.by_x, painted_.u.by_y, painted_.v.by_x, painted_.v.by_y;
  return std::log2(static_cast<float>(minor_axis(paint.texels_from_uv * uv_from_px)));
}

// The light of each of the group's samples, into of_base_ and own_.
void ColourResolver::light_samples(const Group& group, const ColourShader& shader,
                                   const SurfacePlane& plane, int triangle, float level,
                                   float sky) {
  if (shader.paint(triangle).is_painted) uv_of(painted_, u_.data(), v_.data());
  for (int i = 0; i < group.count; ++i) {
    const int sample = order_[static_cast<size_t>(group.begin + i)];
    const Eigen::Vector2f uv(u_[static_cast<size_t>(i)], v_[static_cast<size_t>(i)]);
    const SurfaceHit hit = shader.hit(plane, triangle, ray_of(sample));
    const ColourLight light = shader.light_at(hit, uv, level, sample, sky);
    Eigen::Map<Eigen::Array4f>(of_base_.data() + 4 * i) = light.of_base;
    Eigen::Map<Eigen::Array4f>(own_.data() + 4 * i) = light.own;
  }
}

// Says in painted_ how the samples of a group look textures up.
void ColourResolver::look_at_textures(const Paint& paint, float level, bool has_detail) {
  // A sample is finer than its pixel. One level alone is read, the nearest: two neighbours' samples
  // differ by a blur of a quarter of a pixel, of which their mean keeps nothing that is seen.
  const float sample_level = level - sample_levels_;
  painted_.base = nullptr;
  if (paint.base != nullptr) {
    base_ = paint.base->lookup(paint.material.base_texture, std::round(sample_level));
    painted_.base = &base_;
  }
  painted_.emission = nullptr;
  if (paint.emissive != nullptr) {
    emission_ = paint.emissive->lookup(paint.material.emissive_texture,
                                       std::round(sample_level + paint.emissive_shift));
    painted_.emission = &emission_;
  }
  Eigen::Map<Eigen::Array4f>(painted_.emitted) = paint.emitted;
  painted_.of_base = of_base_.data();
  painted_.own = own_.data();
  painted_.light_step = has_detail ? 4 : 0;
}

// Lights a group's samples: what painted_, of_base_ and own_ say is theirs.
ColourResolver::Lit ColourResolver::light_group(const Group& group) {
  const size_t b = body_of(bodies_, group.id);
  const ColourShader& shader = shaders_[b];
  const int triangle = static_cast<int>(group.id - bodies_[b].first_id);
  const Paint& paint = shader.paint(triangle);
  const SurfacePlane& plane = plane_of(group.id, shader, triangle);
  const float level = paint.is_painted ? anchor(group, plane, paint) : 0;
  const bool has_detail = shader.has_detail();
  const Eigen::Vector3d ray = ray_of(order_[static_cast<size_t>(group.begin)]);
  const SurfaceHit hit = shader.hit(plane, triangle, ray);
  const float sky = shader.sky_share(hit);
  if (has_detail) {
    light_samples(group, shader, plane, triangle, level, sky);
  } else {
    const ColourLight light = shader.light_at(hit, uv_, level, 0, sky);
    Eigen::Map<Eigen::Array4f>(of_base_.data()) = light.of_base;
    Eigen::Map<Eigen::Array4f>(own_.data()) = light.own;
  }
  const int lights = has_detail ? group.count : 1;
  for (int i = 0; i < lights; ++i) {
    Eigen::Map<Eigen::Array4f> of_base(of_base_.data() + 4 * i);
    Eigen::Map<Eigen::Array4f> own(own_.data() + 4 * i);
    of_base[3] = 1;  // of alpha, which takes no light
    of_base *= paint.factor;
    if (paint.emissive == nullptr) own += paint.emitted;
    own[3] = 0;
  }
  if (paint.is_painted) look_at_textures(paint, level, has_detail);
  return {paint, lights};
}

// Of a surface without texture.
Eigen::Array4f ColourResolver::flat_light(int light) const {
  return (Eigen::Map<const Eigen::Array4f>(of_base_.data() + 4 * light) +
          Eigen::Map<const Eigen::Array4f>(own_.data() + 4 * light))
      .min(1.0f);
}

// Adds the light of a group's samples.
void ColourResolver::add(const Group& group, Eigen::Array4f& sum) {
  const Lit lit = light_group(group);
  if (lit.paint.is_painted) {
    add_painted(painted_, sum.data());
  } else if (lit.lights == 1) {
    sum += flat_light(0) * static_cast<float>(group.count);
  } else {
    for (int i = 0; i < lit.lights; ++i) sum += flat_light(i);
  }
}

bool ColourResolver::is_see_through() const {
  return std::any_of(shaders_.begin(), shaders_.end(),
                     [](const ColourShader& shader) { return shader.is_see_through(); });
}

bool ColourResolver::add_layer(int x, int y, const uint32_t* ids, float* nearness,
                               Eigen::Array4f* samples) {
  enter_pixel(x, y);
  group(ids);
  bool lets_through = false;
  for (size_t g = 0; g < known_; ++g) {
    const Group& seen = groups_[g];
    if (seen.id == 0) continue;
    const Lit lit = light_group(seen);
    if (lit.paint.is_painted) paint_each(painted_, layer_.front().data());
    for (int i = 0; i < seen.count; ++i) {
      const int k = order_[static_cast<size_t>(seen.begin + i)];
      const Eigen::Array4f light = lit.paint.is_painted ? layer_[static_cast<size_t>(i)]
                                                        : flat_light(lit.lights == 1 ? 0 : i);
      const float alpha = opacity(lit.paint.alpha_mode, lit.paint.material.alpha_cutoff, light[3]);
      const float through = samples[k][3];
      samples[k].head<3>() += through * alpha * light.head<3>();
      samples[k][3] = through * (1 - alpha);
      if (samples[k][3] > 0) {
        lets_through = true;
      } else {
        nearness[k] = -std::numeric_limits<float>::max();
      }
    }
  }
  return lets_through;
}

Eigen::Array3f ColourResolver::mean(const Eigen::Array4f* samples,
                                    const Eigen::Array3f& background) const {
  Eigen::Array4d sum = Eigen::Array4d::Zero();
  for (int k = 0; k < pattern_.count; ++k) sum += samples[k].cast<double>();
  return ((sum.head<3>() + sum[3] * background.cast<double>()) / pattern_.count).cast<float>();
}

Eigen::Array3f ColourResolver::mean(int x, int y, const uint32_t* ids,
                                    const Eigen::Array3f& background) {
  enter_pixel(x, y);
  group(ids);
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (size_t g = 0; g < known_; ++g) {
    const Group& seen = groups_[g];
    if (seen.id == 0) {
      sum += seen.count * background.cast<double>();
      continue;
    }
    Eigen::Array4f light = Eigen::Array4f::Zero();
    add(seen, light);
    sum += light.head<3>().cast<double>();
  }
  return (sum / pattern_.count).cast<float>();
}

}  // namespace sightline
