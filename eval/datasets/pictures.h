// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pictures of data sets, as their files hold them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace sightline {

/// "000017": six digits or more.
std::string six_digits(int64_t number);

/// The picture in a file, as it is; empty when it is not whole, or larger than
/// kMaxPicturePixels.
cv::Mat read_picture(const std::filesystem::path& file);
/// The same as grey levels, one channel of 8 or 16 bits; empty where the file has no such picture.
cv::Mat read_grey_picture(const std::filesystem::path& file);

/// The grey of a picture as it was read; empty of one that has none.
cv::Mat grey_of(const cv::Mat& picture);

/// A line on those pictures of a set that lie behind links out of its folder: sets are often made
/// of links, which are followed, but what is not of the set is then shown in reports. Empty where
/// there are none.
std::string note_on_links(const std::filesystem::path& set,
                          std::span<const std::filesystem::path> pictures);

}  // namespace sightline
