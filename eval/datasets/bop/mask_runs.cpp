// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/mask_runs.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "eval/datasets/bop/numbered.h"
#include "eval/output/json.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

// The run lengths that COCO's API packs into a text: each as its difference from the last but one,
// from the fourth on, in groups of five bits, the lowest first, whose sixth says that more follow.
// None of a text that ends within one, or has one that is too long.
std::optional<std::vector<int64_t>> unpacked_counts(std::string_view text) {
  constexpr int kBits = 5, kMostBits = 60;
  constexpr int64_t kMore = 1 << kBits, kSign = 1 << (kBits - 1);
  std::vector<int64_t> counts;
  int64_t value = 0;
  int shift = 0;
  for (const char letter : text) {
    const int64_t group = static_cast<unsigned char>(letter) - 48;
    if (group < 0 || group >= 2 * kMore || shift > kMostBits - kBits) return std::nullopt;
    value |= (group & (kMore - 1)) << shift;
    shift += kBits;
    if ((group & kMore) != 0) continue;
    if ((group & kSign) != 0) value -= int64_t{1} << shift;
    if (counts.size() > 2) value += counts[counts.size() - 2];
    if (value < 0 || value > kMaxPicturePixels) return std::nullopt;
    counts.push_back(value);
    value = 0;
    shift = 0;
  }
  if (shift > 0) return std::nullopt;
  return counts;
}

// The runs as they are listed or packed; none of what is neither.
std::optional<std::vector<int64_t>> counts_of(const Json& json) {
  if (json.is_string()) return unpacked_counts(json.get<std::string>());
  if (!json.is_array()) return std::nullopt;
  std::vector<int64_t> counts;
  for (const Json& count : json) {
    if (!count.is_number_integer()) return std::nullopt;
    counts.push_back(count.get<int64_t>());
  }
  return counts;
}

// The run lengths of an entry; none where it is not as its format has it.
std::optional<RunLengths> run_lengths_in(const Json& entry) {
  const std::vector<double> size = numbers_in(entry, "size", 2);
  const double pixels = size[0] * size[1];
  if (size[0] < 1 || size[1] < 1 || pixels > kMaxPicturePixels) return std::nullopt;
  RunLengths runs{.height_px = static_cast<int>(size[0]), .width_px = static_cast<int>(size[1])};
  const auto counts = counts_of(value_in(entry, "counts"));
  if (!counts) return std::nullopt;
  int64_t left = static_cast<int64_t>(runs.height_px) * runs.width_px;
  for (const int64_t count : *counts) {
    if (count < 0 || count > left) return std::nullopt;
    left -= count;
    runs.counts.push_back(static_cast<uint32_t>(count));
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
