// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;

// A part of a scene as others are, small.
enum class Shape { kRound, kSquare };
struct Lamp {
  double power = 2;
  int bulbs = 3;
  bool is_blue = false;
  Shape shape = Shape::kRound;
};
struct LampLaw {
  Range power = Lamp{}.power;
  int bulbs = Lamp{}.bulbs;
  bool is_blue = Lamp{}.is_blue;
  Shape shape = Lamp{}.shape;
  std::optional<double> tilt_deg;
  double age = 0;
};

std::vector<Key> keys_of(LampLaw& law, Lamp& lamp) {
  const std::vector<std::pair<std::string, Shape>> shapes = {{"round", Shape::kRound},
                                                             {"square", Shape::kSquare}};
  return {
      {"lamp", "power", &law.power, {0, 10}, "W", "how bright", &lamp.power},
      {"lamp", "bulbs", &law.bulbs, {1, 9}, "", "how many", &lamp.bulbs},
      {"lamp",
       "colour",
       choice(law.is_blue, {{"red", false}, {"blue", true}}),
       {},
       "",
       "which",
       choice(lamp.is_blue, {{"red", false}, {"blue", true}}),
       "is_blue"},
      {"lamp.body",
       "shape",
       choice(law.shape, shapes),
       {},
       "",
       "of it",
       choice(lamp.shape, shapes)},
      {"lamp", "tilt_deg", &law.tilt_deg, {0, 90}, "deg", "to a side", {}, "power"},
      {"lamp", "age", &law.age, {0, 99}, "", "in years", {}, "", true},
  };
}

void read(const std::string& text, LampLaw& law) {
  Lamp unused;
  const TomlTable table = TomlTable::read_text(text, "lamp.toml");
  read_keys(table, keys_of(law, unused));
  table.reject_unknown_keys();
}

std::string error_in(const std::string& text) {
  LampLaw law;
  return error_of([&] { read(text, law); });
}

TEST(Keys, ReadWhatTheFileSaysAndLeaveTheRest) {
  LampLaw law;
  read("[lamp]\nage = 4\npower = [1, 5]\ncolour = \"blue\"\nbody.shape = \"square\"\n", law);
  EXPECT_EQ(law.age, 4);
  EXPECT_EQ(law.power.min, 1);
  EXPECT_EQ(law.power.max, 5);
  EXPECT_TRUE(law.is_blue);
  EXPECT_EQ(law.shape, Shape::kSquare);
  EXPECT_EQ(law.bulbs, 3);
  EXPECT_FALSE(law.tilt_deg.has_value());
}

TEST(Keys, SayWhatIsWrong) {
  EXPECT_THAT(error_in("[lamp]\n"), HasSubstr("lamp.age is missing"));
  EXPECT_THAT(error_in("[lamp]\nage = 100"), HasSubstr("lamp.age is 100"));
  EXPECT_THAT(error_in("[lamp]\nage = 1\nbulbs = 1.5"), HasSubstr("must be a whole number"));
  EXPECT_THAT(error_in("[lamp]\nage = 1\npower = [5, 1]"), HasSubstr("[low, high]"));
  EXPECT_THAT(error_in("[lamp]\nage = 1\ncolour = \"blu\""), HasSubstr("did you mean 'blue'"));
  EXPECT_THAT(error_in("[lamp]\nage = 1\nbody.shape = 3"), HasSubstr("lamp.body.shape is 3"));
  EXPECT_THAT(error_in("[lamp]\nage = 1\npowr = 3"), HasSubstr("did you mean 'power'"));
}

TEST(Keys, GiveTheFrameItsValuesAndStateThem) {
  LampLaw law;
  law.power = {1, 5};
  law.bulbs = 7;
  law.is_blue = true;
  law.shape = Shape::kSquare;
  Lamp lamp;
  const std::vector<Key> keys = keys_of(law, lamp);
  draw_keys(keys, Draws{7, 3});
  EXPECT_EQ(lamp.power, Draws({7, 3})(law.power, "lamp.power"));
  EXPECT_GE(lamp.power, 1);
  EXPECT_LE(lamp.power, 5);
  EXPECT_EQ(lamp.bulbs, 7);
  const std::vector<Fact> facts = facts_of(keys);
  ASSERT_EQ(facts.size(), 4u);
  EXPECT_EQ(facts[0].value, FactValue(lamp.power));
  EXPECT_EQ(facts[2].name, "is_blue");
  EXPECT_EQ(facts[2].value, FactValue(true));
  EXPECT_EQ(facts[3].value, FactValue(std::string("square")));
}

TEST(Keys, DescribeThemselves) {
  LampLaw law;
  Lamp lamp;
  const std::vector<KeyText> texts = texts_of(keys_of(law, lamp), "scene.lamp");
  EXPECT_EQ(texts[0].range, "0 to 10, or [low, high]");
  EXPECT_EQ(texts[0].fallback, "2");
  EXPECT_EQ(texts[0].truth, "scene.lamp.power");
  EXPECT_EQ(texts[2].range, "\"red\", \"blue\"");
  EXPECT_EQ(texts[2].fallback, "\"red\"");
  EXPECT_EQ(texts[2].truth, "scene.lamp.is_blue");
  EXPECT_EQ(texts[4].fallback, "none");
  EXPECT_EQ(texts[5].fallback, "required");
  EXPECT_EQ(texts[5].truth, "");
}

}  // namespace
}  // namespace sightline
