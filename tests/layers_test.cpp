// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Guards the arrows of the house by reading the #include lines: between the folders at the top, and
// between the rooms (the folders) within eval/, scenes/ and pose/. To add a room, give it a line in
// the map of its folder; to let a room see another, name that in its line. The order of the lines
// does not matter, but no room may see itself by way of others. It also guards the size of files
// and of the folders of tests.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <istream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
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
    {"registration", {"registration", "features", "renderer", "scenes", "pose"}},
    {"eval", {"eval", "registration", "features", "renderer", "scenes", "pose"}},
    {"python", {"python", "eval", "registration", "features", "renderer", "scenes", "pose"}},
};

/// The rooms within a folder and which other rooms of the folder each may include.
using Rooms = std::map<std::string, std::set<std::string>>;

const Rooms kEvalRooms = {
    {"benchmarks", {"datasets", "doors", "study", "trial", "work"}},
    {"program",
     {"compare", "image_sets", "output", "report", "results", "review", "run", "score", "study",
      "summary", "tables", "solve", "target", "work"}},
    {"review", {"output", "report", "statistics", "target"}},
    {"solve", {"datasets", "output"}},
    {"compare", {"output", "records", "results", "score", "statistics", "summary"}},
    {"score", {"datasets", "metrics", "output", "records", "report", "statistics"}},
    {"image_sets", {"datasets", "output", "study", "work"}},
    {"run",
     {"datasets", "doors", "output", "records", "report", "results", "statistics", "study",
      "summary", "trial", "work"}},
    {"report",
     {"output", "records", "statistics", "study", "summary", "tables", "target", "trial"}},
    {"tables", {"output", "study", "summary"}},
    {"target", {"output", "statistics", "study"}},
    {"summary", {"output", "records", "statistics", "study"}},
    {"results", {"output", "records", "study", "work"}},
    {"trial", {"datasets", "doors", "metrics", "records", "statistics", "study"}},
    {"study", {"datasets", "doors", "output", "records"}},
    {"doors", {"datasets", "output", "records", "work"}},
    {"records", {}},
    {"datasets", {"output", "records"}},
    {"metrics", {}},
    {"output", {}},
    {"work", {}},
    {"statistics", {}},
    {"jobs", {}},
};

/// The folders of python/ that hold sources: the extension module alone.
const Rooms kPythonRooms = {{"module", {}}};

const Rooms kScenesRooms = {
    {"builders", {"files", "mesh", "random", "target"}},
    {"camera", {"files"}},
    {"scene", {"camera", "files", "mesh", "picture", "random", "target"}},
    {"target", {"files", "mesh"}},
    {"mesh", {"files", "picture"}},
    {"picture", {"files"}},
    {"random", {}},
    {"files", {}},
};

/// The room of the files that lie in no room: those of pose/ itself.
const std::string kTop = ".";

const Rooms kPoseRooms = {
    {"entry", {"lines", "solvers", "consensus", kTop}},
    {"lines", {"solvers", "consensus", kTop, "kernels"}},
    {"solvers", {"consensus", kTop, "kernels"}},
    {"consensus", {kTop, "kernels", "lenses"}},
    {"orientation", {kTop, "kernels"}},
    {kTop, {"kernels", "lenses"}},
    {"kernels", {}},
    {"lenses", {}},
};

/// The lists of solvers and methods, which name what stands in the rooms above them.
const std::set<std::pair<std::string, std::string>> kCatalogues = {
    {"pose/solver.cpp", "solvers"},
    {"pose/solver.cpp", "lines"},
    {"pose/absolute_orientation.cpp", "orientation"},
    {"pose/robust_alignment.cpp", "orientation"},
};

