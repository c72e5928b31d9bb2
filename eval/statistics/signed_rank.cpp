// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/signed_rank.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sightline {
namespace {

// Twice the ranks of the differences by size, so that those shared are whole numbers too.
struct DoubledRanks {
  std::vector<int64_t> all;
  int64_t of_positive = 0;  // their sum
};

DoubledRanks doubled_ranks(std::span<const double> differences) {
  std::vector<double> sorted;
  for (const double difference : differences) {
    if (difference != 0) sorted.push_back(difference);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](double a, double b) { return std::abs(a) < std::abs(b); });
  DoubledRanks ranks;
  for (size_t first = 0; first < sorted.size();) {
    size_t end = first;
    while (end < sorted.size() && std::abs(sorted[end]) == std::abs(sorted[first])) ++end;
    const auto shared = static_cast<int64_t>(first + 1 + end);  // the first and the last rank
    for (; first < end; ++first) {
      ranks.all.push_back(shared);
      if (sorted[first] > 0) ranks.of_positive += shared;
    }
  }
  return ranks;
}

constexpr size_t kMostExact = 50;

// How probable each sum of the positive ones of some ranks is where signs are a matter of chance,
// by adding one rank after the other.
std::vector<double> law_of_sum(std::span<const int64_t> ranks) {
  std::vector<double> chance = {1};
  for (const int64_t rank : ranks) {
    const auto step = static_cast<size_t>(rank);
    std::vector<double> next(chance.size() + step);
    for (size_t sum = 0; sum < chance.size(); ++sum) {
      next[sum] += chance[sum] / 2;
      next[sum + step] += chance[sum] / 2;
    }
    chance = std::move(next);
  }
  return chance;
}

double exact_share(const DoubledRanks& ranks) {
  const std::vector<double> chance = law_of_sum(ranks.all);
  double share = 0;
  for (auto sum = static_cast<size_t>(ranks.of_positive); sum < chance.size(); ++sum) {
    share += chance[sum];
  }
  return std::min(1.0, share);
}

// How many sums of ranks of so many differences, from none on, have together no more than the
// chance of one side of a 95 % interval.
int64_t sums_rejected(int64_t n) {
  if (n > static_cast<int64_t>(kMostExact)) {
    const auto real = static_cast<double>(n);
    const double spread = std::sqrt(real * (real + 1) * (2 * real + 1) / 24);
    return static_cast<int64_t>(std::floor(real * (real + 1) / 4 + 0.5 - kZ95 * spread));
  }
  std::vector<int64_t> ranks;
  for (int64_t rank = 1; rank <= n; ++rank) ranks.push_back(rank);
  const std::vector<double> chance = law_of_sum(ranks);
  int64_t sums = 0;
  double together = 0;
  for (const double of_sum : chance) {
    together += of_sum;
    if (together > kTail95) break;
    ++sums;
  }
  return sums;
}

// How many means of two, each value with itself as well, are at most `limit`.
int64_t means_up_to(std::span<const double> sorted, double limit) {
  int64_t count = 0;
  size_t end = sorted.size();
  for (size_t i = 0; i < sorted.size(); ++i) {
    while (end > i && (sorted[i] + sorted[end - 1]) / 2 > limit) --end;
    if (end <= i) break;
    count += static_cast<int64_t>(end - i);
  }
  return count;
}

// The k-th least of these means, k from 1, found by halving: there are too many to list.
double mean_of_rank(std::span<const double> sorted, int64_t k) {
  double low = sorted.front();
  double high = sorted.back();
  if (means_up_to(sorted, low) >= k) return low;
  while (true) {
    const double middle = low + (high - low) / 2;
    if (middle <= low || middle >= high) return high;
    means_up_to(sorted, middle) >= k ? high = middle : low = middle;
  }
}

}  // namespace

double p_middle_above_zero(std::span<const double> differences) {
  const DoubledRanks ranks = doubled_ranks(differences);
  if (ranks.all.empty()) return 1;
  if (ranks.all.size() <= kMostExact) return exact_share(ranks);
  double sum = 0;
  double squares = 0;
  for (const int64_t rank : ranks.all) {
    sum += static_cast<double>(rank);
    squares += static_cast<double>(rank) * static_cast<double>(rank);
  }
  constexpr double kHalfARank = 1;  // of doubled ones
  const double excess = static_cast<double>(ranks.of_positive) - sum / 2 - kHalfARank;
  return normal_cdf(-excess / (std::sqrt(squares) / 2));
}

Measured middle_of(std::span<const double> differences) {
  if (differences.empty()) return {};
  std::vector<double> sorted(differences.begin(), differences.end());
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<int64_t>(sorted.size());
  const int64_t means = n * (n + 1) / 2;
  Measured middle;
  middle.value = (mean_of_rank(sorted, (means + 1) / 2) + mean_of_rank(sorted, means / 2 + 1)) / 2;
  const int64_t rank = sums_rejected(n);
  if (rank >= 1) {
    middle.ci95 = {mean_of_rank(sorted, rank), mean_of_rank(sorted, means + 1 - rank)};
  }
  return middle;
}

}  // namespace sightline
