// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/picture/picture_file.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "scenes/files/input_file.h"
#include "scenes/picture/codecs.h"

namespace sightline {
namespace fs = std::filesystem;
namespace {

// As the eight values of Exif's tag "Orientation" ask for.
cv::Mat turned_upright(const cv::Mat& picture, int orientation) {
  cv::Mat out = picture;
  if (orientation >= 5) {
    cv::Mat transposed;
    cv::transpose(out, transposed);
    out = transposed;
  }
  constexpr int kLeftRight = 1, kUpDown = 0, kBoth = -1, kNone = 2;
  constexpr int kFlips[] = {kNone, kLeftRight, kBoth, kUpDown, kNone, kLeftRight, kBoth, kUpDown};
  const int flip = kFlips[orientation - 1];
  if (flip == kNone) return out;
  cv::Mat flipped;
  cv::flip(out, flipped, flip);
  return flipped;
}

cv::Mat as_grey_of_8_bits(const cv::Mat& stored) {
  cv::Mat grey = stored;
  if (stored.channels() == 3) cv::cvtColor(stored, grey, cv::COLOR_BGR2GRAY);
  if (stored.channels() == 4) cv::cvtColor(stored, grey, cv::COLOR_BGRA2GRAY);
  if (grey.depth() != CV_16U) return grey;
  cv::Mat narrow;
  grey.convertTo(narrow, CV_8U, 1.0 / 257.0);
  return narrow;
}

cv::Mat as_colours_of_8_bits(const cv::Mat& stored) {
  cv::Mat narrow = stored, colours;
  if (stored.depth() == CV_16U) stored.convertTo(narrow, CV_8U, 1.0 / 257.0);
  if (narrow.channels() == 3) return narrow;
  cv::cvtColor(narrow, colours, narrow.channels() == 1 ? cv::COLOR_GRAY2BGR : cv::COLOR_BGRA2BGR);
  return colours;
}

PictureReading converted(const PictureReading& reading, PictureChannels channels) {
  if (reading.pixels.empty() || channels == PictureChannels::kAsStored) return reading;
  if (reading.pixels.depth() == CV_32F) return {{}, "holds numbers, not grey levels"};
  return {channels == PictureChannels::kGrey ? as_grey_of_8_bits(reading.pixels)
                                             : as_colours_of_8_bits(reading.pixels),
          {}};
}

enum class PictureFormat { kPng, kJpeg, kTiff, kWebp, kBmp, kOther };

PictureFormat format_of(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return PictureFormat::kPng;
  if (bytes.starts_with("\xff\xd8\xff")) return PictureFormat::kJpeg;
  const std::string_view head = bytes.substr(0, 4);
  const bool is_tiff = head == std::string_view("II*\0", 4) || head == std::string_view("MM\0*", 4);
  if (is_tiff) return PictureFormat::kTiff;
  if (head == "RIFF" && bytes.substr(0, 12).ends_with("WEBP")) return PictureFormat::kWebp;
  return head.starts_with("BM") ? PictureFormat::kBmp : PictureFormat::kOther;
}

}  // namespace

FileBytes bytes_of_picture(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) return {{}, "is not there"};
  if (!fs::is_regular_file(status)) return {{}, "is no file"};
  const uintmax_t size = fs::file_size(file, error);
  if (error) return {{}, "cannot be read: " + error.message()};
  if (size > static_cast<uintmax_t>(kMaxPictureBytes)) {
    return {{}, fmt::format("has {} MB, must be at most {}", size >> 20, kMaxPictureBytes >> 20)};
  }
  std::optional<std::string> bytes = bytes_of_file(file, kMaxPictureBytes);
  if (!bytes) return {{}, "cannot be read"};
  return {std::move(*bytes), {}};
}

std::string size_problem(int64_t width, int64_t height, int64_t bytes_a_pixel) {
  if (width < 1 || height < 1) return "has no pixels";
  // Neither factor exceeds 32 bits, so that the product cannot overflow.
  if (width * height > kMaxPicturePixels) {
    return fmt::format("is {} x {} pixels, must be at most {} in all", width, height,
                       kMaxPicturePixels);
  }
  if (width * height * bytes_a_pixel > kMaxPictureBytes) {
    return fmt::format("is {} x {} pixels of {} bytes, must be at most {} MB", width, height,
                       bytes_a_pixel, kMaxPictureBytes >> 20);
  }
  return {};
}

PictureReading decode_picture(std::string_view bytes, PictureChannels channels) {
  PictureReading reading;
  switch (format_of(bytes)) {
    case PictureFormat::kPng:
      return converted(decode_png(bytes, channels), channels);
    case PictureFormat::kJpeg:
      reading = converted(decode_jpeg(bytes, channels), channels);
      if (channels != PictureChannels::kAsStored && !reading.pixels.empty()) {
        reading.pixels = turned_upright(reading.pixels, exif_orientation(bytes));
      }
      return reading;
    case PictureFormat::kTiff:
      return converted(decode_tiff(bytes), channels);
    case PictureFormat::kWebp:
      return converted(decode_webp(bytes), channels);
    case PictureFormat::kBmp:
      return converted(decode_bmp(bytes), channels);
    case PictureFormat::kOther:
      break;
  }
  return {{}, "is no PNG, JPEG, TIFF, WebP or BMP"};
}

PictureReading read_picture_file(const fs::path& file, PictureChannels channels) {
  const auto [bytes, problem] = bytes_of_picture(file);
  if (!problem.empty()) return {{}, problem};
  return decode_picture(bytes, channels);
}

std::optional<cv::Size> picture_size(std::string_view bytes) {
  switch (format_of(bytes)) {
    case PictureFormat::kPng:
      return png_size(bytes);
    case PictureFormat::kJpeg:
      return jpeg_size(bytes);
    case PictureFormat::kTiff:
      return tiff_size(bytes);
    case PictureFormat::kWebp:
      return webp_size(bytes);
    case PictureFormat::kBmp:
      return bmp_size(bytes);
    case PictureFormat::kOther:
      break;
  }
  return std::nullopt;
}

std::optional<cv::Size> picture_size(const fs::path& file) {
  constexpr size_t kHeadBytes = size_t{1} << 16;  // most pictures state their size among these
  const std::string head = head_of_file(file, kHeadBytes);
  const PictureFormat format = format_of(head);
  if (format == PictureFormat::kOther) return std::nullopt;
  // A TIFF says its size anywhere, and one that is cut would be misread. A JPEG that is cut before
  // its size has none, or one of 0.
  if (format != PictureFormat::kTiff) {
    const auto size = picture_size(std::string_view(head));
    if (size && !size->empty()) return size;
  }
  return picture_size(std::string_view(bytes_of_picture(file).bytes));
}

}  // namespace sightline
