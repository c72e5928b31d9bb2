// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Our own truth beside every format: sightline/<scene>/<image>.json, and with it, unless the set's
// truth is minimal, <image>_depth.tiff and <image>_parts.png. The JSON comes last: an image whose
// JSON is there is whole.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/image_sets/set_format.h"
#include "eval/output/json.h"

namespace sightline {

/// Where an image's truth lies in the set's folder.
std::string truth_path(const SetPlan& plan, int64_t index);

/// What is true of an image. Boxes are [x, y, width, height] in whole pixels. An image that could
/// not be made has "failure", the reason, and neither "image" nor "bodies".
Json truth_of(const SetPlan& plan, const SetImage& image);
/// As it stands in its file.
std::string truth_text(const Json& truth);

/// Everything that is written of an image, its truth last, which has the others' checksums
/// (crc32_text) by their paths under kChecksums.
std::vector<SetFile> files_of(const SetPlan& plan, const SetImage& image);
inline constexpr const char* kChecksums = "crc32";

/// What files are beside the JSON: depth as z - z0_m in 32-bit TIFF, NaN of background, and 16-bit
/// part ids, none of a minimal truth; and the pictures of extras.h.
std::vector<std::string> truth_file_paths(const SetPlan& plan, int64_t index);

/// The truth in the folder; none where there is none that can be read.
std::optional<Json> read_truth(const std::filesystem::path& folder, const SetPlan& plan,
                               int64_t index);

/// Whether the files of an image whose truth is there are there too, whatever they hold; true where
/// that truth cannot be read.
bool has_all_files(const std::filesystem::path& folder, const SetPlan& plan, int64_t index);

/// What is wrong with the truth of an image, and with the files beside it: it must be what its
/// scene, drawn anew, says, and agree with itself.
std::vector<std::string> truth_problems(const std::filesystem::path& folder, const SetPlan& plan,
                                        const Json& truth, int64_t index);

/// Which of an image's files, all of which must be there, are not those whose checksums its truth
/// has; a truth of before checksums has none.
std::vector<std::string> checksum_problems(const std::filesystem::path& folder, const Json& truth,
                                           std::span<const std::string> paths);

/// Whether an image with this truth is in colour.
bool is_in_colour(const Json& truth);

/// A pose as truth states it.
Pose pose_in(const Json& body);

}  // namespace sightline
