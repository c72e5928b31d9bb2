// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/numbered.h"

#include <array>
#include <charconv>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "eval/datasets/bop/layout.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Those of the documentation first: a file of such a name is found at once. Times in nanoseconds
// have up to 19.
constexpr std::array kDigits = {6, 4, 8, 5, 3, 1, 2, 7, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
constexpr std::array kPictureEndings = {"png", "jpg", "jpeg", "tif", "tiff", "bmp", "webp",
                                        "PNG", "JPG", "JPEG", "TIF", "TIFF", "BMP", "WEBP"};

std::string joined(const std::vector<int64_t>& numbers, int digits) {
  std::string name;
  for (const int64_t number : numbers) {
    name += fmt::format("{}{:0{}}", name.empty() ? "" : "_", number, digits);
  }
  return name;
}

int64_t whole_number(const std::string& text) {
  if (const auto number = number_of(text)) return *number;
  throw InputError(
      fmt::format("'{}' is no id, which must be a whole number below 2^63", text.substr(0, 40)));
}

}  // namespace

std::optional<int64_t> number_of(const std::string& text) {
  int64_t value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= 0) return value;
  return std::nullopt;
}

std::optional<int> scene_number_of(const std::string& text) {
  const auto number = number_of(text);
  if (!number || *number > std::numeric_limits<int>::max()) return std::nullopt;
  return static_cast<int>(*number);
}

NumberedEntries::NumberedEntries(const Json& object) {
  if (!object.is_object()) throw InputError("must be an object whose keys are numbers");
  for (const auto& [key, entry] : object.items()) {
    if (!entries_.emplace(whole_number(key), &entry).second) {
      throw InputError(fmt::format("has {} twice", whole_number(key)));
    }
  }
}

const Json* NumberedEntries::find(int64_t number) const {
  const auto found = entries_.find(number);
  return found == entries_.end() ? nullptr : found->second;
}

fs::path numbered_picture(const fs::path& folder, const std::vector<int64_t>& numbers) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return {};
  for (const int digits : kDigits) {
    fs::path file = picture_named(folder, joined(numbers, digits));
    if (!file.empty()) return file;
  }
  return {};
}

fs::path picture_named(const fs::path& folder, const std::string& name) {
  std::error_code error;
  for (const char* ending : kPictureEndings) {
    fs::path file = folder / (name + "." + ending);
    if (fs::exists(file, error)) return file;
  }
  return {};
}

fs::path numbered_model(const fs::path& folder, int obj_id) {
  for (const int digits : kDigits) {
    for (const char* ending : {"ply", "PLY"}) {
      const fs::path file =
          plain_or_packed(folder / fmt::format("obj_{}.{}", joined({obj_id}, digits), ending));
      if (fs::exists(file)) return file;
    }
  }
  return folder / bop::model_file(obj_id);
}

fs::path numbered_scene(const fs::path& split, int scene_id) {
  fs::path found;
  for (const int digits : kDigits) {
    fs::path folder = split / joined({scene_id}, digits);
    if (folder == found || !fs::is_directory(folder)) continue;
    if (!found.empty() && fs::equivalent(found, folder)) continue;  // a link
    if (!found.empty()) {
      throw InputError(fmt::format("{}: has scene {} twice, as {} and {}", split.string(), scene_id,
                                   found.filename().string(), folder.filename().string()));
    }
    found = std::move(folder);
  }
  return found.empty() ? split / bop::scene_name(scene_id) : found;
}

}  // namespace sightline
