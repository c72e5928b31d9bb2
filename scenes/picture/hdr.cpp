// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Radiance's pictures (G. Ward, Real Pixels, Graphics Gems II, 1991): three mantissas and an
// exponent that they share, a byte each. stb_image and OpenCV, which read them too, take the end of
// a torn file for black.
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

using Rgbe = std::array<uint8_t, 4>;

// The bytes that are left of a file.
class HdrBytes {
 public:
  explicit HdrBytes(std::string_view bytes) : left_(bytes) {}

  // Up to the line's end; none where no line ends any more.
  std::optional<std::string> line() {
    const size_t end = left_.find('\n');
    if (end == std::string_view::npos) return std::nullopt;
    std::string text(left_.substr(0, end));
    left_.remove_prefix(end + 1);
    return text;
  }
  // False where there are not so many.
  bool take(uint8_t* to, size_t count) {
    if (left_.size() < count) return false;
    for (size_t i = 0; i < count; ++i) to[i] = static_cast<uint8_t>(left_[i]);
    left_.remove_prefix(count);
    return true;
  }
  // A row begins so that is packed by channel.
  bool begins_packed_row(size_t width) const {
    if (width < 8 || width > 0x7fff || left_.size() < 4) return false;
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(left_[i]); };
    return byte(0) == 2 && byte(1) == 2 && (byte(2) << 8 | byte(3)) == static_cast<int>(width);
  }

 private:
  std::string_view left_;
};

// Runs of one value (a count above 128) and values as they are.
bool take_packed_channel(HdrBytes& bytes, size_t channel, std::vector<Rgbe>& row) {
  size_t at = 0;
  while (at < row.size()) {
    uint8_t count = 0, value = 0;
    if (!bytes.take(&count, 1)) return false;
    const bool is_run = count > 128;
    const size_t end = at + (is_run ? count - 128 : count);
    if (end == at || end > row.size()) return false;
    if (is_run && !bytes.take(&value, 1)) return false;
    for (; at < end; ++at) {
      if (!is_run && !bytes.take(&value, 1)) return false;
      row[at][channel] = value;
    }
  }
  return true;
}

// Pixel by pixel; mantissas of 1 repeat the pixel before, as often as the fourth byte says, and
// several of them are the digits of one count.
bool take_plain_row(HdrBytes& bytes, std::vector<Rgbe>& row) {
  int shift = 0;
  for (size_t at = 0; at < row.size();) {
    Rgbe pixel{};
    if (!bytes.take(pixel.data(), pixel.size())) return false;
    const bool is_repeat = pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1;
    if (!is_repeat) {
      row[at++] = pixel;
      shift = 0;
      continue;
    }
    const size_t count = shift > 24 ? row.size() : static_cast<size_t>(pixel[3]) << shift;
    if (at == 0 || count > row.size() - at) return false;
    for (const size_t end = at + count; at < end; ++at) row[at] = row[at - 1];
    shift += 8;
  }
  return true;
}

bool take_row(HdrBytes& bytes, std::vector<Rgbe>& row) {
  if (!bytes.begins_packed_row(row.size())) return take_plain_row(bytes, row);
  Rgbe head{};
  bytes.take(head.data(), head.size());
  for (size_t channel = 0; channel < head.size(); ++channel) {
    if (!take_packed_channel(bytes, channel, row)) return false;
  }
  return true;
}

cv::Vec3f light_of(const Rgbe& pixel) {
  constexpr int kExponentOfOne = 128 + 8;
  if (pixel[3] == 0) return {0, 0, 0};
  const float unit = std::ldexp(1.0f, pixel[3] - kExponentOfOne);
  return {unit * pixel[2], unit * pixel[1], unit * pixel[0]};
}

struct HdrHead {
  int width = 0, height = 0;
  std::string problem;
};

HdrHead take_head(HdrBytes& bytes) {
  std::optional<std::string> line = bytes.line();
  for (; line && !line->empty(); line = bytes.line()) {
    if (line->starts_with("FORMAT=") && *line != "FORMAT=32-bit_rle_rgbe") {
      return {0, 0, "has the format " + line->substr(7) + ", must be 32-bit_rle_rgbe"};
    }
  }
  const std::optional<std::string> size = line ? bytes.line() : std::nullopt;
  HdrHead head;
  if (!size) return {0, 0, kTornPicture};
  if (std::sscanf(size->c_str(), "-Y %d +X %d", &head.height, &head.width) != 2) {
    return {0, 0, "has the size \"" + size->substr(0, 40) + "\", must be -Y HEIGHT +X WIDTH"};
  }
  return head;
}

}  // namespace

PictureReading decode_hdr(std::string_view whole) {
  HdrBytes bytes(whole);
  const HdrHead head = take_head(bytes);
  if (!head.problem.empty()) return {{}, head.problem};
  constexpr int kBytesAPixel = 12;
  if (std::string problem = size_problem(head.width, head.height, kBytesAPixel); !problem.empty()) {
    return {{}, std::move(problem)};
  }
  cv::Mat picture(head.height, head.width, CV_32FC3);
  std::vector<Rgbe> row(static_cast<size_t>(head.width));
  for (int v = 0; v < head.height; ++v) {
    if (!take_row(bytes, row)) return {{}, kTornPicture};
    cv::Vec3f* to = picture.ptr<cv::Vec3f>(v);
    for (size_t u = 0; u < row.size(); ++u) to[u] = light_of(row[u]);
  }
  return {picture, {}};
}

}  // namespace sightline
