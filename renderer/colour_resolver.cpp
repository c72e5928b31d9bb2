// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/colour_resolver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/LU>

#include "renderer/opacity.h"
#include "renderer/truth.h"

namespace sightline {
namespace {

static_assert(kSampleCounts.back() <= kMostSamples);
constexpr double kShadowTexelPx = 0.1;  // as the image sees it, where Shadow can hold that many

// The square of the shorter half axis of the ellipse that a linear map makes of the unit circle.
float squared_minor_axis(const Eigen::Matrix2f& map) {
  const float squares = map.squaredNorm();
  const float area = 2 * map.determinant();
  const float root = std::sqrt(std::max(0.0f, squares * squares - area * area));
  return squares > 0 ? area * area / (2 * (squares + root)) : 0;
}

// The level whose texels come nearest to `squared`, the square of a length in texels of level 0:
// log2 of the length, rounded.
int nearest_level(float squared) {
  constexpr int kMantissaBits = 23;
  constexpr int kBias = 127;
  return (static_cast<int>(std::bit_cast<uint32_t>(2 * squared) >> kMantissaBits) - kBias) >> 1;
}

// What four functions, linear in a ray, are at one, and their derivatives by the pixel.
struct RayValues {
  Eigen::Vector4d at;
  Eigen::Matrix<double, 4, 2> by;

  RayValues(const Eigen::Matrix<double, 4, 3>& linear, const Eigen::Vector3d& ray,
            const Eigen::Matrix2d& per_pixel)
      : at(linear * ray), by(linear.leftCols<2>() * per_pixel) {}

