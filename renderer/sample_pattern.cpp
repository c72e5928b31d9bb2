// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sample_pattern.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/files/input_error.h"
#include "scenes/scene/imaging.h"

namespace sightline {
namespace {

using Vector = std::array<int, 2>;

int dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1];
}

// The two shortest vectors of the lattice of (1, generator) and (0, count): Gauss's reduction.
std::array<Vector, 2> reduced_basis(int count, int generator) {
  Vector shorter{1, generator};
  Vector longer{0, count};
  if (dot(longer, longer) < dot(shorter, shorter)) std::swap(shorter, longer);
  for (;;) {
    const int length2 = dot(shorter, shorter);
    const int times = static_cast<int>(std::lround(1.0 * dot(shorter, longer) / length2));
    longer = {longer[0] - times * shorter[0], longer[1] - times * shorter[1]};
    if (dot(longer, longer) >= length2) return {shorter, longer};
    std::swap(shorter, longer);
  }
}

// The generator whose lattice has the longest shortest vector. Coprime with the count, so that no
// two samples of a pixel share a row.
int best_generator(int count) {
  int best = 1;
  int best_length2 = 0;
  for (int generator = 1; generator < count; ++generator) {
    if (std::gcd(generator, count) != 1) continue;
    const Vector shortest = reduced_basis(count, generator)[0];
    if (dot(shortest, shortest) <= best_length2) continue;
    best_length2 = dot(shortest, shortest);
    best = generator;
  }
  return best;
}

SamplePattern make_pattern(int count) {
  SamplePattern pattern;
  pattern.count = count;
  const int generator = best_generator(count);
  const auto offset = [count](int i) { return (i + 0.5) / count - 0.5; };
  std::vector<std::array<double, 2>> samples;
  for (int i = 0; i < count; ++i) samples.push_back({offset(i), offset(generator * i % count)});
  pattern.first = samples.front();
  std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) {
    return std::hypot(a[0], a[1]) < std::hypot(b[0], b[1]);
  });
  for (const auto& [x, y] : samples) {
    pattern.x.push_back(static_cast<float>(x));
    pattern.y.push_back(static_cast<float>(y));
  }
  if (count == 1) return pattern;
  auto [u, v] = reduced_basis(count, generator);
  if (u[0] * v[1] - u[1] * v[0] < 0) v = {-v[0], -v[1]};
  // The inverse of the basis (u v) / count.
  pattern.skewed_from_pixel = {v[1], -v[0], -u[1], u[0]};
  return pattern;
}

}  // namespace

const SamplePattern& sample_pattern(int samples_per_pixel) {
  static const std::map<int, SamplePattern> patterns = [] {
    std::map<int, SamplePattern> made;
    for (const int count : kSampleCounts) made.emplace(count, make_pattern(count));
    return made;
  }();
  const auto found = patterns.find(samples_per_pixel);
  if (found != patterns.end()) return found->second;
  throw InputError(fmt::format("samples_per_pixel is {}, must be one of {}", samples_per_pixel,
                               fmt::join(kSampleCounts, ", ")));
}

}  // namespace sightline
