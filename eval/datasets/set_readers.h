// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The formats that `evaluate` reads data sets in, for read_sightings alone.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "eval/datasets/sightings.h"

namespace sightline {

/// What a set says of the target: poses in metres, of the set's own frame of the model; cameras
/// without a size; symmetries of the model in millimetres.
struct SetReading {
  std::vector<Sighting> sightings;
  int obj_id = 1;
  std::filesystem::path model_file;                ///< that says what the next is
  std::optional<Eigen::AlignedBox3d> model_box_m;  ///< of the model in its own frame, if known
  Symmetries symmetries{};
  std::vector<std::string> notes{};  ///< as SightedSet has them
};

/// A format that data sets are read in. To add one: write readers/<name>.cpp and name it in
/// set_readers.cpp.
struct SetReader {
  std::string_view name;
  /// Whether the source's folder, which is there, looks like a set of this format.
  bool (*is_of)(const SightingSource& source);
  /// Reads such a set. Throws InputError, with the file, for whatever is missing or not so.
  SetReading (*read)(const SightingSource& source);
};

/// The catalogue, in the order in which a folder is offered to them. The last takes every folder.
std::span<const SetReader> set_readers();

/// The first of them that the source is of.
const SetReader& set_reader_of(const SightingSource& source);

}  // namespace sightline
