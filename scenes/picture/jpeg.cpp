// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>
#include <stdexcept>

#include <opencv2/core.hpp>
#include <turbojpeg.h>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

struct TurboCloser {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Turbo = std::unique_ptr<void, TurboCloser>;

Turbo made(tjhandle handle) {
  if (handle == nullptr) throw std::bad_alloc();
  return Turbo(handle);
}

const uint8_t* unsigned_bytes(std::string_view bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

// Numbers of Exif's block, in the byte order that its head states.
class ExifBlock {
 public:
  ExifBlock(std::string_view tiff, bool is_big_endian)
      : tiff_(tiff), is_big_endian_(is_big_endian) {}

  // Of 1 to 4 bytes; 0 past the end, where nothing stands that would be looked for.
  uint32_t number(size_t at, int bytes) const {
    if (at + bytes > tiff_.size()) return 0;
    uint32_t out = 0;
    for (int i = 0; i < bytes; ++i) {
      const int place = is_big_endian_ ? i : bytes - 1 - i;
      out = out << 8 | static_cast<uint8_t>(tiff_[at + place]);
    }
    return out;
  }

 private:
  std::string_view tiff_;
  bool is_big_endian_;
};

int orientation_in(std::string_view tiff) {
  if (!tiff.starts_with("II") && !tiff.starts_with("MM")) return 1;
  const ExifBlock block(tiff, tiff.starts_with("MM"));
  constexpr uint32_t kOrientation = 0x0112;
  constexpr size_t kEntryBytes = 12, kValueInEntry = 8;
  const size_t directory = block.number(4, 4);
  const uint32_t entries = block.number(directory, 2);
  for (uint32_t i = 0; i < entries; ++i) {
    const size_t entry = directory + 2 + i * kEntryBytes;
    if (block.number(entry, 2) != kOrientation) continue;
    const auto value = static_cast<int>(block.number(entry + kValueInEntry, 2));
    return value >= 1 && value <= 8 ? value : 1;
  }
  return 1;
}

// It is looked for in the second half: a thumbnail at the beginning may have one of its own.
bool has_end_marker(std::string_view jpeg) {
  return jpeg.find("\xff\xd9", jpeg.size() / 2) != std::string_view::npos;
}

}  // namespace

int exif_orientation(std::string_view jpeg) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  const auto byte = [&](size_t at) { return static_cast<uint8_t>(jpeg[at]); };
  // Segments follow one another, each with its length, until the compressed picture begins.
  for (size_t at = 2; at + 4 <= jpeg.size() && byte(at) == 0xff && byte(at + 1) != 0xda;) {
    const size_t length = byte(at + 2) << 8 | byte(at + 3);
    const std::string_view body = jpeg.substr(at + 4, length < 2 ? 0 : length - 2);
    if (byte(at + 1) == 0xe1 && body.starts_with(kExif)) {
      return orientation_in(body.substr(kExif.size()));
    }
    at += 2 + length;
  }
  return 1;
}

std::optional<cv::Size> jpeg_size(std::string_view bytes) {
  const Turbo turbo = made(tjInitDecompress());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(turbo.get(), unsigned_bytes(bytes), bytes.size(), &width, &height,
                          &subsampling, &colours) != 0) {
    return std::nullopt;
  }
  return cv::Size(width, height);
}

PictureReading decode_jpeg(std::string_view bytes, PictureChannels channels) {
  const Turbo turbo = made(tjInitDecompress());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(turbo.get(), unsigned_bytes(bytes), bytes.size(), &width, &height,
                          &subsampling, &colours) != 0) {
    return {{}, kTornPicture};
  }
  const bool is_grey = channels == PictureChannels::kGrey || colours == TJCS_GRAY;
  if (std::string problem = size_problem(width, height, is_grey ? 1 : 3); !problem.empty()) {
    return {{}, std::move(problem)};
  }
  if (colours == TJCS_CMYK || colours == TJCS_YCCK) return {{}, "is in printing inks (CMYK)"};
  cv::Mat picture(height, width, is_grey ? CV_8UC1 : CV_8UC3);
  if (tjDecompress2(turbo.get(), unsigned_bytes(bytes), bytes.size(), picture.data, width,
                    static_cast<int>(picture.step), height, is_grey ? TJPF_GRAY : TJPF_BGR,
                    0) == 0) {
    return {picture, {}};
  }
  // A warning is of a harmless oddity, such as bytes between two segments, or of a picture that
  // ends early and was filled in with grey: that has lost its end marker too.
  const bool is_warning = tjGetErrorCode(turbo.get()) == TJERR_WARNING;
  if (!is_warning || !has_end_marker(bytes)) return {{}, kTornPicture};
  return {picture, {}};
}

std::string jpeg_bytes(const cv::Mat& picture, int quality) {
  const bool is_grey = picture.type() == CV_8UC1;
  if (picture.empty() || (!is_grey && picture.type() != CV_8UC3)) {
    throw std::runtime_error("jpeg_bytes: 8 bits in 1 or 3 channels are written alone");
  }
  const Turbo turbo = made(tjInitCompress());
  uint8_t* bytes = nullptr;
  unsigned long count = 0;
  const int outcome =
      tjCompress2(turbo.get(), picture.data, picture.cols, static_cast<int>(picture.step),
                  picture.rows, is_grey ? TJPF_GRAY : TJPF_BGR, &bytes, &count,
                  is_grey ? TJSAMP_GRAY : TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<uint8_t, decltype(&tjFree)> owned(bytes, tjFree);
  if (outcome != 0) throw std::runtime_error(tjGetErrorStr2(turbo.get()));
  return {reinterpret_cast<const char*>(bytes), count};
}

}  // namespace sightline
