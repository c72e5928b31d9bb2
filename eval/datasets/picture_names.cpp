// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/picture_names.h"

#include <vector>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int kSeveral = -1;

// "a/b/c.png", "b/c.png" and "c.png". Steps up at its beginning lead to no folder of a name.
std::vector<std::string> ends_of(const std::filesystem::path& path) {
  std::string rest = path.lexically_normal().relative_path().generic_string();
  while (rest.starts_with("../")) rest.erase(0, 3);
  std::vector<std::string> ends = {rest};
  for (size_t slash = rest.find('/'); slash != rest.npos; slash = rest.find('/')) {
    rest.erase(0, slash + 1);
    ends.push_back(rest);
  }
  return ends;
}

}  // namespace

void PictureNames::add(const std::filesystem::path& picture, int id) {
  const auto add_to = [id](std::map<std::string, int>& names, const std::string& name) {
    const auto [place, is_new] = names.emplace(name, id);
    if (!is_new && place->second != id) place->second = kSeveral;
  };
  // With all its folders, from whichever the set was named: those of another set contradict.
  const std::vector<std::string> ends = ends_of(std::filesystem::absolute(picture));
  add_to(by_path_, ends.front());
  for (const std::string& end : ends) add_to(by_end_, end);
}

std::optional<int> PictureNames::find(const std::string& name, const std::string& where) const {
  const std::vector<std::string> ends = ends_of(name);
  const auto id_in = [&where](const std::map<std::string, int>& names,
                              const std::string& end) -> std::optional<int> {
    const auto found = names.find(end);
    if (found == names.end()) return std::nullopt;
    if (found->second != kSeveral) return found->second;
    throw InputError(fmt::format(
        "{}: the set has several pictures '{}': say which, by their folders", where, end));
  };
  if (const auto id = id_in(by_end_, ends.front())) return id;
  for (const std::string& end : ends) {
    if (const auto id = id_in(by_path_, end)) return id;
  }
  return std::nullopt;
}

}  // namespace sightline
