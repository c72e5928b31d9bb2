// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/words.h"

#include <algorithm>
#include <functional>
#include <map>

namespace sightline {

std::string solver_label(std::string_view name) {
  static const std::map<std::string, std::string, std::less<>> kSpelt = {
      {"gnc", "GNC"},   {"huber", "Huber"}, {"lspe", "LSPE"},     {"opencv", "OpenCV"},
      {"orpe", "ORPE"}, {"p3p", "P3P"},     {"ransac", "RANSAC"}, {"tukey", "Tukey"}};
  std::string label;
  for (size_t begin = 0; begin < name.size();) {
    const size_t end = std::min(name.find('_', begin), name.size());
    const std::string_view word = name.substr(begin, end - begin);
    const auto spelt = kSpelt.find(word);
    if (!label.empty()) label += ' ';
    label += spelt != kSpelt.end() ? spelt->second : std::string(word);
    begin = end + 1;
  }
  return label;
}

std::string words(std::string_view status) {
  std::string text(status);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string in_one_line(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  }
  return text;
}

}  // namespace sightline
