// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sightline {

/// What a user changes of a target's features after looking at them.
struct TargetEdits {
  std::vector<std::string> dropped;  ///< names
  std::vector<std::string> added;    ///< "x,y,z" or "x,y,z,name", metres in the target's frame

  bool empty() const { return dropped.empty() && added.empty(); }
};

/// Changes a target.toml in place: takes away the [[feature]] tables of those names, and appends
/// contours at those points, known by the outline of the parts around them. All else in the file
/// stays byte for byte. Returns a line for each change. Throws InputError for a name that is not
/// there, a name twice, numbers that are none, a point off the mesh, and a file whose features are
/// written in another way; the file is then as it was.
std::string edit_target(const std::filesystem::path& file, const TargetEdits& edits);

}  // namespace sightline
