// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/verify.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <unordered_set>

#include <fmt/format.h>

#include "eval/image_sets/join.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "eval/work/interrupt.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class Verifier {
 public:
  Verifier(const fs::path& folder, const std::function<void(const std::string&)>& tell)
      : folder_(folder), plan_(read_plan(folder)), tell_(tell) {
    for (const char* file : {"sightline.json", "scene.toml", ".lock"}) expect_file(file);
  }

  SetVerdict run(const std::function<void(int64_t)>& tick) {
    verdict_.images = plan_.count;
    if (!has_plain_files_alone()) return verdict_;
    std::string list(kListBegin);
    bool is_first = true;
    for (int64_t chunk = 0; chunk < plan_.chunk_count(); ++chunk) {
      const std::vector<Json> truths = check_images(chunk, tick);
      for (const SetFile& file : plan_.format->chunk_files(plan_, chunk, truths)) {
        check_text(file.path, file.bytes);
      }
      const std::string lines = list_lines(plan_, truths, is_first);
      is_first = is_first && lines.empty();
      list += lines;
    }
    check_text(std::string(plan_.format->list_path), list + std::string(kListEnd));
    for (const SetFile& file : plan_.format->set_files(plan_)) check_text(file.path, file.bytes);
    check_nothing_else();
    return verdict_;
  }

 private:
  void problem(const std::string& text) {
    ++verdict_.problems;
    tell_(text);
  }

  // Before any of it is opened: behind a link may be what is not of the set, and a pipe never ends.
  bool has_plain_files_alone() {
    const fs::path root = fs::canonical(folder_);
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      std::error_code error;
      const std::string path = entry.path().lexically_relative(folder_).string();
      if (!entry.is_regular_file(error) && !entry.is_directory(error)) {
        problem(fmt::format("{}: is neither a file nor a folder", path));
      } else if (entry.is_symlink() && !is_within(fs::canonical(entry.path(), error), root)) {
        problem(fmt::format("{}: is a link out of the set, which is not followed", path));
      }
    }
    return verdict_.problems == 0;
  }

  static bool is_within(const fs::path& path, const fs::path& root) {
    const fs::path relative = path.lexically_relative(root);
    return !relative.empty() && *relative.begin() != "..";
  }

  void expect_file(const std::string& path) { expected_.insert(hash_(path)); }

  // The truths of a chunk's images that can be read, less those of images that could not be made.
  std::vector<Json> check_images(int64_t chunk, const std::function<void(int64_t)>& tick) {
    std::vector<Json> truths;
    const int64_t end = std::min(plan_.count, (chunk + 1) * plan_.chunk);
    for (int64_t index = chunk * plan_.chunk; index < end; ++index) {
      stop_if_interrupted();
      std::optional<Json> truth = check_image(index);
      if (truth) truths.push_back(std::move(*truth));
      tick(1);
    }
    return truths;
  }

  std::optional<Json> check_image(int64_t index) {
    const std::string path = truth_path(plan_, index);
    expect_file(path);
    for (const std::string& file : truth_file_paths(plan_, index)) expect_file(file);
    std::error_code none;
    if (!fs::exists(folder_ / path, none)) {
      ++verdict_.missing;
      problem(fmt::format("image {}: is missing ({})", index, path));
      return std::nullopt;
    }
    std::optional<Json> truth = read_truth(folder_, plan_, index);
    if (!truth) {
      problem(fmt::format("{}: is torn or was changed", path));
      return std::nullopt;
    }
    try {
      if (!check_parts(index, *truth)) return std::nullopt;
      add_told_by_files(folder_, plan_, *truth);  // whether they can be read is told already
      return truth;
    } catch (const Json::exception&) {
      problem(fmt::format("{}: lacks what a truth tells", path));
      return std::nullopt;
    }
  }

  // False for an image that is none.
  bool check_parts(int64_t index, const Json& truth) {
    std::vector<std::string> paths;
    const bool is_failure = truth.contains("failure");
    if (!is_failure) paths = plan_.format->image_paths(plan_, truth);
    for (const std::string& path : paths) expect_file(path);
    if (!is_failure) {
      for (const std::string& path : truth_file_paths(plan_, index)) paths.push_back(path);
    }
    bool is_whole = true;
    for (const std::string& path : paths) {
      std::error_code none;
      if (fs::exists(folder_ / path, none)) continue;
      is_whole = false;
      problem(fmt::format("{}: is missing", path));
    }
    if (!is_whole) ++verdict_.missing;
    const std::string path = truth_path(plan_, index);
    for (const std::string& wrong : truth_problems(folder_, plan_, truth, index)) {
      problem(fmt::format("{}: {}", path, wrong));
    }
    if (is_failure) return false;
    if (!is_whole) return true;
    std::vector<std::string> wrongs = plan_.format->image_problems(plan_, folder_, truth);
    if (wrongs.empty()) wrongs = checksum_problems(folder_, truth, paths);
    for (const std::string& wrong : wrongs) problem(fmt::format("image {}: {}", index, wrong));
    return true;
  }

  void check_text(const std::string& path, const std::string& text) {
    expect_file(path);
    std::error_code none;
    if (!fs::exists(folder_ / path, none)) return problem(fmt::format("{}: is missing", path));
    const std::optional<std::string> there = bytes_of_file(folder_ / path, kMostInputBytes);
    if (there != text) problem(fmt::format("{}: is not what the set's truth says", path));
  }

  void check_nothing_else() {
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string path = entry.path().lexically_relative(folder_).string();
      const bool is_expected = expected_.contains(hash_(path));
      if (entry.is_directory() && is_expected) {
        problem(fmt::format("{}: is a folder, must be a file", path));
      } else if (!entry.is_directory() && !is_expected) {
        problem(fmt::format("{}: does not belong here", path));
      }
    }
  }

  const fs::path folder_;
  const SetPlan plan_;
  const std::function<void(const std::string&)>& tell_;
  SetVerdict verdict_;
  std::hash<std::string> hash_;
  std::unordered_set<size_t> expected_;  // hashes of paths: millions of paths would be gigabytes
};

}  // namespace

SetVerdict verify_set(const fs::path& folder, const std::function<void(const std::string&)>& tell,
                      const std::function<void(int64_t images)>& tick) {
  return Verifier(folder, tell).run(tick);
}

int64_t planned_images(const fs::path& folder) {
  return read_plan(folder).count;
}

}  // namespace sightline
