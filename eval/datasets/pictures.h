// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pictures of data sets, as their files hold them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace sightline {

/// A file of some kilobytes may state a picture of gigabytes: larger ones are not decoded.
inline constexpr int64_t kMostPicturePixels = int64_t{1} << 28;

/// "000017": six digits or more.
std::string six_digits(int64_t number);

/// A picture as PNG, fast rather than small.
std::string png_bytes(const cv::Mat& picture);
/// A picture of 32-bit floating point as TIFF.
std::string tiff_bytes(const cv::Mat& picture);
/// The size that the header of a PNG, JPEG or BMP file states, whatever its name; of other formats
/// that of the decoded picture. None where the file is missing or no picture.
std::optional<cv::Size> picture_size(const std::filesystem::path& file);
/// The picture in a file, as it is; empty when it is not whole, or when its header states more than
/// kMostPicturePixels: it is then not decoded.
cv::Mat read_picture(const std::filesystem::path& file);
/// The same as grey levels, one channel of 8 or 16 bits; empty where the file has no such picture.
cv::Mat read_grey_picture(const std::filesystem::path& file);

}  // namespace sightline
