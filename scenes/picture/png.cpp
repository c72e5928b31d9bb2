// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <png.h>
#include <zlib.h>

#include "scenes/files/checksum.h"
#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

void jump_out(png_structp png, png_const_charp) {
  png_longjmp(png, 1);
}

void be_silent(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep to, png_size_t count) {
  auto& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (left.size() < count) png_error(png, "the file ends");
  std::memcpy(to, left.data(), count);
  left.remove_prefix(count);
}

void append_bytes(png_structp png, png_bytep from, png_size_t count) {
  auto& out = *static_cast<std::string*>(png_get_io_ptr(png));
  out.append(reinterpret_cast<const char*>(from), count);
}

// A reader in steps. libpng leaves each of its calls, where something is wrong, by a jump to the
// last setjmp, past whatever has a destructor: so each step makes its own setjmp, and holds
// nothing.
class PngReader {
 public:
  explicit PngReader(std::string_view bytes)
      : left_(bytes),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_out, be_silent)),
        info_(png_ != nullptr ? png_create_info_struct(png_) : nullptr) {
    if (info_ == nullptr) throw std::bad_alloc();
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  bool read_head() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, &left_, read_bytes);
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);  // ours are tighter, and said
    png_read_info(png_, info_);
    return true;
  }

  // Asks for whole bytes in the machine's order, blue first.
  bool choose_layout(bool is_grey) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    const int type = png_get_color_type(png_, info_);
    if (is_grey) {
      png_set_strip_16(png_);
      png_set_strip_alpha(png_);
    } else {
      png_set_swap(png_);
      png_set_tRNS_to_alpha(png_);
    }
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if ((type & PNG_COLOR_MASK_COLOR) == 0) {
      png_set_expand_gray_1_2_4_to_8(png_);
      // Opacity stands beside three colours, or beside none that anyone reads.
      if (!is_grey && has_opacity()) png_set_gray_to_rgb(png_);
    } else if (is_grey) {
      constexpr int kSilently = 1;
      png_set_rgb_to_gray(png_, kSilently, 0.299, 0.587);
    } else {
      png_set_bgr(png_);
    }
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  bool read_rows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  int width() const { return static_cast<int>(png_get_image_width(png_, info_)); }
  int height() const { return static_cast<int>(png_get_image_height(png_, info_)); }
  int channels() const { return png_get_channels(png_, info_); }
  bool is_wide() const { return png_get_bit_depth(png_, info_) == 16; }

 private:
  bool has_opacity() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_ALPHA) != 0 ||
           png_get_valid(png_, info_, PNG_INFO_tRNS) != 0;
  }

  std::string_view left_;
  png_structp png_;
  png_infop info_;
};

std::vector<uint8_t*> rows_of(cv::Mat& picture) {
  std::vector<uint8_t*> rows(picture.rows);
  for (int v = 0; v < picture.rows; ++v) rows[v] = picture.ptr(v);
  return rows;
}

int colour_type(int channels) {
  switch (channels) {
    case 1:
      return PNG_COLOR_TYPE_GRAY;
    case 3:
      return PNG_COLOR_TYPE_RGB;
    default:
      return PNG_COLOR_TYPE_RGB_ALPHA;
  }
}

bool write_small(png_structp png, png_infop info, const cv::Mat& picture, uint8_t** rows,
                 std::string& out) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &out, append_bytes, nullptr);
  png_set_compression_level(png, Z_BEST_COMPRESSION);
  png_set_compression_strategy(png, Z_DEFAULT_STRATEGY);
  png_set_IHDR(png, info, picture.cols, picture.rows, picture.depth() == CV_16U ? 16 : 8,
               colour_type(picture.channels()), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_bgr(png);
  png_set_swap(png);
  png_write_image(png, rows);
  png_write_end(png, info);
  return true;
}

std::string small_png(const cv::Mat& picture) {
  cv::Mat rows_to_read = picture;  // libpng takes rows that it does not change for changeable
  std::vector<uint8_t*> rows = rows_of(rows_to_read);
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jump_out, be_silent);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool is_written = info != nullptr && write_small(png, info, picture, rows.data(), out);
  png_destroy_write_struct(&png, &info);
  if (!is_written) throw std::runtime_error("png_bytes: out of memory");
  return out;
}

cv::Mat red_first(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  cv::Mat out;
  cv::cvtColor(picture, out, picture.channels() == 3 ? cv::COLOR_BGR2RGB : cv::COLOR_BGRA2RGBA);
  return out;
}

