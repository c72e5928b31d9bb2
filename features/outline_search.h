// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the extractors that search for a predicted outline share: how far to look, and which side of
// an edge is the brighter.
#pragma once

#include <span>

#include "features/edge_search.h"
#include "features/extractor.h"
#include "features/outline.h"

namespace sightline {

/// True where the feature is known to a few pixels (SearchOptions::good_half_px).
bool is_prior_good(const ExtractionInput& input);

/// The half-size of the window that holds all places where the feature may be found.
int search_window_half_px(const ExtractionInput& input);

/// The least gradient that is an edge, grey levels a pixel.
double gradient_threshold(const SearchOptions& options);

/// The sign of the gradient along outward normals where the background lies beyond: -1 for a target
/// brighter than the background; 0 where the two are too much alike or not known. Where the prior
/// is good it is read off the two sides of the predicted outline, else off the target's inside.
int outline_polarity(const ExtractionInput& input, std::span<const OutlineSample> samples);

/// The gradients wherever edges may lie that belong to these samples.
GradientWindow gradients_around(const ExtractionInput& input,
                                std::span<const OutlineSample> samples);

}  // namespace sightline
