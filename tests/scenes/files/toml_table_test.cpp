// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/toml_table.h"

#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/files/input_error.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TomlTable parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return TomlTable::read_text(text, "study.toml", overrides);
}

TEST(TomlTable, ReadsWhatIsThere) {
  const TomlTable table = parse("a = 2\nb = 'x'\nc = [1, 2.5, 3]\n[d]\ne = true\n");
  EXPECT_EQ(table.number("a"), 2.0);
  EXPECT_EQ(table.integer("a"), 2);
  EXPECT_EQ(table.text("b"), "x");
  EXPECT_EQ(table.vector3("c"), Eigen::Vector3d(1, 2.5, 3));
  EXPECT_TRUE(table.table("d").flag("e"));
  EXPECT_EQ(table.number("absent", {}, 7.0), 7.0);
  EXPECT_NO_THROW(table.reject_unknown_keys());
}

TEST(TomlTable, ListsItsValuesByThePathsThatOverridesHave) {
  const TomlTable table =
      parse("a = 2\n[d]\ne = [0.15, 1]\n[[f]]\ng = 'x'\n[[f]]\ng = 'y'\n", {"f.1.g=z", "d.h=true"});
  const std::map<std::string, std::string> expected = {
      {"a", "2"}, {"d.e", "[ 0.15, 1 ]"}, {"d.h", "true"}, {"f.0.g", "'x'"}, {"f.1.g", "'z'"}};
  EXPECT_EQ(table.values(), expected);
  EXPECT_THROW(table.reject_unknown_keys(), InputError) << "nobody has asked for them by that";
  EXPECT_EQ(table.table("d").values().size(), 2u);
}

