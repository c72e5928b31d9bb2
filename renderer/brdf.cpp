// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/brdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace sightline {
namespace {

constexpr double kDielectric = 0.04;  // reflectance at normal incidence of what is no metal
// A distant light is a point: a perfect mirror would show it nowhere.
constexpr double kLeastA = 1e-3;

double fresnel_weight(double v_h) {
  const double x = 1 - std::clamp(std::abs(v_h), 0.0, 1.0);
  return x * x * x * x * x;
}

double visibility(double a, double n_l, double n_v) {
  const double a2 = a * a;
  const double light = n_v * std::sqrt(a2 + (1 - a2) * n_l * n_l);
  const double eye = n_l * std::sqrt(a2 + (1 - a2) * n_v * n_v);
  return 0.5 / (light + eye);
}

// The part of the microfacets that the eye sees, or the light reaches, beside no others.
double unmasked(double a, double cosine) {
  return 2 * cosine / (cosine + std::sqrt(a * a + (1 - a * a) * cosine * cosine));
}

// A half-way direction from the unit square, as often as the eye sees microfacets there (E. Heitz,
// Sampling the GGX distribution of visible normals, 2018): its cosines to the normal and the eye.
struct HalfWay {
  double n_h = 0, v_h = 0;
};
HalfWay seen_half_way(double a, double n_v, double radius, double azimuth) {
  const double side = std::sqrt(std::max(0.0, 1 - n_v * n_v));
  const double stretch = std::hypot(a * side, n_v);
  const double eye_x = a * side / stretch, eye_z = n_v / stretch;
  // On a disc across the stretched eye, pushed off its hidden half.
  const double y = radius * std::cos(azimuth);
  const double push = (1 + eye_z) / 2;
  const double across = (1 - push) * std::sqrt(1 - y * y) + push * radius * std::sin(azimuth);
  const double along = std::sqrt(std::max(0.0, 1 - y * y - across * across));
  const double x = a * (along * eye_x - across * eye_z);
  const double z = std::max(0.0, along * eye_z + across * eye_x);
  const double length = std::sqrt(x * x + a * a * y * y + z * z);
  return {z / length, (side * x + n_v * z) / length};
}

GlowShares integrated(double a, double n_v) {
  constexpr uint32_t kDirections = 1024;
  GlowShares sum;
  for (uint32_t i = 0; i < kDirections; ++i) {
    const double azimuth = 2 * std::numbers::pi * (i + 0.5) / kDirections;
    const double radius = std::sqrt(radical_inverse(i) + 0.5 / kDirections);
    const HalfWay half_way = seen_half_way(a, n_v, radius, azimuth);
    const double n_l = 2 * half_way.v_h * half_way.n_h - n_v;
    if (!(n_l > 0)) continue;
    const double share = 4 * n_l * n_v * visibility(a, n_l, n_v) / unmasked(a, n_v) / kDirections;
    const double weight = fresnel_weight(half_way.v_h);
    sum.plain += share * (1 - weight);
    sum.grazing += share * weight;
  }
  return sum;
}

constexpr int kSteps = GlowCurve::kSteps;
constexpr double kLeastCosine = 1e-3;  // edge-on nothing is seen, and the integrals have no value
using GlowTable = std::array<std::array<GlowShares, kSteps>, kSteps>;

// By roughness (the root of a) and cosine, both from 0 to 1.
const GlowTable& glow_table() {
  static const GlowTable kTable = [] {
    GlowTable table;
    for (int r = 0; r < kSteps; ++r) {
      const double roughness = r / (kSteps - 1.0);
      for (int c = 0; c < kSteps; ++c) {
        table[r][c] = integrated(roughness * roughness, std::max(kLeastCosine, c / (kSteps - 1.0)));
      }
    }
    return table;
  }();
  return kTable;
}

struct Between {
  int low = 0;
  double share = 0;  // of the next
};

Between between(double unit) {
  const double at = std::clamp(unit, 0.0, 1.0) * (kSteps - 1);
  const int low = std::min(static_cast<int>(at), kSteps - 2);
  return {low, at - low};
}

}  // namespace

double radical_inverse(uint32_t bits) {
  bits = bits << 16 | bits >> 16;
  bits = (bits & 0x55555555U) << 1 | (bits & 0xAAAAAAAAU) >> 1;
  bits = (bits & 0x33333333U) << 2 | (bits & 0xCCCCCCCCU) >> 2;
  bits = (bits & 0x0F0F0F0FU) << 4 | (bits & 0xF0F0F0F0U) >> 4;
  bits = (bits & 0x00FF00FFU) << 8 | (bits & 0xFF00FF00U) >> 8;
  return bits * 0x1p-32;
}

double microfacets(double a, double n_l, double n_v, double n_h) {
  if (!(n_l > 0 && n_v > 0 && n_h > 0)) return 0;
  const double a2 = std::max(a, kLeastA) * std::max(a, kLeastA);
  const double root = n_h * n_h * (a2 - 1) + 1;
  return a2 / (std::numbers::pi * root * root) * visibility(std::sqrt(a2), n_l, n_v);
}

GlowShares glow_shares(double a, double n_v) {
  const Between row = between(std::sqrt(std::max(0.0, a)));
  const Between column = between(n_v);
  GlowShares out;
  for (const auto& [r, height] : {std::pair{row.low, 1 - row.share}, {row.low + 1, row.share}}) {
    for (const auto& [c, width] :
         {std::pair{column.low, 1 - column.share}, {column.low + 1, column.share}}) {
      const GlowShares& cell = glow_table()[r][c];
      out.plain += height * width * cell.plain;
      out.grazing += height * width * cell.grazing;
    }
  }
  return out;
}

GlowCurve::GlowCurve(double a) {
  for (int c = 0; c < kSteps; ++c) shares_[c] = glow_shares(a, c / (kSteps - 1.0));
}

GlowShares GlowCurve::at(double n_v) const {
  const Between column = between(n_v);
  const GlowShares& low = shares_[column.low];
  const GlowShares& high = shares_[column.low + 1];
  return {low.plain + column.share * (high.plain - low.plain),
          low.grazing + column.share * (high.grazing - low.grazing)};
}

Reflection reflected(const Gloss& gloss, double level, double n_l, double n_v, double n_h,
                     double v_h) {
  if (!(n_l > 0)) return {};
  const double facing = level * n_l;
  const double mirror =
      std::numbers::pi * facing * microfacets(gloss.roughness * gloss.roughness, n_l, n_v, n_h);
  const double weight = fresnel_weight(v_h);
  const double fresnel = kDielectric + (1 - kDielectric) * weight;
  const double m = gloss.metallic;
  return {.of_base = (1 - m) * (1 - fresnel) * facing + m * (1 - weight) * mirror,
          .own = (1 - m) * fresnel * mirror + m * weight * mirror};
}

GlowParts glow_parts(const GlowShares& shares, double metallic) {
  const double coat = kDielectric * shares.plain + shares.grazing;
  const double m = metallic;
  return {.dull_of_base = (1 - m) * (1 - coat),
          .mirror_of_base = m * shares.plain,
          .mirror_own = (1 - m) * coat + m * shares.grazing};
}

Reflection reflected_shares(const GlowShares& shares, double metallic, double level) {
  const GlowParts parts = glow_parts(shares, metallic);
  return {.of_base = level * (parts.dull_of_base + parts.mirror_of_base),
          .own = level * parts.mirror_own};
}

Reflection reflected_glow(const Gloss& gloss, double level, double n_v) {
  return reflected_shares(glow_shares(gloss.roughness * gloss.roughness, n_v), gloss.metallic,
                          level);
}

}  // namespace sightline
