// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The inner loops of pose/orientation/consensus_search.cpp on plain arrays (see
// pose/multiversion.h): which matched points keep their distance from a given one, and how many a
// pose brings together. In single precision, because they only choose what is looked at closely.
#pragma once

#include <cstddef>
#include <vector>

namespace sightline::kernel {

/// Arrays of points are filled up to a multiple of this, so that no loop has a remainder.
inline constexpr std::size_t kPairLanes = 16;

/// Matched points x_a, x_b by coordinate, and the variance v of each pair's noise in units of that
/// of a pair of weight 1. What fills the arrays up has a variance so negative that no tolerance
/// admits it.
struct PairRows {
  std::vector<float> ax, ay, az, bx, by, bz, v;
  std::size_t n = 0;

  std::size_t padded_size() const { return ax.size(); }
};

/// Makes room for n pairs, all of them filling.
void resize(PairRows& pairs, std::size_t n);

/// The pairs at `indices` of `from`.
void gather(const PairRows& from, const std::vector<int>& indices, PairRows& to);

/// A pair that others are compared with.
struct PairPivot {
  float a[3];
  float b[3];
  float v;
};

PairPivot pivot_at(const PairRows& pairs, std::size_t index);

/// What distances from a pivot are compared by. The squared difference | |b_k - b| - s |a_k - a|
/// |^2 is to be at most `tolerance2` (v_k + v + spread |a_k - a|^2); pairs nearer to the pivot than
/// `least_length` in both clouds say nothing and are left out.
struct PairTest {
  float scale = 1;       ///< s
  float tolerance2 = 0;  ///< squared, for a sum of variances of 1
  float spread = 0;      ///< what the error of s adds
  float least_length2 = 0;
};

/// A run of pairs; it begins at a multiple of kPairLanes.
struct PairWindow {
  std::size_t begin = 0;
  std::size_t size = 0;
};

inline PairWindow all_of(const PairRows& pairs) {
  return {0, pairs.padded_size()};
}

/// The indices, ascending, of the pairs of the window that pass the test. `flags` is room to work
/// in.
void compatible_pairs(const PairRows& pairs, const PairWindow& window, const PairPivot& pivot,
                      const PairTest& test, std::vector<int>& flags, std::vector<int>& indices);

/// How many pairs pass the test.
int count_compatible(const PairRows& pairs, const PairPivot& pivot, const PairTest& test);

/// x_b = m x_a + t, row by row (m00 m01 m02 t0 m10 ...).
struct PairMap {
  float rows[12];
};

/// The sum over the pairs of the window of max(0, 1 - r^2 / (radius2 v)), r the distance that the
/// map leaves.
float consensus_score(const PairRows& pairs, const PairWindow& window, const PairMap& map,
                      float radius2);

}  // namespace sightline::kernel
