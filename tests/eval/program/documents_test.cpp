// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the documents tell their readers to type.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A block of a page between two lines of ```, and the line of words before it.
struct Block {
  std::string before;
  std::vector<std::string> lines;
};

std::vector<Block> blocks_of(const fs::path& page) {
  std::vector<Block> blocks;
  std::ifstream stream(page);
  std::string before;
  bool is_inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("```")) {
      is_inside = !is_inside;
      if (is_inside) blocks.push_back({before, {}});
      before.clear();
    } else if (is_inside) {
      blocks.back().lines.push_back(line);
    } else if (!line.empty()) {
      before = line;
    }
  }
  return blocks;
}

// The file that a block is to be written as: "... Write this as `block.obj`:".
std::string file_of(const Block& block) {
  const std::string mark = " as `";
  const size_t begin = block.before.rfind(mark);
  if (begin == std::string::npos || !block.before.ends_with("`:")) return {};
  return block.before.substr(begin + mark.size(), block.before.size() - begin - mark.size() - 2);
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::vector<fs::path> pages() {
  const fs::path root = SIGHTLINE_SOURCE_DIR;
  std::vector<fs::path> found = {root / "README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  }
  return found;
}

// The options that a command's help shows; none where there is no such command, for which the
// program shows its own.
std::set<std::string> options_of(const std::string& command) {
  std::set<std::string> options;
  std::istringstream help(run(command + " --help").output);
  for (std::string word; help >> word;) {
    for (std::string part; const char c : word + ",") {
      if (c == ',' || c == ':' || c == '=') {
        if (part.starts_with("--")) options.insert(part);
        part.clear();
      } else {
        part += c;
      }
    }
  }
  return options.contains("--version") ? std::set<std::string>() : options;
}

std::string without_comment(const std::string& line) {
  const size_t comment = line.find(" # ");
  return line.substr(0, comment);
}

TEST(Documents, TheTutorialsCommandsRunAsTheyStand) {
  const TemporaryFolder folder;
  const fs::path program = SIGHTLINE_PROGRAM;
  const std::string here = fmt::format("cd '{}' && PATH='{}':$PATH && ", folder.path().string(),
                                       program.parent_path().string());
  int commands = 0, files = 0;
  for (const Block& block : blocks_of(fs::path(SIGHTLINE_SOURCE_DIR) / "docs/tutorial.md")) {
    if (const std::string file = file_of(block); !file.empty()) {
      folder.write(file, joined(block.lines));
      ++files;
      continue;
    }
    for (const std::string& line : block.lines) {
      ASSERT_TRUE(line.starts_with("sightline ")) << line << " is neither a file's nor a command";
      const Outcome outcome = run_shell(here + line);
      EXPECT_EQ(outcome.exit_code, 0) << line << "\n" << outcome.output;
      ++commands;
    }
  }
  EXPECT_EQ(files, 3);
  EXPECT_GE(commands, 14);
  EXPECT_TRUE(fs::exists(folder.path() / "demo/report.html"));
  EXPECT_TRUE(fs::exists(folder.path() / "block/features.png"));
  EXPECT_THAT(read_whole(folder.path() / "process/results.csv"), HasSubstr("mine"));
  EXPECT_THAT(read_whole(folder.path() / "observations/study.toml"), HasSubstr("net"));
}

// `./dev docs --check` on a page whose every piece is true, and on one whose every piece is not.
TEST(Documents, AreCheckedByAScriptThatFindsWhatIsUntrue) {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& page, const std::string& text) {
    folder.write(page, text);
    return run_shell(fmt::format(
        "/usr/bin/python3 '{0}/tests/docs/check_pages.py' '{1}' '{2}/run' '{2}/{3}' 2>&1",
        SIGHTLINE_SOURCE_DIR, SIGHTLINE_PROGRAM, folder.path().string(), page));
  };
  const std::string figures = "| a | b | c |\n|---|---|---|\n| x | 1 | 2 |\n| y | 3 | 4 |\n";
  const Outcome good = check("good.md",
                             "# A page\n[here](#a-page)\n<!-- exit code 1 -->\n"
                             "```\nsightline list nothing\n```\n"
                             "<!-- printed by: sightline list methods -->\n```\nmethods\n...\n```\n"
                             "`sightline list keys noise` has `noise.scale`.\n"
                             "<!-- not run: none are measured -->\n" +
                                 figures);
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output, HasSubstr("3 commands run, 0 failures"));
  const Outcome bad = check("bad.md",
                            "# A page\n[here](#no-page) [there](nowhere.md)\n"
                            "```\nsightline list nothing\n```\n"
                            "<!-- printed by: sightline list methods -->\n```\nsolvers\n```\n"
                            "`sightline list keys nois` has `noise.scales`.\n\n" +
                                figures);
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_THAT(bad.output, HasSubstr("3 commands run, 7 failures")) << bad.output;
}

