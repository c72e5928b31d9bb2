// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One decoder a format. Each is given bytes that begin as its format's do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scenes/picture/picture_file.h"

namespace sightline {

/// What a regular file (or a link to one) holds, or why that cannot be had.
struct FileBytes {
  std::string bytes;
  std::string problem;  ///< to stand after the file's name
};
FileBytes bytes_of_picture(const std::filesystem::path& file);

/// Why a picture of this size may not be decoded; empty where it may.
std::string size_problem(int64_t width, int64_t height, int64_t bytes_a_pixel);

/// What is said of a file that ends too early or is damaged.
inline constexpr const char* kTornPicture = "is torn or damaged";

// The size that the head of the file states; none where it has no whole head.
std::optional<cv::Size> png_size(std::string_view bytes);
std::optional<cv::Size> jpeg_size(std::string_view bytes);
std::optional<cv::Size> tiff_size(std::string_view bytes);
std::optional<cv::Size> webp_size(std::string_view bytes);
std::optional<cv::Size> bmp_size(std::string_view bytes);

PictureReading decode_png(std::string_view bytes, PictureChannels channels);
PictureReading decode_jpeg(std::string_view bytes, PictureChannels channels);
/// Of these, grey is what is stored, converted.
PictureReading decode_tiff(std::string_view bytes);
PictureReading decode_webp(std::string_view bytes);
PictureReading decode_bmp(std::string_view bytes);
/// Of these, blue, green and red as 32-bit floats.
PictureReading decode_exr(std::string_view bytes);
PictureReading decode_hdr(std::string_view bytes);

/// The bytes as a stream of zlib's, as PNG and TIFF have them, packed fast.
std::string zlib_packed(std::span<const uint8_t> bytes);

/// How a JPEG's Exif block says that the picture is turned: 1 (upright) to 8, 1 where it says
/// nothing.
int exif_orientation(std::string_view jpeg);

}  // namespace sightline
