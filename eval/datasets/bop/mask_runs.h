// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace sightline {

/// A mask as run lengths, which together are as many as its pixels.
struct RunLengths {
  int height_px = 0;
  int width_px = 0;
  std::vector<uint32_t> counts{};
};

/// The masks of an image's instances in a file of BOP's imagewise format (KEY.mask_visib.json),
/// whose entries are as COCO writes masks: `size` is height and width, `counts` the lengths of runs
/// of 0 and 1 in turn, column by column, as a list or as the text that COCO's API packs them into.
class MaskRuns {
 public:
  /// Reads the file. Of one that cannot be read there are no masks, nor of entries that are not so:
  /// that is one image's failure and not the set's.
  explicit MaskRuns(const std::filesystem::path& file);

  /// The mask of an instance, CV_8U, 0 and 255; empty where there is none.
  cv::Mat mask(int gt_id) const;

 private:
  std::map<int64_t, RunLengths> masks_;
};

}  // namespace sightline
