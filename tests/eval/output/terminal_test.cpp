// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/terminal.h"

#include <algorithm>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr TextLook kPipe{};
constexpr TextLook kNarrow{.columns = 40, .has_colour = false};
constexpr TextLook kColours{.columns = 0, .has_colour = true};

TEST(Terminal, APipeGetsTheTextAsItIs) {
  const std::string text = "\nheading\nname\n────\nrow worse\n\nfailed: lspe 3 of 4\nno line end";
  EXPECT_EQ(in_look(text, kPipe), text);
  EXPECT_EQ(in_look("", kPipe), "");
  EXPECT_EQ(shown(text), text) << "a test's standard output is no terminal";
}

TEST(Terminal, ALongLineGoesOnBelowItsLastColumn) {
  EXPECT_EQ(in_look("  lspe  least squares of the reprojection errors\n", kNarrow),
            "  lspe  least squares of the\n        reprojection errors\n");
  // Where that begins too far right, the column stands below.
  EXPECT_EQ(in_look("  scale  px  from 0 to 1000000  30  a factor\n", kNarrow),
            "  scale  px  from 0 to 1000000  30\n      a factor\n");
  // Without columns it goes on at the margin, and a word that is too long stays whole.
  EXPECT_EQ(in_look("all words of this line are of one column and many\n", kNarrow),
            "all words of this line are of one column\nand many\n");
  const std::string path(60, 'x');
  EXPECT_EQ(in_look("report: " + path + "\n", kNarrow), "report:\n" + path + "\n");
  const std::string table = "| " + std::string(60, '-') + " | a table of Markdown |\n";
  EXPECT_EQ(in_look(table, kNarrow), table);
}

TEST(Terminal, HeadsAreBoldAndVerdictsColoured) {
  EXPECT_EQ(in_look("\nheading\nname\n────\nrow 1\n", kColours),
            "\n\033[1mheading\033[0m\n\033[1mname\033[0m\n────\nrow 1\n");
  EXPECT_EQ(in_look("noise 1  worse  +3 %\n", kColours), "noise 1  \033[31mworse\033[0m  +3 %\n");
  EXPECT_EQ(in_look("failed: lspe 3\n", kColours), "\033[31mfailed: lspe 3\033[0m\n");
  EXPECT_EQ(in_look("warning: old\n", kColours), "\033[33mwarning: old\033[0m\n");
  EXPECT_EQ(in_look("worsening\n", kColours), "worsening\n");
}

// `script` gives the program a terminal of so many columns.
std::string in_terminal(const std::string& settings, const std::string& arguments) {
  return run_shell(fmt::format("script -qec \"stty cols 80; {} {} {}\" /dev/null </dev/null",
                               settings, SIGHTLINE_PROGRAM, arguments))
      .output;
}

// False where there is no `script`, or no pseudo-terminal for it, as in a tree without /dev/pts.
bool has_terminals() {
  return run_shell("script -qec true /dev/null </dev/null").exit_code == 0;
}

TEST(Terminal, TheProgramHasColoursInOneAlone) {
  if (!has_terminals()) GTEST_SKIP() << "`script` makes no terminal here";
  const std::string study = "study orientation-points --plan 0.5 --trials 2 --quiet";
  const std::string coloured = in_terminal("TERM=xterm", study);
  EXPECT_THAT(coloured, HasSubstr("\033[1m"));
  EXPECT_THAT(in_terminal("TERM=xterm NO_COLOR=1", study), Not(HasSubstr("\033")));
  EXPECT_THAT(in_terminal("TERM=dumb", study), Not(HasSubstr("\033")));
  EXPECT_THAT(run(study).output, Not(HasSubstr("\033")));
}

TEST(Terminal, APictureIsSentInPiecesThatTheProtocolTakes) {
  const std::string png(4000, 'x');  // 5336 letters: one piece of 4096 and the rest
  const std::string sent = terminal_picture(png);
  EXPECT_TRUE(sent.starts_with("\033_Ga=T,f=100,q=2,m=1;"));
  EXPECT_THAT(sent, HasSubstr("\033\\\033_Gm=0;"));
  EXPECT_TRUE(sent.ends_with("\033\\\n"));
  EXPECT_TRUE(terminal_picture("one").starts_with("\033_Ga=T,f=100,q=2,m=0;b25l"));
  EXPECT_FALSE(shows_pictures()) << "a test's standard output is no terminal";
}

TEST(Terminal, ATargetIsShownWhereTheTerminalSaysThatItCan) {
  if (!has_terminals()) GTEST_SKIP() << "`script` makes no terminal here";
  EXPECT_THAT(in_terminal("TERM=xterm-kitty TMUX= STY=", "list cube"), HasSubstr("\033_Ga=T"));
  EXPECT_THAT(in_terminal("TERM=xterm-kitty TMUX=1", "list cube"), Not(HasSubstr("\033_G")));
  EXPECT_THAT(in_terminal("TERM=xterm TMUX= STY=", "list cube"), Not(HasSubstr("\033_G")));
  EXPECT_THAT(in_terminal("TERM=xterm-kitty TMUX= STY=", "list lspe"), Not(HasSubstr("\033_G")));
}

TEST(Terminal, NoLineOfTheListsIsWiderThanIt) {
  if (!has_terminals()) GTEST_SKIP() << "`script` makes no terminal here";
  for (const char* list : {"list", "list keys image", "list measures", "target cube"}) {
    std::istringstream lines(in_terminal("NO_COLOR=1", list));
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const auto characters =
          std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      EXPECT_LE(characters, 80) << line;
    }
  }
}

}  // namespace
}  // namespace sightline
