// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "features/extractor.h"

// The functions behind the catalogue in features/extractor.cpp, one a file of this folder.
namespace sightline {

Observation extract_contour(const ExtractionInput& input);
Observation extract_edges_else_contour(const ExtractionInput& input);
Observation extract_harris_subpixel(const ExtractionInput& input);
Observation extract_hough_intersection(const ExtractionInput& input);
Observation extract_hough_subpixel(const ExtractionInput& input);
Observation extract_lsd_intersection(const ExtractionInput& input);
Observation extract_model_edges(const ExtractionInput& input);
Observation extract_shi_tomasi_nearest(const ExtractionInput& input);

}  // namespace sightline
