// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "features/extractor.h"

// The functions behind the catalogue in features/extractor.cpp, one a file of this folder.
namespace sightline {

void extract_hough_intersection(const cv::Mat& image, const FeaturePrediction& prediction,
                                const ExtractorOptions& options, Observation& observation);
void extract_shi_tomasi_nearest(const cv::Mat& image, const FeaturePrediction& prediction,
                                const ExtractorOptions& options, Observation& observation);

}  // namespace sightline
