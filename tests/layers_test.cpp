// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Guards the arrows of the house by reading the #include lines.
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> kAllowed = {
    {"pose", {"pose"}},
    {"scenes", {"scenes", "pose"}},
    {"renderer", {"renderer", "scenes", "pose"}},
    {"features", {"features", "scenes", "pose"}},
    {"eval", {"eval", "features", "renderer", "scenes", "pose"}},
};

// Libraries that are slow to compile or tied to a platform: only .cpp files may name them.
const std::vector<std::string> kHeavy = {"osmesa.h", "assimp/", "CGAL/",    "tiny_gltf",
                                         "SQLite",   "toml++",  "mustache", "Random123"};

struct Include {
  fs::path file;
  std::string name;
  bool is_quoted;
};

std::vector<Include> includes_in(const fs::path& file) {
  std::vector<Include> includes;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("#include ")) continue;
    const size_t begin = line.find_first_of("<\"");
    const size_t end = line.find_last_of(">\"");
    includes.push_back({file, line.substr(begin + 1, end - begin - 1), line[begin] == '"'});
  }
  return includes;
}

std::vector<Include> includes_below(const std::string& folder) {
  std::vector<Include> includes;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
    const std::string extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    for (Include& include : includes_in(entry.path())) includes.push_back(std::move(include));
  }
  return includes;
}

std::string first_folder(const std::string& include) {
  return include.substr(0, include.find('/'));
}

// Angle brackets do not make one of our folders a library.
bool is_allowed(const std::string& folder, const Include& include) {
  const std::string first = first_folder(include.name);
  const bool is_ours = include.is_quoted || kAllowed.contains(first);
  return !is_ours || kAllowed.at(folder).contains(first);
}

bool is_heavy(const Include& include) {
  for (const std::string& library : kHeavy) {
    if (include.name.find(library) != std::string::npos) return true;
  }
  return false;
}

TEST(Layers, IncludesFollowTheArrows) {
  for (const auto& [folder, allowed] : kAllowed) {
    const auto includes = includes_below(folder);
    ASSERT_FALSE(includes.empty()) << folder;
    for (const Include& include : includes) {
      EXPECT_TRUE(is_allowed(folder, include)) << include.file << " includes \"" << include.name
                                               << "\": " << folder << "/ may not reach there";
    }
  }
}

TEST(Layers, AForbiddenArrowWouldBeSeen) {
  EXPECT_FALSE(is_allowed("features", {"features/x.cpp", "renderer/frame.h", true}));
  EXPECT_FALSE(is_allowed("features", {"features/x.cpp", "renderer/frame.h", false}));
  EXPECT_FALSE(is_allowed("pose", {"pose/x.cpp", "scenes/mesh.h", true}));
  EXPECT_TRUE(is_allowed("pose", {"pose/x.cpp", "Eigen/Core", false}));
  EXPECT_TRUE(is_heavy({"scenes/x.h", "assimp/scene.h", false}));
}

TEST(Layers, PoseNeedsNothingButEigen) {
  for (const Include& include : includes_below("pose")) {
    // The comparator that CMake's SIGHTLINE_POSE_OPENCV leaves out.
    if (include.file.filename() == "opencv_ransac.cpp") continue;
    const bool is_standard = include.name.find_first_of("/.") == std::string::npos;
    EXPECT_TRUE(include.is_quoted || is_standard || include.name.starts_with("Eigen/"))
        << include.file << " includes <" << include.name << ">";
  }
}

/// They are compiled for several processors, which Eigen must not be.
bool is_fit_for_kernels(const Include& include) {
  return include.is_quoted
             ? include.name.starts_with("pose/kernels/") || include.name == "pose/multiversion.h"
             : include.name.find_first_of("/.") == std::string::npos;
}

TEST(Layers, KernelsIncludeNoEigen) {
  for (const Include& include : includes_below("pose/kernels")) {
    EXPECT_TRUE(is_fit_for_kernels(include)) << include.file << " includes " << include.name;
  }
  EXPECT_FALSE(is_fit_for_kernels({"a.cpp", "Eigen/Core", false}));
  EXPECT_FALSE(is_fit_for_kernels({"a.cpp", "pose/pose.h", true}));
}

TEST(Layers, PublicHeadersAreLight) {
  for (const auto& [folder, allowed] : kAllowed) {
    for (const Include& include : includes_below(folder)) {
      if (include.file.extension() != ".h") continue;
      EXPECT_FALSE(is_heavy(include)) << include.file << " includes " << include.name;
      const bool is_image = include.name.starts_with("opencv2/");
      EXPECT_FALSE(is_image && folder == "scenes") << include.file << " includes " << include.name;
    }
  }
}

TEST(Layers, EveryFileSaysItsLicence) {
  for (const auto& [folder, allowed] : kAllowed) {
    const std::string licence = folder == "pose" ? "Apache-2.0" : "GPL-3.0-or-later";
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream stream(entry.path());
      std::string first, second;
      std::getline(stream, first);
      std::getline(stream, second);
      EXPECT_TRUE(first.starts_with("// SPDX-FileCopyrightText: ")) << entry.path();
      EXPECT_EQ(second, "// SPDX-License-Identifier: " + licence) << entry.path();
    }
  }
}

}  // namespace
