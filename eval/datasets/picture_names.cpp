// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/picture_names.h"

#include <vector>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kSeveral = -1;

// "a/b/c.png", "b/c.png" and "c.png".
std::vector<std::string> ends_of(const std::filesystem::path& path) {
  std::string rest = path.lexically_normal().relative_path().generic_string();
  std::vector<std::string> ends = {rest};
  for (size_t slash = rest.find('/'); slash != rest.npos; slash = rest.find('/')) {
    rest.erase(0, slash + 1);
    ends.push_back(rest);
  }
  return ends;
}

}  // namespace

void PictureNames::add(const std::filesystem::path& picture, int id) {
  for (const std::string& end : ends_of(picture)) {
    const auto [place, is_new] = by_end_.emplace(end, id);
    if (!is_new && place->second != id) place->second = kSeveral;
  }
}

std::optional<int> PictureNames::find(const std::string& name, const std::string& where) const {
  for (const std::string& end : ends_of(name)) {
    const auto found = by_end_.find(end);
    if (found == by_end_.end()) continue;
    if (found->second != kSeveral) return found->second;
    throw InputError(fmt::format(
        "{}: the set has several pictures '{}': say which, by their folders", where, end));
  }
  return std::nullopt;
}

}  // namespace sightline
