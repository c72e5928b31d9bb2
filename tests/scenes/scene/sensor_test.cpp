// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/sensor.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/scene/laws_for_tests.h"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(SensorKeys, TheScaleMultipliesAllNoiseAndNothingElse) {
  const SceneLaw law = law_of(
      "[noise]\nscale = 2\nread_noise_grey = 3\nfull_well_electrons = 4000\n"
      "dead_fraction = 0.1");
  const Sensor sensor = draw_scene(law, 0, 7, 0).scene.sensor;
  EXPECT_EQ(sensor.read_noise_grey, 6);
  EXPECT_EQ(sensor.full_well_electrons, 1000);
  EXPECT_EQ(sensor.dead_fraction, 0.1);
  EXPECT_EQ(sensor.defect_seed, 7u);
  const Sensor quiet =
      draw_scene(law_of("[noise]\nscale = 0\nfull_well_electrons = 9"), 0, 7, 0).scene.sensor;
  EXPECT_EQ(quiet.read_noise_grey, 0);
  EXPECT_EQ(quiet.full_well_electrons, 0);
}

TEST(SensorKeys, EveryNumberOfASensorIsAFact) {
  const Sensor sensor =
      draw_scene(law_of("[image]\nencoding = \"srgb\"\nbits = 10"), 0, 7, 0).scene.sensor;
  std::map<std::string, FactValue> facts;
  for (const Fact& fact : facts_of(sensor)) facts[fact.name] = fact.value;
  EXPECT_EQ(facts.size(), 10u);
  EXPECT_EQ(facts.at("bits"), FactValue(int64_t{10}));
  EXPECT_EQ(facts.at("white"), FactValue(1023.0));
  EXPECT_EQ(facts.at("is_srgb"), FactValue(true));
  EXPECT_EQ(facts.at("defect_seed"), FactValue(int64_t{7}));
  EXPECT_EQ(facts.at("psf_sigma_px"), FactValue(0.7));
}

TEST(SensorKeys, WhatASensorAlsoDoesIsAFactWhereItDoes) {
  const Sensor sensor =
      draw_scene(law_of("[image]\ncolour = \"rgb\"\nvignetting = 0.25\njpeg_quality = 80\n"
                        "white_balance = [2.0, 1.0, 1.5]\n"
                        "response = [1, 0.5, 0, 0, 1, 0, 0, 0, 2]"),
                 0, 7, 0)
          .scene.sensor;
  std::map<std::string, FactValue> facts;
  for (const Fact& fact : facts_of(sensor)) facts[fact.name] = fact.value;
  EXPECT_EQ(facts.size(), 14u);
  EXPECT_EQ(facts.at("vignetting"), FactValue(0.25));
  EXPECT_EQ(facts.at("jpeg_quality"), FactValue(int64_t{80}));
  EXPECT_EQ(facts.at("white_balance"), FactValue(std::vector{2.0, 1.0, 1.5}));
  EXPECT_EQ(facts.at("response"), FactValue(std::vector<double>{1, 0.5, 0, 0, 1, 0, 0, 0, 2}));
  EXPECT_EQ(sensor.response(0, 1), 0.5);
}

TEST(SensorKeys, MistakesGetOneClearLine) {
  EXPECT_THAT(law_error("[image]\nwhite_balance = [1.0, -1.0, 1.0]"),
              HasSubstr("is [1, -1, 1], must be three numbers from 0 to 16"));
  EXPECT_THAT(law_error("[image]\nresponse = [1, 0, 0, 0, 9, 0, 0, 0, 1]"),
              HasSubstr("is [1, 0, 0, 0, 9, 0, 0, 0, 1], must be 9 numbers from -8 to 8"));
  EXPECT_THAT(law_error("[image]\nresponse = [1, 0, 0]"), HasSubstr("image.response"));
  EXPECT_THAT(law_error("[image]\nresponse = [1, 0, 0, 0, 1, 0, 0, 0, 1]"),
              HasSubstr("needs image.colour"));
  EXPECT_THAT(law_error("[light]\ncolour = [2, 1, 1]"),
              HasSubstr("is [2, 1, 1], must be three numbers from 0 to 1"));
  EXPECT_THAT(law_error("[[lamp]]\ncolour = [0, -1, 1]"),
              HasSubstr("is [0, -1, 1], must be three numbers from 0 to 1"));
  EXPECT_THAT(law_error("[image]\njpeg_quality = 80\nbits = 10"), HasSubstr("8 bits"));
  EXPECT_THAT(law_error("[image]\ncolour = \"grb\""), HasSubstr("rgb"));
  EXPECT_THAT(law_error("[image]\npsf = 1"), HasSubstr("not a known key"));
  EXPECT_THAT(law_error("[image]\nencoding = \"rgb\""), HasSubstr("did you mean 'srgb'"));
}

}  // namespace
}  // namespace sightline
