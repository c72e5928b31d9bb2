// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/set_readers.h"

#include <algorithm>
#include <array>

namespace sightline {

// Each in the file of its name in readers/.
SetReader speed_reader();
SetReader bop_reader();

std::span<const SetReader> set_readers() {
  static const std::array kCatalogue = {speed_reader(), bop_reader()};
  return kCatalogue;
}

const SetReader& set_reader_of(const SightingSource& source) {
  const std::span<const SetReader> readers = set_readers();
  const auto found = std::find_if(readers.begin(), readers.end(),
                                  [&](const SetReader& reader) { return reader.is_of(source); });
  return found == readers.end() ? readers.back() : *found;
}

}  // namespace sightline