// The rows as the format packs them: a byte that says that they are not filtered, and the larger
// byte of a number first. A filter would make noisy pictures and masks of few values larger.
std::vector<uint8_t> unfiltered_rows(const cv::Mat& picture) {
  const cv::Mat rows = red_first(picture);
  const size_t row_bytes = static_cast<size_t>(rows.cols) * rows.elemSize();
  std::vector<uint8_t> out((row_bytes + 1) * static_cast<size_t>(rows.rows));
  for (int v = 0; v < rows.rows; ++v) {
    const uint8_t* from = rows.ptr(v);
    uint8_t* to = out.data() + (row_bytes + 1) * static_cast<size_t>(v) + 1;
    if (rows.depth() == CV_8U) {
      std::memcpy(to, from, row_bytes);
      continue;
    }
    for (size_t i = 0; i < row_bytes; i += 2) {
      uint16_t number = 0;
      std::memcpy(&number, from + i, sizeof number);
      to[i] = static_cast<uint8_t>(number >> 8);
      to[i + 1] = static_cast<uint8_t>(number);
    }
  }
  return out;
}

void append_number(std::string& out, uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(number >> shift));
}

void append_chunk(std::string& out, std::string_view type, std::string_view data) {
  append_number(out, static_cast<uint32_t>(data.size()));
  const size_t begin = out.size();
  out.append(type).append(data);
  append_number(out, crc32(std::string_view(out).substr(begin)));
}

// libpng packs by zlib alone, so that the file's chunks are written here.
std::string fast_png(const cv::Mat& picture) {
  std::string head;
  append_number(head, static_cast<uint32_t>(picture.cols));
  append_number(head, static_cast<uint32_t>(picture.rows));
  constexpr char kDeflate = 0, kAdaptiveFilters = 0, kNotInterlaced = 0;
  for (const int byte : {picture.depth() == CV_16U ? 16 : 8, colour_type(picture.channels()),
                         int{kDeflate}, int{kAdaptiveFilters}, int{kNotInterlaced}}) {
    head.push_back(static_cast<char>(byte));
  }
  const std::string packed = zlib_packed(unfiltered_rows(picture));
  std::string out = "\x89PNG\r\n\x1a\n";
  out.reserve(packed.size() + 64);
  append_chunk(out, "IHDR", head);
  constexpr size_t kMostInChunk = size_t{1} << 30;  // the format's own limit is 2^31 - 1
  for (std::string_view rest = packed; !rest.empty();) {
    append_chunk(out, "IDAT", rest.substr(0, kMostInChunk));
    rest.remove_prefix(std::min(rest.size(), kMostInChunk));
  }
  append_chunk(out, "IEND", "");
  return out;
}

}  // namespace

std::optional<cv::Size> png_size(std::string_view bytes) {
  // The format's first chunk; libpng would read on to the pixels, which a torn file may not have.
  constexpr size_t kWidthAt = 16, kHeightAt = 20, kEnd = 24;
  if (bytes.size() < kEnd) return std::nullopt;
  const auto* head = reinterpret_cast<png_const_bytep>(bytes.data());
  const png_uint_32 width = png_get_uint_32(head + kWidthAt);
  const png_uint_32 height = png_get_uint_32(head + kHeightAt);
  if (width > PNG_UINT_31_MAX || height > PNG_UINT_31_MAX) return std::nullopt;
  return cv::Size(static_cast<int>(width), static_cast<int>(height));
}

PictureReading decode_png(std::string_view bytes, PictureChannels channels) {
  const bool is_grey = channels == PictureChannels::kGrey;
  PngReader reader(bytes);
  if (!reader.read_head()) return {{}, kTornPicture};
  constexpr int kMostBytesAPixel = 8;
  if (std::string problem = size_problem(reader.width(), reader.height(), kMostBytesAPixel);
      !problem.empty()) {
    return {{}, std::move(problem)};
  }
  if (!reader.choose_layout(is_grey)) return {{}, kTornPicture};
  cv::Mat picture(reader.height(), reader.width(),
                  CV_MAKETYPE(reader.is_wide() ? CV_16U : CV_8U, reader.channels()));
  if (!reader.read_rows(rows_of(picture).data())) return {{}, kTornPicture};
  return {picture, {}};
}

std::string png_bytes(const cv::Mat& picture, PngEffort effort) {
  const int channels = picture.channels();
  if (picture.empty() || (picture.depth() != CV_8U && picture.depth() != CV_16U) ||
      (channels != 1 && channels != 3 && channels != 4)) {
    throw std::runtime_error("png_bytes: 8 or 16 bits in 1, 3 or 4 channels are written alone");
  }
  return effort == PngEffort::kSmall ? small_png(picture) : fast_png(picture);
}

}  // namespace sightline
