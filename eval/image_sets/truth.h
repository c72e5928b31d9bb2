// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Our own truth beside every format: sightline/<scene>/<image>.json, and with it, unless the set's
// truth is minimal, <image>_depth.tiff and <image>_parts.png. The JSON comes last: an image whose
// JSON is there is whole.
#pragma once

#include <filesystem>
#include <optional>
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

/// The files beside the JSON: depth as z - z0_m in 32-bit TIFF, NaN of background, and 16-bit part
/// ids. None of a minimal truth.
std::vector<SetFile> truth_files(const SetPlan& plan, const SetImage& image);
std::vector<std::string> truth_file_paths(const SetPlan& plan, int64_t index);

/// The truth in the folder; none where there is none that can be read.
std::optional<Json> read_truth(const std::filesystem::path& folder, const SetPlan& plan,
                               int64_t index);

/// What is wrong with the truth of an image, and with the files beside it: it must be what its
/// scene, drawn anew, says, and agree with itself.
std::vector<std::string> truth_problems(const std::filesystem::path& folder, const SetPlan& plan,
                                        const Json& truth, int64_t index);

/// Whether an image with this truth is in colour.
bool is_in_colour(const Json& truth);

/// A pose as truth states it.
Pose pose_in(const Json& body);

}  // namespace sightline