// Libraries that are slow to compile or tied to a platform: only .cpp files may name them.
const std::vector<std::string> kHeavy = {
    "osmesa.h", "assimp/",   "CGAL/",   "tiny_gltf",     "SQLite",   "toml++",
    "mustache", "Random123", "pugixml", "png.h",         "tiffio",   "turbojpeg",
    "webp/",    "stb/",      "draco/",  "meshoptimizer", "yaml-cpp", "OpenEXR/"};

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
  EXPECT_FALSE(is_allowed("eval", {"eval/x.cpp", "python/module/arrays.h", true}));
  EXPECT_TRUE(is_allowed("pose", {"pose/x.cpp", "Eigen/Core", false}));
  EXPECT_TRUE(is_heavy({"scenes/x.h", "assimp/scene.h", false}));
}

std::string room_of(const fs::path& path_in_source) {
  auto part = std::next(path_in_source.begin());
  return std::next(part) == path_in_source.end() ? kTop : part->string();
}

/// How functions are compiled for several processors: it includes nothing, and kernels need it.
const std::string kMultiversion = "pose/multiversion.h";

/// What is wrong with an include within one folder; empty where it follows the arrows.
std::string problem_with(const fs::path& file, const std::string& included, const Rooms& rooms) {
  const std::string from = room_of(file);
  const std::string to = room_of(included);
  if (!rooms.contains(from)) return file.string() + " lies in no room that is listed";
  if (from == to || rooms.at(from).contains(to) || included == kMultiversion) return "";
  if (kCatalogues.contains({file.string(), to})) return "";
  return file.string() + " includes \"" + included + "\", but " + from + " may not see " + to;
}

/// Whether a room is reached from those it may see.
bool sees_itself(const std::string& room, const Rooms& rooms) {
  std::vector<std::string> to_visit(rooms.at(room).begin(), rooms.at(room).end());
  std::set<std::string> visited;
  while (!to_visit.empty()) {
    const std::string next = to_visit.back();
    to_visit.pop_back();
    if (next == room) return true;
    if (!visited.insert(next).second) continue;
    const std::set<std::string>& seen = rooms.at(next);
    to_visit.insert(to_visit.end(), seen.begin(), seen.end());
  }
  return false;
}

void expect_rooms(const std::string& folder, const Rooms& rooms) {
  for (const Include& include : includes_below(folder)) {
    if (first_folder(include.name) != folder) continue;
    const fs::path file = fs::relative(include.file, SIGHTLINE_SOURCE_DIR);
    EXPECT_EQ(problem_with(file, include.name, rooms), "");
  }
  for (const auto& [room, seen] : rooms) {
    EXPECT_FALSE(sees_itself(room, rooms)) << folder << "/" << room;
    EXPECT_TRUE(fs::is_directory(fs::path(SIGHTLINE_SOURCE_DIR) / folder / room)) << room;
  }
}

TEST(Layers, RoomsFollowTheirArrows) {
  expect_rooms("eval", kEvalRooms);
  expect_rooms("scenes", kScenesRooms);
  expect_rooms("pose", kPoseRooms);
  expect_rooms("python", kPythonRooms);
}

TEST(Layers, AForbiddenArrowBetweenRoomsWouldBeSeen) {
  EXPECT_NE(problem_with("eval/study/x.cpp", "eval/report/page.h", kEvalRooms), "");
  EXPECT_NE(problem_with("eval/x.cpp", "eval/report/page.h", kEvalRooms), "");
  EXPECT_NE(problem_with("eval/attic/x.cpp", "eval/report/page.h", kEvalRooms), "");
  EXPECT_NE(problem_with("pose/reprojection.cpp", "pose/solvers/solvers.h", kPoseRooms), "");
  EXPECT_EQ(problem_with("pose/solver.cpp", "pose/solvers/solvers.h", kPoseRooms), "");
  EXPECT_EQ(problem_with("eval/run/run.cpp", "eval/report/report.h", kEvalRooms), "");
  EXPECT_TRUE(sees_itself("a", {{"a", {"b"}}, {"b", {"c"}}, {"c", {"a"}}}));
  EXPECT_FALSE(sees_itself("a", {{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {}}}));
}

/// eval/ and scenes/ are rooms alone: a loose file belongs to none, and so to nobody.
TEST(Layers, NoSourceFileLiesOutsideARoom) {
  for (const std::string folder : {"eval", "scenes"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension();
      EXPECT_TRUE(extension != ".h" && extension != ".cpp") << entry.path();
    }
  }
}

