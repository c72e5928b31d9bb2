// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/key_lists.h"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/key_tables.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(KeyLists, ThePageOfTheDocsIsWhatTheProgramPrints) {
  std::ifstream stream(SIGHTLINE_SOURCE_DIR "/docs/keys.md");
  const std::string page{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(page, key_page())
      << "write it anew: build/release/sightline list keys --markdown > docs/keys.md";
}

TEST(KeyLists, ATableIsListedAlone) {
  const Outcome image = run("list keys image");
  EXPECT_EQ(image.exit_code, 0);
  EXPECT_THAT(image.output, HasSubstr("[image]\n"));
  EXPECT_THAT(image.output, HasSubstr("psf_sigma_px"));
  EXPECT_THAT(image.output, HasSubstr("0 to 50, or [low, high]"));
  EXPECT_THAT(image.output, Not(HasSubstr("[noise]")));
  const Outcome all = run("list keys");
  for (const char* heading : {"[camera]",        "[poses]",
                              "[[poses.fixed]]", "[image]",
                              "[noise]",         "[background]",
                              "[light]",         "[livery]",
                              "[material]",      "[motion]",
                              "[[other]]",       "[prior]",
                              "[extraction]",    "[extraction.lines]",
                              "[solver]",        "[outliers]",
                              "[points]",        "[dataset]",
                              "[sweep]",         "[limits]"}) {
    EXPECT_THAT(all.output, HasSubstr(std::string(heading) + "\n"));
  }
}

TEST(KeyLists, MistakesGetOneClearLine) {
  EXPECT_THAT(error_of([] { key_list("imag"); }), HasSubstr("did you mean 'image'"));
  EXPECT_THAT(run("list key").output, HasSubstr("did you mean 'keys'"));
  EXPECT_EQ(run("list solvers image").exit_code, 1);
  EXPECT_EQ(run("list solvers --markdown").exit_code, 1);
  EXPECT_EQ(run("list keys image --markdown").exit_code, 1);
}

TEST(KeyLists, TheColumnsAreAPageToo) {
  const fs::path page = fs::path(SIGHTLINE_SOURCE_DIR) / "docs/columns.md";
  EXPECT_EQ(run("list columns --markdown").output, read_whole(page));
  EXPECT_NE(run("list columns").output, read_whole(page));
  EXPECT_EQ(run("list columns noise").exit_code, 1);
}

TEST(KeyLists, TheKeysOfAStudySayWhatTheyMean) {
  for (const KeyText& key : study_keys()) {
    EXPECT_NE(key.meaning, "") << key.name;
    EXPECT_NE(key.range, "") << key.name;
    EXPECT_NE(key.fallback, "") << key.name;
  }
}

}  // namespace
}  // namespace sightline
