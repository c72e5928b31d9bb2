// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mtl_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sightline {
namespace {

constexpr std::string_view kMtlBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(kMtlBlanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kMtlBlanks) - begin + 1);
}

// The word with which a line goes on, taken off it.
std::string_view take_word(std::string_view& line) {
  line = trimmed(line);
  const std::string_view word = line.substr(0, line.find_first_of(kMtlBlanks));
  line = trimmed(line.substr(word.size()));
  return word;
}

std::optional<double> number_of_word(std::string_view word) {
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool is_number = error == std::errc() && end == word.data() + word.size();
  return is_number && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

// Takes up to three numbers off a line, of which the third, of depth, is none of a picture's.
void take_numbers(std::string_view& line, std::array<double, 2>& into) {
  for (size_t i = 0; i < 3; ++i) {
    std::string_view rest = line;
    const auto number = number_of_word(take_word(rest));
    if (!number || rest.empty()) return;  // what stands last is the file
    if (i < into.size()) into[i] = *number;
    line = rest;
  }
}

MtlMap map_of(std::string_view line) {
  MtlMap map;
  std::array<double, 2> unused{};
  while (line.starts_with('-')) {
    const std::string_view option = take_word(line);
    if (option == "-s") {
      take_numbers(line, map.scale);
    } else if (option == "-o") {
      take_numbers(line, map.offset);
    } else if (option == "-t" || option == "-mm" || option == "-bm" || option == "-boost" ||
               option == "-texres") {
      take_numbers(line, unused);
    } else {
      const std::string_view value = take_word(line);
      if (option == "-clamp") map.is_clamped = value == "on";
    }
  }
  map.file = std::string(line);
  return map;
}

// Calls with the lines of a text that begin with the word: with what follows it.
template <typename Visit>
void for_each_line_of(std::string_view text, std::string_view word, const Visit& visit) {
  for (size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
    const size_t before = text.find_last_not_of(kMtlBlanks, at == 0 ? text.npos : at - 1);
    const bool begins = at == 0 || before == text.npos || text[before] == '\n';
    const std::string_view rest = text.substr(at + word.size());
    const std::string_view line = rest.substr(0, rest.find('\n'));
    const bool is_word = !line.empty() && kMtlBlanks.find(line[0]) != kMtlBlanks.npos;
    if (begins && is_word) visit(trimmed(line));
  }
}

}  // namespace

std::map<std::string, MtlMaterial> mtl_materials(std::string_view mtl) {
  std::map<std::string, MtlMaterial> materials;
  MtlMaterial* material = nullptr;
  while (!mtl.empty()) {
    const size_t end = std::min(mtl.find('\n'), mtl.size());
    std::string_view line = mtl.substr(0, end);
    mtl.remove_prefix(std::min(end + 1, mtl.size()));
    const std::string_view word = take_word(line);
    if (word == "newmtl") {
      const auto [at, is_new] = materials.try_emplace(std::string(line));
      material = is_new ? &at->second : nullptr;
    }
    if (material == nullptr || line.empty()) continue;
    if (word == "map_Kd") material->colour = map_of(line);
    if (word == "map_Ke" || word == "map_emissive") material->emission = map_of(line);
    if (word == "map_d" || word == "map_opacity") material->alpha = map_of(line);
  }
  return materials;
}

std::vector<std::string> mtl_files(std::string_view obj) {
  std::vector<std::string> files;
  for_each_line_of(obj, "mtllib", [&](std::string_view name) {
    const bool is_known = std::find(files.begin(), files.end(), name) != files.end();
    if (!name.empty() && !is_known && files.size() < 1000) files.emplace_back(name);
  });
  return files;
}

}  // namespace sightline
