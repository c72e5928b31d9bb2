// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/mask_runs.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "eval/datasets/bop/numbered.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

cv::Mat mask_of(const Json& entry) {
  const std::vector<double> size = numbers_in(entry, "size", 2);
  const double pixels = size[0] * size[1];
  if (size[0] < 1 || size[1] < 1 || pixels > kMaxPicturePixels) return {};
  const Json& counts = value_in(entry, "counts");
  if (!counts.is_array()) return {};
  // Columns of the image are rows here, in which the runs lie one behind the other.
  cv::Mat columns = cv::Mat::zeros(static_cast<int>(size[1]), static_cast<int>(size[0]), CV_8U);
  uint64_t begin = 0;
  uint8_t value = 0;
  for (const Json& count : counts) {
    if (!count.is_number_unsigned()) return {};
    const uint64_t length = count.get<uint64_t>();
    if (length > columns.total() - begin) return {};
    std::fill_n(columns.data + begin, length, value);
    begin += length;
    value = static_cast<uint8_t>(255 - value);
  }
  if (begin != columns.total()) return {};
  cv::Mat mask;
  cv::transpose(columns, mask);
  return mask;
}

}  // namespace

cv::Mat read_mask_runs(const std::filesystem::path& file, int gt_id) {
  cv::Mat mask;
  try {
    with_json(file, [&](const Json& masks) {
      const Json* const entry = NumberedEntries(masks).find(gt_id);
      if (entry != nullptr) mask = mask_of(*entry);
    });
  } catch (const InputError&) {
    return {};
  }
  return mask;
}

}  // namespace sightline
