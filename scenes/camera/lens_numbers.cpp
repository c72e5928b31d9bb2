// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/camera/lens_numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

const LensModel& model_named(const char* name) {
  return *find_lens_model(name);
}

// Whether no ray before 90 degrees is seen at a pixel that cannot be undone, rather than two.
bool is_beside_view(const Camera& camera) {
  const auto* const fisheye = std::get_if<KannalaBrandt>(&camera.lens);
  return fisheye != nullptr && fold_angle(*fisheye) >= kMostFisheyeAngle;
}

}  // namespace

std::string allowed_numbers(const LensModel& model) {
  return fmt::format("{} numbers ({})", fmt::join(model.counts, " or "),
                     fmt::join(model.coefficients, ", "));
}

Lens lens_of(const LensModel& model, std::span<const double> coefficients) {
  const std::optional<Lens> lens = make_lens(model, coefficients);
  if (!lens) {
    throw InputError(fmt::format("has {} numbers, must have {} of a {} lens", coefficients.size(),
                                 allowed_numbers(model), model.name));
  }
  for (const double coefficient : coefficients) {
    if (std::isfinite(coefficient)) continue;
    throw InputError(fmt::format("has {}, must have finite numbers", coefficient));
  }
  return *lens;
}

Lens lens_of_opencv(std::span<const double> coefficients) {
  constexpr size_t kBrownConrady = 5, kPrism = 12, kTilt = 14;
  const size_t count = coefficients.size();
  if (count == 0) return {};
  const bool is_known =
      count == 4 || count == kBrownConrady || count == 8 || count == kPrism || count == kTilt;
  if (!is_known) {
    throw InputError(fmt::format(
        "has {} numbers, must have none, 4 or 5 (k1, k2, p1, p2, k3), 8 (and k4, k5, k6), 12 (and "
        "s1, s2, s3, s4) or 14 (and tau_x, tau_y, which must be 0)",
        count));
  }
  const auto is_zero_from = [coefficients](size_t first) {
    return std::all_of(coefficients.begin() + static_cast<std::ptrdiff_t>(first),
                       coefficients.end(), [](double k) { return k == 0; });
  };
  if (count <= kBrownConrady) return lens_of(model_named("brown_conrady"), coefficients);
  if (is_zero_from(kBrownConrady)) {
    return lens_of(model_named("brown_conrady"), coefficients.first(kBrownConrady));
  }
  if (count == kTilt && !is_zero_from(kPrism)) {
    throw InputError("has a tilt of the sensor (tau_x, tau_y), which must be 0");
  }
  return lens_of(model_named("rational"), coefficients.first(std::min(count, kPrism)));
}

std::optional<Eigen::Vector2d> folded_pixel(const Camera& camera) {
  const double right = camera.width_px - 0.5, bottom = camera.height_px - 0.5;
  for (const double u : {-0.5, std::clamp(camera.cx_px, -0.5, right), right}) {
    for (const double v : {-0.5, std::clamp(camera.cy_px, -0.5, bottom), bottom}) {
      if (normalised_from_pixel(camera, {u, v}) || is_beside_view(camera)) continue;
      return Eigen::Vector2d(u, v);
    }
  }
  return std::nullopt;
}

std::string why_folded(const Camera& camera) {
  const auto pixel = folded_pixel(camera);
  if (!pixel) return {};
  return fmt::format(
      "cannot be undone at pixel ({}, {}): the lens may fold only outside the image of {} x {} px",
      pixel->x(), pixel->y(), camera.width_px, camera.height_px);
}

}  // namespace sightline
