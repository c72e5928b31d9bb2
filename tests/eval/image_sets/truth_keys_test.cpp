// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What an image set states of how its images were made: nothing is forgotten, nothing is false.
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "scenes/picture/picture_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

SetPlan plan_with(const std::string& format, std::vector<std::string> settings) {
  for (const char* setting : {"camera.width_px=64", "camera.height_px=64", "camera.f_px=250",
                              "image.samples_per_pixel=1"}) {
    settings.emplace_back(setting);
  }
  SetRequest request;
  request.source = "cube";
  request.overrides.set = settings;
  request.count = 1;
  request.format = format;
  return plan_set(request);
}

Json truth_with(const std::vector<std::string>& settings) {
  const SetPlan plan = plan_with("bop", settings);
  Renderer renderer;
  return truth_of(plan, render_image(plan, 0, renderer));
}

// Whether the truth has a value at a place such as "scene.sensor.gain". Of lists, their last.
bool has_value(Json truth, const std::string& place) {
  std::stringstream parts(place);
  for (std::string part; std::getline(parts, part, '.');) {
    if (truth.is_array()) truth = Json(truth.back());
    if (!truth.is_object() || !truth.contains(part)) return false;
    truth = Json(truth.at(part));
  }
  return !place.empty() && !truth.is_null();
}

std::vector<std::string> keys_missing_in(const Json& truth) {
  std::vector<std::string> missing;
  for (const KeyText& key : scene_keys()) {
    if (!has_value(truth, key.truth)) missing.push_back(key.table + "." + key.name);
  }
  return missing;
}

TEST(Truth, HasAValueOfEveryKeyThatMakesThePicture) {
  const TemporaryFolder folder;
  const auto panorama = folder.write(
      "grey.hdr", "#?RADIANCE\n\n-Y 1 +X 2\n" + std::string({64, 64, 64, 127, 64, 64, 64, 127}));
  const auto picture = folder.write("grey.png", png_bytes(cv::Mat(2, 2, CV_8UC3, cv::Scalar(9))));
  Json truth = truth_with({"material.value=0.5",
                           "material.roughness=0.5",
                           "material.metallic=0.5",
                           "material.emission=0.5",
                           "material.textures=" + picture.string(),
                           "material.per=part",
                           "image.response=[1, 0, 0, 0, 1, 0, 0, 0.5, 1]",
                           "other=[{target='cube', scale=0.1}]",
                           "image.colour=rgb",
                           "image.vignetting=0.1",
                           "image.jpeg_quality=90",
                           "image.white_balance=[1.0, 1.0, 2.0]",
                           "light.second=0.1",
                           "light.colour=[1.0, 1.0, 0.5]",
                           "light.second_colour=[1.0, 0.5, 0.5]",
                           "light.casts_shadow=true",
                           "light.radius_deg=0.27",
                           "light.occlusion=true",
                           "lamp=[{strength=0.5}]",
                           "environment.file=" + panorama.string(),
                           "image.truth_sees=opaque",
                           "camera.skew_px=1",
                           "optics.aperture_mm=1",
                           "optics.red_scale=0.001",
                           "motion.readout=1"});
  EXPECT_THAT(keys_missing_in(truth), IsEmpty());
  for (const char* fact : {"is_srgb", "defect_seed"}) {
    EXPECT_TRUE(truth["scene"]["sensor"].contains(fact)) << fact;
  }
  EXPECT_EQ(truth["scene"]["background"]["star_level"], 1.0);
  truth["scene"]["sensor"].erase("is_srgb");
  EXPECT_THAT(keys_missing_in(truth), ElementsAre("image.encoding"));
}

// Sets of before colour are verified by what they state.
TEST(Truth, OfAGreyPictureIsWhatItAlwaysWas) {
  const Json scene = truth_with({})["scene"];
  for (const char* part : {"colouring", "lamps", "materials", "environment", "optics"}) {
    EXPECT_FALSE(scene.contains(part)) << part;
  }
  for (const char* fact :
       {"second", "to_second_in_cam", "colour", "second_colour", "radius_deg", "occlusion"}) {
    EXPECT_FALSE(scene["light"].contains(fact)) << fact;
  }
  EXPECT_FALSE(scene["motion"].contains("readout"));
  for (const char* fact : {"vignetting", "jpeg_quality", "white_balance", "response"}) {
    EXPECT_FALSE(scene["sensor"].contains(fact)) << fact;
  }
}

TEST(Truth, StatesTheEncoding) {
  EXPECT_EQ(truth_with({"image.encoding=srgb"})["scene"]["sensor"]["is_srgb"], true);
  EXPECT_EQ(truth_with({})["scene"]["sensor"]["is_srgb"], false);
}

// All texts that describe a set.
std::string descriptions_of(const SetPlan& plan) {
  std::string text;
  for (const SetFile& file : plan.format->set_files(plan)) {
    if (file.path.ends_with(".md")) text += file.bytes;
  }
  return text;
}

TEST(SetDescription, StatesTheEncodingAsItIs) {
  for (const std::string format : {"bop", "speed"}) {
    const std::string linear = descriptions_of(plan_with(format, {}));
    EXPECT_THAT(linear, HasSubstr("Nothing is gamma-encoded."));
    EXPECT_THAT(linear, HasSubstr("linear grey"));
    const std::string srgb = descriptions_of(plan_with(format, {"image.encoding=srgb"}));
    EXPECT_THAT(srgb, Not(HasSubstr("Nothing is gamma-encoded.")));
    EXPECT_THAT(srgb, Not(HasSubstr("linear grey")));
    EXPECT_THAT(srgb, HasSubstr("sRGB-encoded grey"));
    const std::string both =
        descriptions_of(plan_with(format, {"sweep={'image.encoding'=['linear', 'srgb']}"}));
    EXPECT_THAT(both, HasSubstr("Some images are linear, others sRGB-encoded"));
  }
}

}  // namespace
}  // namespace sightline
