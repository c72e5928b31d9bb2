// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>

#include "eval/image_sets/set_format.h"

namespace sightline {

/// Gives a truth of an image in the folder what the format has to know of the image's files beside
/// it (SetFormat::told_by_files). False where they cannot be read.
bool add_told_by_files(const std::filesystem::path& folder, const SetPlan& plan, Json& truth);

/// Reads a chunk's truths in the order of the images, less those of images that could not be made,
/// each with what its files tell, by so many threads. Throws InputError for the first that
/// cannot be read.
std::vector<Json> read_truths(const std::filesystem::path& folder, const SetPlan& plan,
                              int64_t chunk, int jobs);

/// The elements of truths in the set's list of images, a line each.
std::string list_lines(const SetPlan& plan, std::span<const Json> truths, bool is_first);

inline constexpr std::string_view kListBegin = "[";
inline constexpr std::string_view kListEnd = "\n]\n";

/// Writes the files that tell of several images. All truths must be there. Returns the number of
/// scenes that could not be imaged.
int64_t join_set(const SetPlan& plan, const std::filesystem::path& folder, int jobs);

}  // namespace sightline
