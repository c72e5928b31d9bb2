// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

namespace sightline {

/// Where in a pixel the scene is sampled: offsets from its centre in px, the same in every pixel,
/// ordered from the centre outwards. The samples of all pixels form one lattice (rank 1). No two of
/// a pixel share a column or a row, so an edge along an axis is known to 1 / (count sqrt(12)) px,
/// where a square grid knows it to 1 / sqrt(12 count) px. Along the lattice's closest
/// samples it is known no better than on such a grid.
struct SamplePattern {
  int count = 1;
  std::vector<float> x, y;
  /// For engines that draw the lattice as one finer, skewed image: its column and row of a sample
  /// at p are the integers skewed_from_pixel (p - first), row by row. The determinant is `count`.
  std::array<int, 4> skewed_from_pixel{1, 0, 0, 1};
  std::array<double, 2> first{0, 0};
};

/// Throws InputError for a number of samples that cannot be had.
const SamplePattern& sample_pattern(int samples_per_pixel);

}  // namespace sightline
