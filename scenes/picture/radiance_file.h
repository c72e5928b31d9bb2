// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures of light itself, whose numbers have no upper end: OpenEXR by its own library, Radiance's
// .hdr by our own reader, since others read the end of a torn file as black.
#pragma once

#include <filesystem>
#include <string_view>

#include "scenes/picture/picture_file.h"

namespace sightline {

/// True of names that end as such files' do, in letters of either case.
bool is_radiance_name(const std::filesystem::path& file);

/// Blue, green and red as 32-bit floats, none negative: what is below zero (a resampled picture
/// rings) becomes 0. A picture with luminance alone is grey. Of an OpenEXR file with several parts
/// the first is read; alpha and other channels are not. A number that is not finite is a problem.
PictureReading decode_radiance(std::string_view bytes);

/// The same of a file.
PictureReading read_radiance_file(const std::filesystem::path& file);

}  // namespace sightline
