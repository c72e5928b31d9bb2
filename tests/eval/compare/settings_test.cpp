// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;

ComparedRun run_of(const std::string& toml) {
  ComparedRun run;
  run.path = "run";
  run.toml = toml;
  return run;
}

TEST(Settings, ThatDifferAreSaidInOneLine) {
  const ComparedRun base =
      run_of("title = 'a'\n[solver]\nrho = 10.0\n[noise]\nscale = 1.0\n[[poses.fixed]]\nx = 1\n");
  const ComparedRun now =
      run_of("title = 'b'\nquestion = 'why?'\n[noise]\nscale = 2\n[[poses.fixed]]\nx = 3\n");
  EXPECT_EQ(settings_text(base, now),
            "settings differ: noise.scale 1.0 to 2; poses.fixed.0.x 1 to 3; "
            "solver.rho 10.0 to not stated");
  EXPECT_THAT(settings_text(now, base), HasSubstr("solver.rho not stated to 10.0"));
}

TEST(Settings, AreTheSameHoweverTheyAreWritten) {
  EXPECT_EQ(settings_text(run_of("a = 2.0\nb = 'x'"), run_of("b = \"x\"\na = 2")),
            "settings: the same in both");
  EXPECT_THAT(settings_text(run_of("a = '2.0'"), run_of("a = '2'")), HasSubstr("settings differ"))
      << "texts are no numbers";
}

TEST(Settings, OfAStudyThatIsNotKnown) {
  ComparedRun alone = run_of("");
  alone.toml.reset();
  EXPECT_EQ(settings_text(run_of("a = 1"), alone), "settings: not known, as run has no study.toml");
}

TEST(Settings, ALongValueIsShortened) {
  const std::string line =
      settings_text(Settings{{"key", std::string(500, 'x')}}, Settings{{"key", "y"}});
  EXPECT_LT(line.size(), 120u);
  EXPECT_THAT(line, HasSubstr("to y"));
}

}  // namespace
}  // namespace sightline
