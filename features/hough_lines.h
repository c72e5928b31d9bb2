// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "features/extractor.h"

namespace sightline {

/// For each of the prediction's two edges the strongest line of the Hough transform (of Canny's
/// edge pixels in the window) that is nearly parallel to it, fitted by least squares to the edge
/// pixels that agree: two lines, or fewer where there is none. Where the search is gated, lines
/// that pass outside it do not count.
std::vector<ImageLine> strongest_lines(const ExtractionInput& input, const cv::Rect& window,
                                       const LineOptions& options);

}  // namespace sightline
