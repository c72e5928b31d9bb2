// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The formats of data sets: their folders hold what their catalogues name.
#include "eval/datasets/set_readers.h"

#include <filesystem>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "eval/image_sets/set_format.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::set<std::string> files_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
    names.insert(entry.path().stem().string());
  }
  return names;
}

template <typename Formats>
std::set<std::string> names_of(const Formats& formats) {
  std::set<std::string> names;
  for (const auto& format : formats) names.emplace(format.name);
  return names;
}

TEST(SetReaders, AreTheFilesOfTheirFolder) {
  EXPECT_EQ(names_of(set_readers()), files_in("eval/datasets/readers"));
}

TEST(SetFormats, AreTheFilesOfTheirFolder) {
  EXPECT_EQ(names_of(set_formats()), files_in("eval/image_sets/formats"));
}

TEST(SetReaders, AreChosenByWhatTheFolderHolds) {
  const TemporaryFolder folder;
  SightingSource source;
  source.folder = folder.path();
  EXPECT_EQ(set_reader_of(source).name, "bop");
  folder.write("mine.json", "[]");
  EXPECT_EQ(set_reader_of(source).name, "bop");
  source.split = "mine";
  EXPECT_EQ(set_reader_of(source).name, "speed");
  source.split = "";
  folder.write("train.json", "[]");
  EXPECT_EQ(set_reader_of(source).name, "speed");
}

}  // namespace
}  // namespace sightline
