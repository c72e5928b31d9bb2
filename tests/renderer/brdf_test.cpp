// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/brdf.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "renderer/texture.h"

namespace sightline {
namespace {

// What a perfect mirror's microfacets send to an eye at cosine n_v under an even glow, by the
// midpoint rule over all directions of the light.
double directional_albedo(double a, double n_v) {
  constexpr int kSteps = 400;
  const double side = std::sqrt(1 - n_v * n_v);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double n_l = (i + 0.5) / kSteps;
    const double l_side = std::sqrt(1 - n_l * n_l);
    for (int k = 0; k < kSteps; ++k) {
      const double azimuth = 2 * std::numbers::pi * (k + 0.5) / kSteps;
      const double across = side + l_side * std::cos(azimuth);
      const double along = l_side * std::sin(azimuth);
      const double n_h = (n_v + n_l) / std::hypot(across, along, n_v + n_l);
      sum += microfacets(a, n_l, n_v, n_h) * n_l;
    }
  }
  return sum * 2 * std::numbers::pi / kSteps / kSteps;
}

TEST(Brdf, TheDirectionalAlbedoIsTheClosedForm) {
  constexpr double kMidpointError = 2e-3;
  EXPECT_NEAR(directional_albedo(1, 1), 1 - std::numbers::ln2, kMidpointError);
  EXPECT_NEAR(directional_albedo(0.25, 0.5), 0.8573, kMidpointError);
  EXPECT_NEAR(directional_albedo(0.64, 0.5), 0.6212, kMidpointError);
  EXPECT_NEAR(directional_albedo(1, 0.2), 0.6416, kMidpointError);
}

TEST(Brdf, TheTableOfTheGlowHasTheSame) {
  constexpr double kTableError = 1.5e-3;
  const auto all = [](double a, double n_v) {
    const GlowShares shares = glow_shares(a, n_v);
    return shares.plain + shares.grazing;
  };
  EXPECT_NEAR(all(1, 1), 1 - std::numbers::ln2, kTableError);
  EXPECT_NEAR(all(0.25, 0.5), 0.8573, kTableError);
  EXPECT_NEAR(all(0.64, 0.5), 0.6212, kTableError);
  EXPECT_NEAR(all(1, 0.2), 0.6416, kTableError);
  // Near the edge, by a quadrature of 2.25 million directions.
  EXPECT_NEAR(all(0.25, 0.05), 0.9331, kTableError);
  EXPECT_NEAR(all(0.25, 0.1), 0.8916, kTableError);
}

TEST(Brdf, AWhiteDielectricInAnEvenGlowSendsAllOfItBack) {
  for (const double roughness : {0.05, 0.3, 1.0}) {
    for (const double n_v : {0.1, 0.5, 1.0}) {
      const Reflection white = reflected_glow({0, roughness}, 0.7, n_v);
      EXPECT_NEAR(white.of_base + white.own, 0.7, 1e-12);
      const Reflection metal = reflected_glow({1, roughness}, 0.7, n_v);
      EXPECT_LE(metal.of_base + metal.own, 0.7 * 1.005);  // the table's error
      EXPECT_GT(metal.own, 0);
    }
  }
}

// glTF 2.0, appendix B: material = mix(dielectric, metal), spelt out.
TEST(Brdf, ADistantLightFollowsTheSpecification) {
  const double n_l = 0.8, n_v = 0.6, n_h = 0.95, v_h = 0.7, roughness = 0.4, base = 0.3;
  const double a2 = std::pow(roughness, 4);
  const double d = a2 / (std::numbers::pi * std::pow(n_h * n_h * (a2 - 1) + 1, 2));
  const double v = 0.5 / (n_v * std::sqrt(a2 + (1 - a2) * n_l * n_l) +
                          n_l * std::sqrt(a2 + (1 - a2) * n_v * n_v));
  const double w = std::pow(1 - v_h, 5);
  const double fresnel = 0.04 + 0.96 * w;
  const double dielectric = (1 - fresnel) * base / std::numbers::pi + fresnel * v * d;
  const double metal = v * d * (base + (1 - base) * w);
  for (const double metallic : {0.0, 0.25, 1.0}) {
    const Reflection light = reflected({metallic, roughness}, 0.9, n_l, n_v, n_h, v_h);
    const double expected =
        std::numbers::pi * 0.9 * n_l * ((1 - metallic) * dielectric + metallic * metal);
    EXPECT_NEAR(base * light.of_base + light.own, expected, 1e-12) << metallic;
  }
  EXPECT_EQ(reflected({0, roughness}, 0.9, -0.1, n_v, n_h, v_h).of_base, 0);
}

Texture texture_of(int width, int height, std::vector<uint8_t> rgba, bool is_srgb = true) {
  return {"t", width, height, is_srgb, std::move(rgba)};
}

TEST(TexturePyramid, AllCodesSurviveTheHalving) {
  for (int code = 0; code < 256; ++code) {
    const auto c = static_cast<uint8_t>(code);
    const TexturePyramid pyramid(texture_of(2, 1, {c, c, c, 255, c, c, c, 255}), false);
    const double exact = pyramid.at({}, 0.25f, 0.5f, 0)[0];
    EXPECT_EQ(pyramid.at({}, 0.25f, 0.5f, 1)[0], static_cast<float>(exact)) << code;
  }
}

TEST(TexturePyramid, WhatIsNotThereGivesNoColour) {
  // Opaque red beside transparent green.
  const auto texture = texture_of(2, 1, {255, 0, 0, 255, 0, 255, 0, 0});
  for (const float level : {0.0f, 1.0f}) {
    const Eigen::Array4f half = TexturePyramid(texture, true).at({}, 0.5f, 0.5f, level);
    EXPECT_EQ(half[0], 1);
    EXPECT_EQ(half[1], 0);
    EXPECT_NEAR(half[3], 0.5, 0.51 / 65535);  // rounded to a code
    EXPECT_GT(TexturePyramid(texture, false).at({}, 0.5f, 0.5f, level)[1], 0.4f);
  }
}

TEST(TexturePyramid, BordersRepeatMirrorOrStay) {
  const auto texture = texture_of(2, 1, {0, 0, 0, 255, 255, 0, 0, 255}, false);
  const TexturePyramid pyramid(texture, false);
  const auto red = [&](Wrap wrap, float u) {
    TextureRef ref;
    ref.wrap_u = wrap;
    return pyramid.at(ref, u, 0.5f, 0)[0];
  };
  EXPECT_EQ(red(Wrap::kRepeat, 1.25f), 0);
  EXPECT_EQ(red(Wrap::kRepeat, -0.25f), 1);
  EXPECT_EQ(red(Wrap::kRepeat, 0.0f), 0.5f);  // half way to the texel on the other side
  EXPECT_EQ(red(Wrap::kMirror, 1.25f), 1);
  EXPECT_EQ(red(Wrap::kMirror, -0.25f), 0);
  EXPECT_EQ(red(Wrap::kMirror, 2.25f), 0);
  EXPECT_EQ(red(Wrap::kClamp, 1.25f), 1);
  EXPECT_EQ(red(Wrap::kClamp, -7.0f), 0);
}

TEST(TexturePyramid, OddSidesKeepTheirMean) {
  // Three texels halve into one: their mean.
  const auto texture = texture_of(3, 1, {30, 0, 0, 255, 60, 0, 0, 255, 240, 0, 0, 255}, false);
  EXPECT_NEAR(TexturePyramid(texture, false).at({}, 0.5f, 0.5f, 5)[0], 110 / 255.0, 0.5 / 255);
}

}  // namespace
}  // namespace sightline
