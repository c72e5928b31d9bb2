// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/plain_text.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "eval/output/csv_reader.h"
#include "eval/output/html.h"
#include "eval/output/json.h"
#include "eval/output/output_folder.h"
#include "eval/output/text_table.h"
#include "eval/report/gnuplot.h"
#include "scenes/files/input_file.h"
#include "scenes/files/toml_table.h"
#include "scenes/files/toml_text.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

TEST(PlainText, KeepsWordsOfAnyLanguage) {
  const std::string text = "Boeing 707, ±2 °, 飞机, 😀";
  EXPECT_EQ(plain_line(text), text);
  EXPECT_EQ(plain_text("a\n\tb\r\n"), "a\n\tb\r\n");
}

TEST(PlainText, ShowsWhatSteersInstead) {
  EXPECT_EQ(plain_line("a\nb"), "a\u240Ab");
  EXPECT_EQ(plain_line("\x1b[31m"), "\u241B[31m");
  EXPECT_EQ(plain_line("\x7f"), "\u2421");
  EXPECT_EQ(plain_line(std::string_view("\0", 1)), "\u2400");
  EXPECT_EQ(plain_line("\u0085\u2028"), "\uFFFD\uFFFD");
  EXPECT_EQ(plain_text("\x1b]0;title\x07"), "\u241B]0;title\u2407");
}

TEST(PlainText, IsUtf8WhateverTheBytes) {
  EXPECT_EQ(plain_line("\xff"), "\uFFFD");
  EXPECT_EQ(plain_line("caf\xe9"), "caf\uFFFD");
  EXPECT_EQ(plain_line("\xc0\xaf"), "\uFFFD\uFFFD") << "an overlong slash";
  EXPECT_EQ(plain_line("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half a surrogate pair";
  EXPECT_EQ(plain_line("\xf4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD") << "beyond Unicode";
  EXPECT_EQ(plain_line("\xe2\x82"), "\uFFFD\uFFFD") << "cut off";
}

TEST(PlainText, InOneLineHasNoNumberWithoutAnEnd) {
  const std::string forty(40, '7');
  EXPECT_EQ(in_one_line("is " + forty + ", must\nbe 1"), "is " + forty + ", must be 1");
  EXPECT_EQ(in_one_line("is 1" + std::string(300, '0') + ", must be 1"),
            "is 100000000000... (301 digits), must be 1");
  // But for those of names, which are copied from the line.
  const std::string name = "/data/" + std::string(45, '7') + "/a.csv: is missing";
  EXPECT_EQ(in_one_line(name), name);
  EXPECT_EQ(in_one_line(""), "");
}

TEST(PlainText, AsAWordOfAShellMeansItself) {
  EXPECT_EQ(shell_word("results/a-1.toml"), "results/a-1.toml");
  for (const std::string text : {"", "a b", "it's", "$(date)", "; exit 3 #", "a\nb", "*", "\\"}) {
    EXPECT_EQ(run_shell("printf %s " + shell_word(text)).output, text);
    EXPECT_TRUE(text == "a\nb" || is_harmless_command("sightline " + shell_word(text))) << text;
  }
}

TEST(PlainText, TellsHarmlessCommands) {
  EXPECT_TRUE(is_harmless_command("sightline study x --set 'a=[1, 2]' --out o"));
  for (const char* line : {"sightline; rm -rf ~ #", "a | b", "a && b", "$(a)", "`a`", "a > b",
                           "a\nb", "'a", "a\x1b", "a & b", "~", "a \\; b"}) {
    EXPECT_FALSE(is_harmless_command(line)) << line;
  }
}

TEST(PlainText, InMarkdownStaysInItsCell) {
  EXPECT_EQ(markdown_text("a|b\n<script>&`x` orpe_weighed"),
            "a\\|b\u240A&lt;script&gt;&amp;\\`x\\` orpe_weighed");
}

TEST(PlainText, OfTomlReadsBackTheSame) {
  for (const std::string text : {"", "it's", "a\"b\\c", "a\nb\tc", "\x7f", "run_1.000000000000"}) {
    EXPECT_EQ(TomlTable::read_text("a = " + toml_text(text), "test").text("a"), text);
  }
}

TEST(PlainText, GoesToGnuplotTerminalsAndPages) {
  Chart chart;
  chart.id = "c";
  chart.title = "one'\nsystem \"touch stolen\"\n#";
  chart.series.push_back({});
  chart.series.back().label = "label\nsystem \"touch stolen\"";
  const std::string script = gnuplot_script(chart);
  EXPECT_THAT(script, Not(HasSubstr("\nsystem")));
  EXPECT_THAT(gnuplot_data(chart), Not(HasSubstr("\nsystem")));
  EXPECT_THAT(text_block("heading", {"\x1b[2J"}, {{"", {{"a\nb", {"\x1b"}}}}}),
              Not(HasSubstr("\x1b")));
  EXPECT_EQ(escape_html("<\x1b>\n"), "&lt;\u241B&gt;\n");
}

TEST(Json, OfSomebodyIsBounded) {
  const TemporaryFolder folder;
  const auto nested = [&](int depth) {
    return folder.write("a.json", std::string(depth, '[') + std::string(depth, ']'));
  };
  EXPECT_EQ(error_of([&] { read_json(nested(50)); }), "");
  EXPECT_THAT(error_of([&] { read_json(nested(76000)); }), HasSubstr("is nested deeper than 100"));
  EXPECT_THAT(error_of([&] { read_json("/dev/zero"); }), HasSubstr("cannot be read"));
  EXPECT_THAT(error_of([&] { read_json(folder.path() / "none"); }), HasSubstr("is missing"));
}

// The bounds of a file are of gigabytes; small ones here show that each is kept, to the one.
TEST(Json, OfSomebodyHasSoManyValuesListsAndDepths) {
  const auto error = [](const std::string& text, const JsonBounds& bounds) {
    return error_of([&] { parse_json(text, "a.json", bounds); });
  };
  const std::string text = R"({"a": [1, "b", null, true], "c": [[2]]})";
  EXPECT_EQ(error(text, {.deepest = 3, .most_lists = 4, .most_values = 5}), "");
  EXPECT_THAT(error(text, {.deepest = 2}), HasSubstr("a.json: is nested deeper than 2"));
  EXPECT_THAT(error(text, {.most_lists = 3}), HasSubstr("has more than 3 lists and objects"));
  EXPECT_THAT(error(text, {.most_values = 4}), HasSubstr("a.json: has more than 4 values"));
}

// Every reader opens files one way: what never ends and what is too large is known before it is
// read.
TEST(InputFiles, AreRegularAndBounded) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::filesystem::path sparse = folder.write("sparse.csv", "a\n1\n");
  const auto read_all = [](const std::filesystem::path& file) {
    return error_of([&] {
      for (CsvReader reader(file); reader.next();) continue;
    });
  };
  EXPECT_EQ(read_all(sparse), "");
  EXPECT_THAT(read_all(pipe), HasSubstr("pipe.csv: is missing or cannot be read"));
  EXPECT_THAT(read_all("/dev/zero"), HasSubstr("/dev/zero: is missing or cannot be read"));
  std::filesystem::resize_file(sparse, kMostInputBytes + 1);  // of holes
  EXPECT_THAT(read_all(sparse), HasSubstr("sparse.csv: is larger than 1024 MiB"));
  EXPECT_THAT(error_of([&] { read_json(sparse); }), HasSubstr("is larger than 1024 MiB"));
  std::filesystem::resize_file(sparse, 400'000'000);  // a line that is not read to its end
  EXPECT_THAT(read_all(sparse), HasSubstr("line 3 is longer than 1048576 bytes"));
  EXPECT_THAT(error_of([&] { TomlTable::read_file(pipe, {}); }), HasSubstr("cannot be read"));
  EXPECT_THAT(error_of([&] { TomlTable::read_file(sparse, {}); }), HasSubstr("larger than 16 MiB"));
}

TEST(InputFiles, AreReadLineByLine) {
  std::istringstream stream("one\n\nthree");
  std::vector<std::string> lines;
  for (std::string line; read_bounded_line(stream, line);) lines.push_back(line);
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "", "three"}));
  std::istringstream none;
  std::string line;
  EXPECT_FALSE(read_bounded_line(none, line));
}

