// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace sightline {

/// What a set holds, as verify_set found it.
struct SetVerdict {
  int64_t images = 0;    ///< of the set, as planned
  int64_t missing = 0;   ///< that are not there, or not wholly
  int64_t problems = 0;  ///< all told, the missing ones among them
};

/// Re-reads a set: every image is decoded and held against its truth, every truth against its scene
/// drawn anew, every file that tells of several images against what the truths say; whatever else
/// lies in the folder is a problem too. `tell` hears each problem as a line, `tick` each image.
/// Throws InputError when the folder holds no set.
SetVerdict verify_set(const std::filesystem::path& folder,
                      const std::function<void(const std::string&)>& tell,
                      const std::function<void(int64_t images)>& tick);

/// How many images the set in a folder is planned to have. Throws InputError when it holds none.
int64_t planned_images(const std::filesystem::path& folder);

}  // namespace sightline
