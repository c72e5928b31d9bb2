// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tiffio.h>
#include <tiffio.hxx>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

struct TiffCloser {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, TiffCloser>;

// What libtiff has to say of a file is said by us in our own words.
const bool kIsSilent = [] {
  TIFFSetErrorHandler(nullptr);
  TIFFSetWarningHandler(nullptr);
  return true;
}();

struct TiffLayout {
  uint32_t width = 0, height = 0;
  uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, planes = PLANARCONFIG_CONTIG;
  uint16_t meaning = PHOTOMETRIC_MINISBLACK;
};

TiffLayout layout_of(TIFF* tiff) {
  TiffLayout out;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &out.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &out.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &out.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &out.samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &out.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &out.planes);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &out.meaning);
  return out;
}

// The type of the picture whose rows are the file's own; -1 where they need converting.
int type_of_rows(TIFF* tiff, const TiffLayout& layout) {
  const bool is_plain =
      !TIFFIsTiled(tiff) && layout.planes == PLANARCONFIG_CONTIG &&
      ((layout.meaning == PHOTOMETRIC_MINISBLACK && layout.samples == 1) ||
       (layout.meaning == PHOTOMETRIC_RGB && (layout.samples == 3 || layout.samples == 4)));
  if (!is_plain) return -1;
  const bool is_count = layout.format == SAMPLEFORMAT_UINT;
  if (is_count && layout.bits == 8) return CV_MAKETYPE(CV_8U, layout.samples);
  if (is_count && layout.bits == 16) return CV_MAKETYPE(CV_16U, layout.samples);
  if (layout.format == SAMPLEFORMAT_IEEEFP && layout.bits == 32) {
    return CV_MAKETYPE(CV_32F, layout.samples);
  }
  return -1;
}

PictureReading read_rows(TIFF* tiff, const TiffLayout& layout, int type) {
  cv::Mat picture(static_cast<int>(layout.height), static_cast<int>(layout.width), type);
  if (TIFFScanlineSize(tiff) != static_cast<tmsize_t>(picture.cols * picture.elemSize())) {
    return {{}, kTornPicture};
  }
  for (uint32_t v = 0; v < layout.height; ++v) {
    if (TIFFReadScanline(tiff, picture.ptr(static_cast<int>(v)), v) != 1) return {{}, kTornPicture};
  }
  if (picture.channels() == 3) cv::cvtColor(picture, picture, cv::COLOR_RGB2BGR);
  if (picture.channels() == 4) cv::cvtColor(picture, picture, cv::COLOR_RGBA2BGRA);
  return {picture, {}};
}

// Palettes, tiles, inks and the rest come through libtiff's own conversion to 8 bits.
PictureReading read_converted(TIFF* tiff, const TiffLayout& layout) {
  char reason[1024] = "";
  if (layout.bits > 8 || TIFFRGBAImageOK(tiff, reason) == 0) {
    return {{}, "is a TIFF of a kind that is not read"};
  }
  cv::Mat picture(static_cast<int>(layout.height), static_cast<int>(layout.width), CV_8UC4);
  constexpr int kStopAtErrors = 1;
  if (TIFFReadRGBAImageOriented(tiff, layout.width, layout.height, picture.ptr<uint32_t>(),
                                ORIENTATION_TOPLEFT, kStopAtErrors) != 1) {
    return {{}, kTornPicture};
  }
  cv::Mat colours;
  cv::cvtColor(picture, colours, cv::COLOR_RGBA2BGR);
  return {colours, {}};
}

}  // namespace

std::optional<cv::Size> tiff_size(std::string_view bytes) {
  std::istringstream stream{std::string(bytes), std::ios::binary};
  const Tiff tiff(TIFFStreamOpen("picture", static_cast<std::istream*>(&stream)));
  if (tiff == nullptr) return std::nullopt;
  const TiffLayout layout = layout_of(tiff.get());
  if (layout.width > INT32_MAX || layout.height > INT32_MAX) return std::nullopt;
  return cv::Size(static_cast<int>(layout.width), static_cast<int>(layout.height));
}

PictureReading decode_tiff(std::string_view bytes) {
  std::istringstream stream{std::string(bytes), std::ios::binary};
  const Tiff tiff(TIFFStreamOpen("picture", static_cast<std::istream*>(&stream)));
  if (tiff == nullptr) return {{}, kTornPicture};
  const TiffLayout layout = layout_of(tiff.get());
  const int bytes_a_pixel = std::max(4, layout.samples * layout.bits / 8);
  if (std::string problem = size_problem(layout.width, layout.height, bytes_a_pixel);
      !problem.empty()) {
    return {{}, std::move(problem)};
  }
  const int type = type_of_rows(tiff.get(), layout);
  return type < 0 ? read_converted(tiff.get(), layout) : read_rows(tiff.get(), layout, type);
}

namespace {

constexpr int kBitsAByte = 8;

void describe(TIFF* tiff, const cv::Mat& picture, TiffPacking packing) {
  const auto pixel_bytes = static_cast<int>(picture.elemSize());
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, picture.cols);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, picture.rows);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kBitsAByte * pixel_bytes);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               picture.depth() == CV_32F ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  if (packing == TiffPacking::kDeflate) {
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, picture.rows);
    return;
  }
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  // Strips of about 8 kB, as the format's specification recommends.
  constexpr int kStripBytes = 1 << 13;
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP,
               std::clamp(kStripBytes / (picture.cols * pixel_bytes), 1, picture.rows));
}

bool write_plain(TIFF* tiff, const cv::Mat& picture) {
  const size_t row_bytes = static_cast<size_t>(picture.cols) * picture.elemSize();
  for (int v = 0; v < picture.rows; ++v) {
    // libtiff swaps bytes in place where it must: it is given a copy.
    std::vector<uint8_t> row(picture.ptr(v), picture.ptr(v) + row_bytes);
    if (TIFFWriteScanline(tiff, row.data(), static_cast<uint32_t>(v)) != 1) return false;
  }
  return true;
}

// One strip. libtiff writes numbers as this machine has them.
bool write_packed(TIFF* tiff, const cv::Mat& picture) {
  const cv::Mat rows = picture.isContinuous() ? picture : picture.clone();
  std::string packed = zlib_packed({rows.data, rows.total() * rows.elemSize()});
  const auto size = static_cast<tmsize_t>(packed.size());
  return TIFFWriteRawStrip(tiff, 0, packed.data(), size) == size;
}

}  // namespace

std::string tiff_bytes(const cv::Mat& picture, TiffPacking packing) {
  const int type = picture.type();
  if (picture.empty() || (type != CV_8UC1 && type != CV_16UC1 && type != CV_32FC1)) {
    throw std::runtime_error("tiff_bytes: one channel of 8, 16 or 32 bits is written alone");
  }
  std::ostringstream stream(std::ios::binary);
  Tiff tiff(TIFFStreamOpen("picture", static_cast<std::ostream*>(&stream)));
  if (tiff == nullptr) throw std::bad_alloc();
  describe(tiff.get(), picture, packing);
  const bool is_written = packing == TiffPacking::kDeflate ? write_packed(tiff.get(), picture)
                                                           : write_plain(tiff.get(), picture);
  if (!is_written) throw std::runtime_error("tiff_bytes: the picture cannot be written");
  tiff.reset();
  return std::move(stream).str();
}

}  // namespace sightline
