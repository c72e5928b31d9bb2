// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace sightline {

/// The mask of an instance in a file of BOP's imagewise format (KEY.mask_visib.json), whose entries
/// are as COCO writes masks: `size` is height and width, `counts` the lengths of runs of 0 and 1 in
/// turn, column by column. CV_8U, 0 and 255; empty where the file has no such entry, or it is not
/// so: that is one image's failure and not the set's.
cv::Mat read_mask_runs(const std::filesystem::path& file, int gt_id);

}  // namespace sightline
