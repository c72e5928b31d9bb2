// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures in files: PNG, JPEG, TIFF and WebP by those formats' own libraries, BMP by stb_image.
// Nothing is decoded before the file's head has been held against the limits below.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace sightline {

/// No camera has more pixels; a file of 100 kB can claim a hundred times as many.
inline constexpr int64_t kMaxPicturePixels = int64_t{1} << 28;
/// Neither a file nor what it is decoded to may be larger.
inline constexpr int64_t kMaxPictureBytes = int64_t{1} << 31;

/// Which channels are asked of a picture.
enum class PictureChannels {
  kAsStored,  ///< 1 (grey), 3 (blue, green, red) or 4 (and opacity), 8 or 16 bits, or 32-bit floats
  kColour,    ///< 3 (blue, green, red) of 8 bits, upright as its camera says (Exif)
  kGrey,      ///< 1 of 8 bits, luma by ITU-R BT.601, upright as its camera says (Exif)
};

/// What a file holds, or why that cannot be had: `pixels` is empty where `problem` is not.
struct PictureReading {
  cv::Mat pixels;
  std::string problem;  ///< to stand after the file's name, as in "is torn"
};

/// Decodes a file's bytes. Palettes are resolved; grey of fewer than 8 bits is spread to 8.
PictureReading decode_picture(std::string_view bytes,
                              PictureChannels channels = PictureChannels::kAsStored);

/// The same of a file, which must be a regular one (or a link to one).
PictureReading read_picture_file(const std::filesystem::path& file,
                                 PictureChannels channels = PictureChannels::kAsStored);

/// The size that a file states, before anything of it is decoded; none where there is no such file,
/// or no picture in it.
std::optional<cv::Size> picture_size(const std::filesystem::path& file);
/// The same of a file's bytes.
std::optional<cv::Size> picture_size(std::string_view bytes);

/// How long may be sought for what takes fewer bytes.
enum class PngEffort { kFast, kSmall };

/// A picture of 8 or 16 bits with 1, 3 or 4 channels as PNG. Throws std::runtime_error for another.
std::string png_bytes(const cv::Mat& picture, PngEffort effort = PngEffort::kFast);

/// A picture of 8 bits with 1 or 3 channels as JPEG, of a quality from 1 to 100. Throws
/// std::runtime_error for another.
std::string jpeg_bytes(const cv::Mat& picture, int quality = 95);

/// How the pixels of a TIFF lie in it. Deflate packs what is empty for the most part, as depth is,
/// to a few per cent, and a picture with noise to a half.
enum class TiffPacking { kNone, kDeflate };

/// A picture of 8 or 16 bits or 32-bit floats, one channel, as TIFF. Throws std::runtime_error for
/// another.
std::string tiff_bytes(const cv::Mat& picture, TiffPacking packing = TiffPacking::kNone);

}  // namespace sightline
