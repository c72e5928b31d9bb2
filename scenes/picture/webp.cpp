// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <opencv2/core.hpp>
#include <webp/decode.h>

#include "scenes/picture/codecs.h"

namespace sightline {
namespace {

const uint8_t* webp_data(std::string_view bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

}  // namespace

std::optional<cv::Size> webp_size(std::string_view bytes) {
  int width = 0, height = 0;
  if (WebPGetInfo(webp_data(bytes), bytes.size(), &width, &height) == 0) return std::nullopt;
  return cv::Size(width, height);
}

PictureReading decode_webp(std::string_view bytes) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(webp_data(bytes), bytes.size(), &features) != VP8_STATUS_OK) {
    return {{}, kTornPicture};
  }
  const int channels = features.has_alpha != 0 ? 4 : 3;
  if (std::string problem = size_problem(features.width, features.height, channels);
      !problem.empty()) {
    return {{}, std::move(problem)};
  }
  cv::Mat picture(features.height, features.width, CV_8UC(channels));
  const size_t size = picture.total() * picture.elemSize();
  const auto decode = channels == 4 ? WebPDecodeBGRAInto : WebPDecodeBGRInto;
  if (decode(webp_data(bytes), bytes.size(), picture.data, size, static_cast<int>(picture.step)) ==
      nullptr) {
    return {{}, kTornPicture};
  }
  return {picture, {}};
}

}  // namespace sightline