TEST(Toml, OfSomebodyIsBounded) {
  const auto dotted = [](int parts) {
    std::string key = "a";
    for (int i = 1; i < parts; ++i) key += ".a";
    return "b = 1\n" + key + " = 1\n";
  };
  EXPECT_EQ(error_of([&] { TomlTable::read_text(dotted(60), "s.toml"); }), "");
  EXPECT_THAT(error_of([&] { TomlTable::read_text(dotted(20000), "s.toml"); }),
              HasSubstr("s.toml:2: a key has over 65 parts"));
  // Texts are none of numbers' or keys' business.
  const std::string digits = "t = \"" + std::string(27000, '1') + "\"\n# " + std::string(99, '.');
  EXPECT_EQ(TomlTable::read_text(digits, "s.toml").text("t").size(), 27000u);
  const std::string texts = "a = \"run_1.000000000000\"\nb = 0.1500000000000000\n";
  const std::string written = TomlTable::read_text(texts, "s.toml").to_toml();
  EXPECT_THAT(written, HasSubstr("run_1.000000000000"));
  EXPECT_THAT(written, HasSubstr("b = 0.15\n"));
}

TEST(OutputFolders, LeaveAloneWhatIsNotTheirs) {
  const TemporaryFolder folder;
  const fs::path victim = folder.path() / "victim";
  fs::create_directories(victim);
  folder.write("victim/precious", "data");
  const fs::path asked = folder.path() / "out";
  fs::create_directory_symlink(victim, staging_folder(asked));
  EXPECT_THAT(error_of([&] { const OutputFolder made(asked); }), HasSubstr("is not ours"));
  EXPECT_TRUE(fs::exists(victim / "precious"));

  fs::remove(staging_folder(asked));
  fs::create_directories(staging_folder(asked));
  folder.write(".out.partial/notes", "data");
  EXPECT_THAT(error_of([&] { const OutputFolder made(asked); }), HasSubstr("is not ours"));
  EXPECT_TRUE(fs::exists(staging_folder(asked) / "notes"));

  fs::remove(staging_folder(asked) / "notes");
  EXPECT_EQ(error_of([&] { const OutputFolder made(asked); }), "") << "an empty one is";
}

TEST(OutputFolders, NeedAPlace) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { const OutputFolder made{fs::path()}; }), HasSubstr("is empty"));
  fs::create_symlink(folder.path() / "nothing", folder.path() / "link");
  EXPECT_THAT(error_of([&] { const OutputFolder made(folder.path() / "link"); }),
              HasSubstr("is a link"));
}

TEST(OutputFolders, WriteNothingThroughALink) {
  const TemporaryFolder folder;
  const fs::path precious = folder.write("precious", "data");
  fs::create_symlink(precious, folder.path() / "a.csv.partial");
  write_file(folder.path() / "a.csv", "text");
  EXPECT_EQ(read_whole(precious), "data");
  EXPECT_EQ(read_whole(folder.path() / "a.csv"), "text");
  EXPECT_FALSE(fs::is_symlink(folder.path() / "a.csv"));
}

}  // namespace
}  // namespace sightline
