// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/kernels/pair_kernel.h"

#include <algorithm>
#include <cmath>

#include "pose/multiversion.h"

namespace sightline::kernel {
namespace {

constexpr float kFillingVariance = -1e30f;

/// The arrays of PairRows without their owner, so that the loops see that they do not overlap.
struct Columns {
  const float* ax;
  const float* ay;
  const float* az;
  const float* bx;
  const float* by;
  const float* bz;
  const float* v;
  std::size_t size;
};

Columns columns_of(const PairRows& p, const PairWindow& window) {
  const std::size_t at = window.begin;
  const std::size_t size = std::min(window.size, p.padded_size() - at);
  return {p.ax.data() + at, p.ay.data() + at, p.az.data() + at, p.bx.data() + at,
          p.by.data() + at, p.bz.data() + at, p.v.data() + at,  size};
}

inline int passes(const Columns& c, std::size_t k, const PairPivot& p, const PairTest& t) {
  const float dax = c.ax[k] - p.a[0], day = c.ay[k] - p.a[1], daz = c.az[k] - p.a[2];
  const float dbx = c.bx[k] - p.b[0], dby = c.by[k] - p.b[1], dbz = c.bz[k] - p.b[2];
  const float a2 = dax * dax + day * day + daz * daz;
  const float b2 = dbx * dbx + dby * dby + dbz * dbz;
  const float difference = std::sqrt(b2) - t.scale * std::sqrt(a2);
  const float allowed = t.tolerance2 * (c.v[k] + p.v + t.spread * a2);
  return static_cast<int>(difference * difference <= allowed) &
         static_cast<int>(a2 >= t.least_length2);
}

SIGHTLINE_MULTIVERSION
void flag_compatible(const Columns& c, const PairPivot& pivot, const PairTest& test,
                     int* __restrict flags) {
  for (std::size_t k = 0; k < c.size; ++k) flags[k] = passes(c, k, pivot, test);
}

SIGHTLINE_MULTIVERSION
int count_flags(const Columns& c, const PairPivot& pivot, const PairTest& test) {
  int count = 0;
  for (std::size_t k = 0; k < c.size; ++k) count += passes(c, k, pivot, test);
  return count;
}

SIGHTLINE_MULTIVERSION
float score_of(const Columns& c, const PairMap& map, float radius2) {
  constexpr std::size_t kLanes = kPairLanes;
  const float* const m = map.rows;
  // One sum a lane: a single sum would have to be taken in order.
  float sums[kLanes] = {};
  for (std::size_t k = 0; k < c.size; k += kLanes) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const float x = c.ax[k + i], y = c.ay[k + i], z = c.az[k + i];
      const float ex = m[0] * x + m[1] * y + m[2] * z + m[3] - c.bx[k + i];
      const float ey = m[4] * x + m[5] * y + m[6] * z + m[7] - c.by[k + i];
      const float ez = m[8] * x + m[9] * y + m[10] * z + m[11] - c.bz[k + i];
      const float limit = radius2 * c.v[k + i];
      const float left = limit - (ex * ex + ey * ey + ez * ez);
      sums[i] += left > 0 ? left / limit : 0.0f;
    }
  }
  float sum = 0;
  for (const float lane : sums) sum += lane;
  return sum;
}

}  // namespace

void resize(PairRows& pairs, std::size_t n) {
  const std::size_t padded = (n + kPairLanes - 1) / kPairLanes * kPairLanes;
  for (std::vector<float>* row :
       {&pairs.ax, &pairs.ay, &pairs.az, &pairs.bx, &pairs.by, &pairs.bz}) {
    row->assign(padded, 0);
  }
  pairs.v.assign(padded, kFillingVariance);
  pairs.n = n;
}

void gather(const PairRows& from, const std::vector<int>& indices, PairRows& to) {
  resize(to, indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto k = static_cast<std::size_t>(indices[i]);
    to.ax[i] = from.ax[k];
    to.ay[i] = from.ay[k];
    to.az[i] = from.az[k];
    to.bx[i] = from.bx[k];
    to.by[i] = from.by[k];
    to.bz[i] = from.bz[k];
    to.v[i] = from.v[k];
  }
}

PairPivot pivot_at(const PairRows& p, std::size_t index) {
  return {
      {p.ax[index], p.ay[index], p.az[index]}, {p.bx[index], p.by[index], p.bz[index]}, p.v[index]};
}

void compatible_pairs(const PairRows& pairs, const PairWindow& window, const PairPivot& pivot,
                      const PairTest& test, std::vector<int>& flags, std::vector<int>& indices) {
  const Columns c = columns_of(pairs, window);
  flags.resize(c.size);
  indices.resize(c.size);
  flag_compatible(c, pivot, test, flags.data());
  std::size_t count = 0;
  // Without a branch: which of them pass cannot be foreseen.
  for (std::size_t k = 0; k < c.size; ++k) {
    indices[count] = static_cast<int>(window.begin + k);
    count += static_cast<std::size_t>(flags[k]);
  }
  indices.resize(count);
}

int count_compatible(const PairRows& pairs, const PairPivot& pivot, const PairTest& test) {
  return count_flags(columns_of(pairs, all_of(pairs)), pivot, test);
}

float consensus_score(const PairRows& pairs, const PairWindow& window, const PairMap& map,
                      float radius2) {
  return score_of(columns_of(pairs, window), map, radius2);
}

}  // namespace sightline::kernel
