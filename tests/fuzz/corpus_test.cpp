// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Replays what the fuzzers start from, and what they once found.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "tests/fuzz/targets.h"

namespace sightline {
namespace {

void replay(const std::string& target, void (*fuzz)(std::string_view)) {
  int files = 0;
  const std::filesystem::path corpus = SIGHTLINE_SOURCE_DIR "/tests/fuzz/corpus";
  for (const auto& entry : std::filesystem::directory_iterator(corpus / target)) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    fuzz(bytes);
    for (size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 64) {
      fuzz(std::string_view(bytes).substr(0, size));
    }
    ++files;
  }
  EXPECT_GT(files, 0) << target;
}

TEST(FuzzCorpus, Soup) {
  replay("soup", fuzz_soup);
}

TEST(FuzzCorpus, Gltf) {
  replay("gltf", fuzz_gltf);
}

TEST(FuzzCorpus, Toml) {
  replay("toml", fuzz_toml);
}

TEST(FuzzCorpus, Picture) {
  replay("picture", fuzz_picture);
}

TEST(FuzzCorpus, Radiance) {
  replay("radiance", fuzz_radiance);
}

TEST(FuzzCorpus, Json) {
  replay("json", fuzz_json);
}

TEST(FuzzCorpus, Csv) {
  replay("csv", fuzz_csv);
}

TEST(FuzzCorpus, Model) {
  replay("model", fuzz_model);
}

TEST(FuzzCorpus, Answer) {
  replay("answer", fuzz_answer);
}

}  // namespace
}  // namespace sightline
