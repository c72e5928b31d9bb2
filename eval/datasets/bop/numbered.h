// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Things that BOP's sets name by numbers. The documentation writes them with six digits in the
// names of files and with as few as there are in the keys of JSON; the sets that people make have
// "000001" for "1", and four digits for six, which BOP's own toolkit reads as well.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/output/json.h"

namespace sightline {

/// The number that a text is; none where it is no whole number, below 0, or 2^63 and more: images
/// may be numbered by the time in nanoseconds.
std::optional<int64_t> number_of(const std::string& text);

/// The same of a scene, whose number an int holds.
std::optional<int> scene_number_of(const std::string& text);

/// The entries of an object whose keys are numbers, however many zeros stand before them. They are
/// as long there as the object. Throws InputError for a key that is no number.
class NumberedEntries {
 public:
  explicit NumberedEntries(const Json& object);

  /// Null where there is none.
  const Json* find(int64_t number) const;
  const std::map<int64_t, const Json*>& all() const { return entries_; }

 private:
  std::map<int64_t, const Json*> entries_;
};

/// The picture in a folder whose name is the numbers with underscores between them, whatever its
/// format, in capitals or not, and how many digits the numbers have; empty where there is none.
std::filesystem::path numbered_picture(const std::filesystem::path& folder,
                                       const std::vector<int64_t>& numbers);

/// The picture in a folder of that name, whatever its format; empty where there is none.
std::filesystem::path picture_named(const std::filesystem::path& folder, const std::string& name);

/// The file of a model in a folder, alike, packed by gzip or not; where there is none, the one that
/// should be there.
std::filesystem::path numbered_model(const std::filesystem::path& folder, int obj_id);

/// The folder of a scene in its split, alike; where there is none, the one that should be there.
/// Throws InputError where there are two.
std::filesystem::path numbered_scene(const std::filesystem::path& split, int scene_id);

}  // namespace sightline