TEST(Documents, NameNoCommandAndNoOptionThatIsNotThere) {
  std::map<std::string, std::set<std::string>> options;
  int seen = 0;
  for (const fs::path& page : pages()) {
    for (const Block& block : blocks_of(page)) {
      for (const std::string& line : block.lines) {
        if (!line.starts_with("sightline ")) continue;
        std::istringstream words(without_comment(line));
        std::string program, command;
        words >> program >> command;
        if (command.starts_with("-")) continue;
        if (!options.contains(command)) options[command] = options_of(command);
        EXPECT_FALSE(options[command].empty()) << page << ": " << line;
        for (std::string word; words >> word;) {
          if (!word.starts_with("--")) continue;
          const std::string name = word.substr(0, word.find('='));
          EXPECT_TRUE(options[command].contains(name)) << page << ": " << line;
          ++seen;
        }
      }
    }
  }
  EXPECT_GT(seen, 50);
  EXPECT_TRUE(options["study"].contains("--trials"));
  EXPECT_FALSE(options["study"].contains("--trails"));
  EXPECT_TRUE(options_of("stduy").empty());
}

TEST(Documents, ThePagesOfTheManualAndTheCompletionsAreWellFormed) {
  const TemporaryFolder folder;
  const auto path = [&](const std::string& name) { return (folder.path() / name).string(); };
  EXPECT_EQ(run("manual --into " + path("man")).exit_code, 0);
  const std::string page = read_whole(folder.path() / "man/sightline-study.1");
  EXPECT_EQ(page, run("manual study").output);
  EXPECT_THAT(page, HasSubstr("\n\\fB\\-\\-trials\\fR \\fIINT\\fR\n"));
  EXPECT_THAT(run("manual stduy").output, HasSubstr("did you mean 'study'"));
  for (const auto& entry : fs::directory_iterator(folder.path() / "man")) {
    // groff warns of a macro that it does not know.
    EXPECT_EQ(run_shell(fmt::format("groff -man -ww -z '{}' 2>&1", entry.path().string())).output,
              "");
  }
  folder.write("words.sh", run("completions bash").output + R"(
complete_at() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _sightline; echo "${COMPREPLY[*]}"; }
complete_at sightline stu
complete_at sightline study --tri
complete_at sightline study --gl e
)");
  EXPECT_EQ(run_shell("bash " + path("words.sh")).output, "study\n--trials\negl\n");
  EXPECT_THAT(run("completions zsh").output, HasSubstr("#compdef sightline"));
  EXPECT_THAT(run("completions fish").output, HasSubstr("-l trials -r -d"));
}

TEST(Documents, TheLicencesAreOfThePackagesThatTheBuildInstalls) {
  const std::string licences = run("doctor --licences").output;
  std::istringstream words(read_whole(fs::path(SIGHTLINE_SOURCE_DIR) / "dev"));
  std::string begin;
  while (begin != "packages=(" && words >> begin) {
  }
  int listed = 0;
  for (std::string word; words >> word && word != "test_packages=(";) {
    const bool is_library = word.ends_with("-dev") || word == "libjs-chart.js";
    // Python's own, and what only begins a driver that is loaded when it is asked for.
    if (!is_library || word == "python3-dev" || word == "libegl-dev") continue;
    EXPECT_THAT(licences, HasSubstr(" " + word + " "));
    ++listed;
  }
  EXPECT_EQ(lines_of(licences), listed + 2) << "one that is not installed is listed";
}

TEST(Documents, AnEntryOfAListIsSaidWhole) {
  EXPECT_THAT(run("list boeing-table1").output, HasSubstr("sightline study boeing-table1"));
  EXPECT_THAT(run("list cube").output, HasSubstr("vertex"));
  EXPECT_THAT(run("list orpe").output, HasSubstr("solver"));
  EXPECT_THAT(run("list fast").output, HasSubstr("method"));
  EXPECT_THAT(run("list boeing-tabel1").output, HasSubstr("did you mean 'boeing-table1'"));
}

TEST(Documents, TheFirstWordsAreFourCommands) {
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 8) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("sightline demo"));
}

TEST(Documents, AMisspeltCommandOrOptionIsToldWhatWasPerhapsMeant) {
  const Outcome command = run("stduy cube-noise");
  EXPECT_EQ(command.exit_code, 2);
  EXPECT_EQ(command.output,
            "sightline: 'stduy' is no command (did you mean 'study'?)\n"
            "sightline --help lists the commands\n");
  const Outcome option = run("study cube-noise --trails 3");
  EXPECT_EQ(option.exit_code, 2);
  EXPECT_THAT(option.output, HasSubstr("study has no option --trails (did you mean '--trials'?)"));
  EXPECT_THAT(option.output, HasSubstr("sightline study --help"));
  EXPECT_THAT(run("study").output, HasSubstr("sightline: study: study is required"));
  EXPECT_EQ(run("study --help").exit_code, 0);
}

}  // namespace
}  // namespace sightline
