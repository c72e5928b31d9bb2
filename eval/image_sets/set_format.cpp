// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/set_format.h"

#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

// Each in the file of its name in formats/.
SetFormat bop_format();
SetFormat speed_format();

std::span<const SetFormat> set_formats() {
  static const std::array kCatalogue = {bop_format(), speed_format()};
  return kCatalogue;
}

const SetFormat& find_set_format(const std::string& name) {
  std::vector<std::string> names;
  for (const SetFormat& format : set_formats()) {
    if (format.name == name) return format;
    names.emplace_back(format.name);
  }
  throw InputError(fmt::format("--format {}: is not known{}", name, suggestion(name, names)));
}

}  // namespace sightline