  // Divided by a weight: by rows, Carried's three numbers.
  Eigen::Matrix<float, 4, 3> over_weight(double per_weight,
                                         const Eigen::RowVector2d& weight_by) const {
    Eigen::Matrix<double, 4, 3> over;
    over.col(0) = at * per_weight;
    over.rightCols<2>() = (by - at * weight_by) * per_weight;
    return over.cast<float>();
  }
};

Carried carried(const Eigen::Matrix<float, 4, 3>& at_and_by, int row) {
  return {at_and_by(row, 0), at_and_by(row, 1), at_and_by(row, 2)};
}

float clamped_at(const Carried& value, float least, float greatest) {
  return std::min(std::max(value.at, least), greatest);
}

// Light as PaintedSamples have it: alpha takes none.
void put_light(const ColourLight& light, const Paint& paint, float* to) {
  const Eigen::Array4f is_colour(1, 1, 1, 0);
  const Eigen::Array4f is_alpha(0, 0, 0, 1);
  Eigen::Map<Eigen::Array4f> of_base(to);
  of_base = (light.of_base * is_colour + is_alpha) * paint.factor;
  Eigen::Map<Eigen::Array4f> own(to + 4);
  if (paint.emissive == nullptr) {
    own = (light.own + paint.emitted) * is_colour;
  } else {
    own = light.own * is_colour;
  }
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
      groups_(static_cast<size_t>(pattern.count)),
      rest_(groups_.size()),
      light_(kLightNumbers * (groups_.size() + kSpareSamples)),
      run_(groups_.size()),
      layer_(groups_.size()) {
  for (Order* order : {&as_drawn_, &by_group_}) {
    order->sample.resize(groups_.size());
    order->x.resize(groups_.size() + kSpareSamples);
    order->y.resize(groups_.size() + kSpareSamples);
  }
  std::iota(as_drawn_.sample.begin(), as_drawn_.sample.end(), 0);
  std::copy(pattern.x.begin(), pattern.x.end(), as_drawn_.x.begin());
  std::copy(pattern.y.begin(), pattern.y.end(), as_drawn_.y.begin());
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
  const auto count = static_cast<size_t>(pattern_.count);
  uint32_t differs = 0;
  for (size_t k = 0; k < count; ++k) differs |= ids[k] ^ ids[0];
  if (differs == 0) {
    groups_[0] = {ids[0], 0, pattern_.count};
    known_ = 1;
    order_ = &as_drawn_;
    return;
  }
  known_ = 0;
  size_t placed = 0;
  std::copy(as_drawn_.sample.begin(), as_drawn_.sample.end(), rest_.begin());
  for (size_t left = count; left > 0; ++known_) {
    const uint32_t id = ids[rest_[0]];
    const size_t begin = placed;
    const size_t of_before = left;
    left = 0;
    // Both places are written, and what is right of them stays: there is nothing to guess.
    for (size_t i = 0; i < of_before; ++i) {
      const int sample = rest_[i];
      const bool is_one = ids[sample] == id;
      by_group_.sample[placed] = sample;
      rest_[left] = sample;
      placed += is_one ? 1 : 0;
      left += is_one ? 0 : 1;
    }
    groups_[known_] = {id, static_cast<int>(begin), static_cast<int>(placed - begin)};
  }
  for (size_t i = 0; i < count; ++i) {
    by_group_.x[i] = pattern_.x[static_cast<size_t>(by_group_.sample[i])];
    by_group_.y[i] = pattern_.y[static_cast<size_t>(by_group_.sample[i])];
  }
  order_ = &by_group_;
}

int ColourResolver::first_sample(const Group& group) const {
  return order_->sample[static_cast<size_t>(group.begin)];
}

Eigen::Vector3d ColourResolver::ray_of(int sample) const {
  const Eigen::Vector2d at =
      centre_ + per_pixel_ * Eigen::Vector2d(pattern_.x[sample], pattern_.y[sample]);
  return {at.x(), at.y(), 1};
}

ColourResolver::Surface ColourResolver::surface_of(const Group& group) const {
  const size_t b = body_of(bodies_, group.id);
  const int triangle = static_cast<int>(group.id - bodies_[b].first_id);
  return {shaders_[b], shaders_[b].paint(triangle), triangle};
}

const SurfacePlane& ColourResolver::plane_of(uint32_t id, const Surface& surface) {
  int& index = memory_.plane_index[id];
  if (index == 0) {
    memory_.planes.push_back(surface.shader.plane_of(surface.triangle));
    index = static_cast<int>(memory_.planes.size());
  }
  return memory_.planes[static_cast<size_t>(index - 1)];
}

// Says in `painted` what the corners carry, as the group's samples see it. Returns the level of
// the texture that a pixel sees, where light_at() wants it.
float ColourResolver::anchor(const Group& group, const SurfacePlane& plane, const Paint& paint,
                             const Eigen::Vector3d& ray, PaintedGroup& painted) const {
  painted.count = group.count;
  painted.anchor_x = order_->x[static_cast<size_t>(group.begin)];
  painted.anchor_y = order_->y[static_cast<size_t>(group.begin)];
  const RayValues sum_and_uv(plane.sum_and_uv, ray, per_pixel_);
  const double per_weight = 1 / sum_and_uv.at[0];
  const Eigen::RowVector2d weight_by = sum_and_uv.by.row(0) * per_weight;
  painted.weight_by_x = static_cast<float>(weight_by.x());
  painted.weight_by_y = static_cast<float>(weight_by.y());
  const Eigen::Matrix<float, 4, 3> uv = sum_and_uv.over_weight(per_weight, weight_by);
  painted.u = carried(uv, 1);
  painted.v = carried(uv, 2);
  painted.least_u = plane.least_uv.x();
  painted.least_v = plane.least_uv.y();
  painted.greatest_u = plane.greatest_uv.x();
  painted.greatest_v = plane.greatest_uv.y();
  if (paint.has_colours) {
    const Eigen::Matrix<float, 4, 3> colours =
        RayValues(plane.colours, ray, per_pixel_).over_weight(per_weight, weight_by);
    for (int c = 0; c < 4; ++c) painted.colours[c] = carried(colours, c);
  }
  if (!paint.has_texture) return 0;
  const float squared = squared_minor_axis(paint.texels_from_uv * uv.block<2, 2>(1, 1));
  // A sample is finer than its pixel. One level alone is read, the nearest: two neighbours' samples
  // differ by a blur of a quarter of a pixel, of which their mean keeps nothing that is seen.
  const float of_sample = squared / static_cast<float>(pattern_.count);
  if (paint.base != nullptr) {
    painted.base = paint.base->level(paint.material.base_texture, nearest_level(of_sample));
  }
  if (paint.emissive != nullptr) {
    painted.emission = paint.emissive->level(paint.material.emissive_texture,
                                             nearest_level(of_sample * paint.emissive_scale));
  }
  return paint.wants_level ? std::log2(squared) / 2 : 0;
}

// The light of each of the group's samples, the first of which is at `place` of its run.
void ColourResolver::light_samples(const Group& group, const Surface& surface,
                                   const SurfacePlane& plane, size_t place, float level,
                                   float sky) {
  for (size_t i = 0; i < static_cast<size_t>(group.count); ++i) {
    const size_t at = static_cast<size_t>(group.begin) + i;
    const int sample = order_->sample[at];
    const SurfaceHit hit = surface.shader.hit(plane, surface.triangle, ray_of(sample));
    const Eigen::Vector2f uv(placed_.u[place + i], placed_.v[place + i]);
    const ColourLight light = surface.shader.light_at(hit, uv, level, sample, sky);
    put_light(light, surface.paint, light_.data() + kLightNumbers * at);
  }
}

// Lights a group's samples and, where they are painted, takes them into the run.
void ColourResolver::light_group(const Group& group, const Surface& surface, PaintedSamples& run) {
  const SurfacePlane& plane = plane_of(group.id, surface);
  const Eigen::Vector3d ray = ray_of(first_sample(group));
  const auto place = static_cast<size_t>(run.count);
  PaintedGroup& painted = run_[static_cast<size_t>(run.group_count)];
  float level = 0;
  if (surface.paint.is_painted) {
    level = anchor(group, plane, surface.paint, ray, painted);
    place_group(run);
  }
  const SurfaceHit hit = surface.shader.hit(plane, surface.triangle, ray);
  const float sky = surface.shader.sky_share(hit);
  if (surface.shader.has_detail()) {
    light_samples(group, surface, plane, place, level, sky);
    return;
  }
  const Eigen::Vector2f uv(clamped_at(painted.u, painted.least_u, painted.greatest_u),
                           clamped_at(painted.v, painted.least_v, painted.greatest_v));
  put_light(surface.shader.light_at(hit, uv, level, 0, sky), surface.paint,
            light_.data() + kLightNumbers * static_cast<size_t>(group.begin));
}

// That of a group's sample, of a surface without texture.
Eigen::Array4f ColourResolver::flat_light(const Group& group, const Surface& surface,
                                          int sample) const {
  const int at = group.begin + (surface.shader.has_detail() ? sample : 0);
  const float* light = light_.data() + ptrdiff_t{kLightNumbers} * at;
  return (Eigen::Map<const Eigen::Array4f>(light) + Eigen::Map<const Eigen::Array4f>(light + 4))
      .min(1.0f);
}

void ColourResolver::add_flat(const Group& group, const Surface& surface,
                              Eigen::Array4f& sum) const {
  if (!surface.shader.has_detail()) {
    sum += flat_light(group, surface, 0) * static_cast<float>(group.count);
    return;
  }
  for (int i = 0; i < group.count; ++i) sum += flat_light(group, surface, i);
}

// That begins with a group's samples.
PaintedSamples ColourResolver::empty_run(const Surface& surface, const Group& first) {
  const Paint& paint = surface.paint;
  PaintedSamples run;
  run.groups = run_.data();
  run.x = order_->x.data() + first.begin;
  run.y = order_->y.data() + first.begin;
  run.light = light_.data() + kLightNumbers * static_cast<size_t>(first.begin);
  run.has_light_each = surface.shader.has_detail();
  run.has_colours = paint.has_colours;
  if (paint.base != nullptr) run.base = &paint.base_map;
  if (paint.emissive != nullptr) run.emission = &paint.emissive_map;
  run.emitted = paint.emitted.data();
  run.placed = &placed_;
  return run;
}

// Adds the light of a group's samples and, if it is painted, of those after it that see the same
// paint. Returns the first group that is left.
size_t ColourResolver::add_run(size_t first, Eigen::Array4f& sum) {
  const Group& group = groups_[first];
  const Surface surface = surface_of(group);
  PaintedSamples run = empty_run(surface, group);
  light_group(group, surface, run);
  if (!surface.paint.is_painted) {
    add_flat(group, surface, sum);
    return first + 1;
  }
  size_t end = first + 1;
  for (; end < known_ && groups_[end].id != 0; ++end) {
    const Surface next = surface_of(groups_[end]);
    if (&next.paint != &surface.paint) break;
    light_group(groups_[end], next, run);
  }
  add_painted(run, sum.data());
  return end;
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
    const Surface surface = surface_of(seen);
    const Paint& paint = surface.paint;
    PaintedSamples run = empty_run(surface, seen);
    light_group(seen, surface, run);
    if (paint.is_painted) paint_each(run, layer_.front().data());
    for (int i = 0; i < seen.count; ++i) {
      const int k = order_->sample[static_cast<size_t>(seen.begin + i)];
      const Eigen::Array4f light =
          paint.is_painted ? layer_[static_cast<size_t>(i)] : flat_light(seen, surface, i);
      const float alpha = opacity(paint.alpha_mode, paint.material.alpha_cutoff, light[3]);
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
  for (size_t g = 0; g < known_;) {
    if (groups_[g].id == 0) {
      sum += groups_[g].count * background.cast<double>();
      ++g;
      continue;
    }
    Eigen::Array4f light = Eigen::Array4f::Zero();
    g = add_run(g, light);
    sum += light.head<3>().cast<double>();
  }
  return (sum / pattern_.count).cast<float>();
}

}  // namespace sightline
