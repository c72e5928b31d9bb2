// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/picture/radiance_file.h"

#include <algorithm>
#include <cctype>
#include <string>

#include <opencv2/core.hpp>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

PictureReading decoded(std::string_view bytes) {
  if (bytes.starts_with("\x76\x2f\x31\x01")) return decode_exr(bytes);
  if (bytes.starts_with("#?")) return decode_hdr(bytes);
  return {{}, "is no OpenEXR and no Radiance picture (.exr, .hdr)"};
}

}  // namespace

bool is_radiance_name(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return ending == ".exr" || ending == ".hdr";
}

PictureReading decode_radiance(std::string_view bytes) {
  PictureReading reading = decoded(bytes);
  if (reading.pixels.empty()) return reading;
  if (!cv::checkRange(reading.pixels)) return {{}, "has pixels that are no finite numbers"};
  reading.pixels = cv::max(reading.pixels, 0.0);
  return reading;
}

PictureReading read_radiance_file(const std::filesystem::path& file) {
  const auto [bytes, problem] = bytes_of_picture(file);
  if (!problem.empty()) return {{}, problem};
  return decode_radiance(bytes);
}

}  // namespace sightline
