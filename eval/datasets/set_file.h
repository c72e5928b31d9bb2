// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// A file of a data set that is to be written: where it lies in the set's folder, and what it
/// holds.
struct SetFile {
  std::string path;
  std::string bytes;
};

}  // namespace sightline