TEST(TomlTable, ErrorsNameFileKeyGivenAndAllowed) {
  const TomlTable table = parse("[camera]\nf_px = -3\n");
  const std::string error = error_of([&] { table.table("camera").number("f_px", {1, 100}); });
  EXPECT_THAT(error, AllOf(HasSubstr("study.toml"), HasSubstr("camera.f_px"), HasSubstr("-3"),
                           HasSubstr("from 1 to 100")));
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST(TomlTable, ReadsListsOfNumbersWithinTheirRange) {
  const TomlTable table = parse("a = [3, 0.5]\nb = []\nc = [1, 1]\nd = 2\ne = [1, 'x']\nf = [9]\n");
  EXPECT_EQ(table.number_list("a", {0, 3}), (std::vector<double>{3, 0.5}));
  EXPECT_THAT(error_of([&] { table.number_list("b", {}); }), HasSubstr("one or more"));
  EXPECT_THAT(error_of([&] { table.number_list("c", {}); }), HasSubstr("holds 1 twice"));
  EXPECT_THAT(error_of([&] { table.number_list("d", {}); }), HasSubstr("must be an array"));
  EXPECT_THAT(error_of([&] { table.number_list("e", {}); }), HasSubstr("numbers only"));
  EXPECT_THAT(error_of([&] {
                table.number_list("f", {0, 3});
              }),
              AllOf(HasSubstr("holds 9"), HasSubstr("from 0 to 3")));
  EXPECT_THAT(error_of([&] { table.number_list("absent", {}); }), HasSubstr("is missing"));
}

TEST(TomlTable, RejectsWrongTypesAndNumbersThatAreNotFinite) {
  const TomlTable table = parse("a = 'x'\nb = nan\nc = inf\nd = 1.5\ne = [1, 2]\nf = [1, 2, nan]");
  EXPECT_THROW(table.number("a"), InputError);
  EXPECT_THROW(table.number("b"), InputError);
  EXPECT_THROW(table.number("c"), InputError);
  EXPECT_THROW(table.integer("d"), InputError);
  EXPECT_THROW(table.vector3("e"), InputError);
  EXPECT_THROW(table.vector3("f"), InputError);
  EXPECT_THROW(table.text("d"), InputError);
  EXPECT_THROW(table.flag("a"), InputError);
  EXPECT_THROW(table.number("missing"), InputError);
}

TEST(TomlTable, AnUnknownKeyIsAnErrorWithASuggestion) {
  const TomlTable table = parse("trails = 3\n");
  table.integer("trials", {}, 1);
  EXPECT_THAT(error_of([&] { table.reject_unknown_keys(); }),
              AllOf(HasSubstr("trails"), HasSubstr("did you mean 'trials'")));
}

TEST(TomlTable, AnUnknownKeyOfASubTableIsFoundFromTheTop) {
  const TomlTable table = parse("[light]\nambience = 0.3\n");
  table.table("light").number("ambient", {}, 0.3);
  EXPECT_THAT(error_of([&] { table.reject_unknown_keys(); }),
              AllOf(HasSubstr("light.ambience"), HasSubstr("did you mean 'ambient'")));
}

TEST(TomlTable, OverridesReplaceAndAdd) {
  const TomlTable table = parse("a = 1\n[b]\nc = 2\n", {"a=5", "b.c=6", "b.d=word", "e.f=[1, 2]"});
  EXPECT_EQ(table.integer("a"), 5);
  EXPECT_EQ(table.table("b").integer("c"), 6);
  EXPECT_EQ(table.table("b").text("d"), "word");
  EXPECT_EQ(table.table("e").numbers("f", 2), (std::vector<double>{1, 2}));
}

TEST(TomlTable, OverridesTakeAKeyWithDotsInQuotes) {
  const std::vector<std::string> quotes = {"sweep.\"poses.range_m\"=[1, 2]",
                                           "sweep.'poses.range_m'=[1, 2]"};
  for (const std::string& setting : quotes) {
    const TomlTable table = parse("", {setting});
    EXPECT_EQ(table.table("sweep").keys(), std::vector<std::string>{"poses.range_m"}) << setting;
  }
  // Without quotes it is a table in a table, and quotes that nobody closes are letters.
  EXPECT_EQ(parse("", {"sweep.poses.range_m=1"}).table("sweep").keys(),
            std::vector<std::string>{"poses"});
  EXPECT_EQ(parse("", {"sweep.\"poses=1"}).table("sweep").keys(),
            std::vector<std::string>{"\"poses"});
}

TEST(TomlTable, RejectsOverridesThatMakeNoSense) {
  EXPECT_THROW(parse("a = 1\n", {"a"}), InputError);
  EXPECT_THROW(parse("a = 1\n", {"=3"}), InputError);
  EXPECT_THROW(parse("a = 1\n", {"a.b=3"}), InputError);
}

TEST(TomlTable, SaysWhereAFileIsBroken) {
  EXPECT_THAT(error_of([] { parse("a = 1\nb = = 2\n"); }), HasSubstr("study.toml:2"));
  EXPECT_THAT(error_of([] { TomlTable::read_file("no/such/file.toml"); }),
              HasSubstr("no/such/file.toml"));
}

TEST(TomlTable, SaysWhichNumberIsBeyondAll) {
  EXPECT_EQ(error_of([] { parse("a = 1e308\n"); }), "");
  EXPECT_THAT(error_of([] { parse("a = 1\nb = [2, -1e400]\n"); }),
              HasSubstr("study.toml:2: '1e400' is beyond numbers of 64 bits"));
  EXPECT_THAT(error_of([] { parse("a = 1\n", {"a={b=[1e400]}"}); }),
              HasSubstr("--set a={b=[1e400]}: '1e400' is beyond numbers"));
  EXPECT_EQ(parse("a = 1\n", {"a=[1] says so"}).text("a"), "[1] says so");
  // A word is a text, and what no number can be is one.
  EXPECT_EQ(parse("a = 1\n", {"a=1e400"}).text("a"), "1e400");
}

TEST(TomlTable, AsWrittenItReadsTheSame) {
  const TomlTable table = parse("a = 0.1\n[b]\nc = ['x', 'y']\n", {"a=0.2"});
  const TomlTable again = parse(table.to_toml());
  EXPECT_EQ(again.number("a"), 0.2);
  EXPECT_THAT(table.to_toml(), HasSubstr("a = 0.2\n"));
  EXPECT_EQ(again.table("b").texts("c"), (std::vector<std::string>{"x", "y"}));
}

TEST(ClosestName, FindsTyposAndNothingElse) {
  const std::vector<std::string> names = {"boeing707", "cube"};
  EXPECT_EQ(closest_name("boing707", names), "boeing707");
  EXPECT_EQ(closest_name("cbue", names), "cube");
  EXPECT_EQ(closest_name("teapot", names), "");
}

}  // namespace
}  // namespace sightline