/// Every file of our folders and of the tests that the compiler reads.
std::vector<fs::path> source_files() {
  std::vector<std::string> folders = {"tests"};
  for (const auto& [folder, allowed] : kAllowed) folders.push_back(folder);
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp") files.push_back(entry.path());
    }
  }
  return files;
}

/// A longer file holds more than one subject, of which each deserves a file.
constexpr int kMostLines = 500;
/// Of more files in one folder nobody sees which belong together.
constexpr int kMostTestFiles = 15;

int lines_in(std::istream& stream) {
  return static_cast<int>(std::count(std::istreambuf_iterator<char>(stream), {}, '\n'));
}

TEST(Layers, NoSourceFileIsLong) {
  const std::vector<fs::path> files = source_files();
  EXPECT_GT(files.size(), 100u) << "are these all the files?";
  for (const fs::path& file : files) {
    std::ifstream stream(file);
    EXPECT_LE(lines_in(stream), kMostLines) << file;
  }
}

TEST(Layers, LinesAreCounted) {
  std::istringstream text("a\nb\n\n");
  EXPECT_EQ(lines_in(text), 3);
}

/// Only the files that lie in the folder itself count; folders within it are counted for
/// themselves.
TEST(Layers, NoFolderOfTestsHoldsManyFiles) {
  std::map<fs::path, int> files_in;
  for (const fs::path& file : source_files()) ++files_in[file.parent_path()];
  const fs::path tests = fs::path(SIGHTLINE_SOURCE_DIR) / "tests";
  EXPECT_TRUE(files_in.contains(tests));
  for (const auto& [folder, files] : files_in) {
    const bool is_of_tests = fs::relative(folder, tests).string().substr(0, 2) != "..";
    if (!is_of_tests) continue;
    EXPECT_LE(files, kMostTestFiles) << folder;
  }
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
             ? include.name.starts_with("pose/kernels/") || include.name == kMultiversion
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
      // Scenes are drawn from numbers; what is a picture in them stands in one room.
      const bool is_image = include.name.starts_with("opencv2/");
      const bool may_be = folder != "scenes" || include.file.parent_path().filename() == "picture";
      EXPECT_TRUE(!is_image || may_be) << include.file << " includes " << include.name;
    }
  }
}

/// The types that a file defines for others, each with its namespace: not those of `namespace {`.
std::set<std::string> types_in(std::istream& file) {
  std::set<std::string> types;
  std::vector<std::string> spaces;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (second == "class") words >> second;
    if (first == "namespace" && line.ends_with("{")) {
      spaces.push_back(second);
    } else if (line.starts_with("}  // namespace")) {
      if (!spaces.empty()) spaces.pop_back();
    } else if ((first == "struct" || first == "class" || first == "enum") && line[0] != ' ' &&
               line.ends_with("{") && (spaces.empty() || spaces.back() != "{")) {
      std::string name;
      for (const std::string& space : spaces) name += space + "::";
      types.insert(name + second);
    }
  }
  return types;
}

// Two types of one name share their templates when they are linked: a vector of the one was given
// memory for the other, which is smaller.
TEST(Layers, ATypesNameIsOfOneFile) {
  std::map<std::string, fs::path> files;
  std::vector<std::string> folders = {"tests"};
  for (const auto& [folder, allowed] : kAllowed) folders.push_back(folder);
  for (const std::string& folder : folders) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream stream(entry.path());
      for (const std::string& type : types_in(stream)) {
        const auto [found, is_new] = files.emplace(type, entry.path());
        EXPECT_TRUE(is_new) << type << " is in " << found->second << " and in " << entry.path();
      }
    }
  }
  EXPECT_TRUE(files.contains("sightline::EdgePoint"));
  std::istringstream hidden("namespace a {\nnamespace {\nstruct B {\n}  // namespace\nclass C {");
  EXPECT_EQ(types_in(hidden), std::set<std::string>{"a::C"});
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
