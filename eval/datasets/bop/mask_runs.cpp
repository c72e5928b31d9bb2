// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/mask_runs.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <opencv2/core.hpp>

#include "eval/datasets/bop/numbered.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

// The run lengths of an entry; none where it is not as its format has it.
std::optional<RunLengths> run_lengths_in(const Json& entry) {
  const std::vector<double> size = numbers_in(entry, "size", 2);
  const double pixels = size[0] * size[1];
  if (size[0] < 1 || size[1] < 1 || pixels > kMaxPicturePixels) return std::nullopt;
  RunLengths runs{.height_px = static_cast<int>(size[0]), .width_px = static_cast<int>(size[1])};
  const Json& counts = value_in(entry, "counts");
  if (!counts.is_array()) return std::nullopt;
  uint64_t left = static_cast<uint64_t>(runs.height_px) * static_cast<uint64_t>(runs.width_px);
  for (const Json& count : counts) {
    if (!count.is_number_unsigned() || count.get<uint64_t>() > left) return std::nullopt;
    left -= count.get<uint64_t>();
    runs.counts.push_back(count.get<uint32_t>());
  }
  if (left > 0) return std::nullopt;
  return runs;
}

}  // namespace

MaskRuns::MaskRuns(const std::filesystem::path& file) {
  try {
    with_json(file, [this](const Json& masks) {
      const NumberedEntries entries(masks);
      for (const auto& [gt_id, entry] : entries.all()) {
        try {
          if (auto runs = run_lengths_in(*entry)) masks_.emplace(gt_id, std::move(*runs));
        } catch (const InputError&) {
          continue;  // its neighbours may be whole
        }
      }
    });
  } catch (const InputError&) {
    masks_.clear();
  }
}

cv::Mat MaskRuns::mask(int gt_id) const {
  const auto found = masks_.find(gt_id);
  if (found == masks_.end()) return {};
  const RunLengths& runs = found->second;
  // Columns of the image are rows here, in which the runs lie one behind the other.
  cv::Mat columns(runs.width_px, runs.height_px, CV_8U);
  uint8_t* begin = columns.data;
  uint8_t value = 0;
  for (const uint32_t count : runs.counts) {
    begin = std::fill_n(begin, count, value);
    value = static_cast<uint8_t>(255 - value);
  }
  cv::Mat mask;
  cv::transpose(columns, mask);
  return mask;
}

}  // namespace sightline
