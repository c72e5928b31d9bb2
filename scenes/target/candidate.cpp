// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/candidate.h"

#include <cmath>
#include <numbers>

namespace sightline {
namespace {

double gain_of(const Candidate& candidate, const std::vector<double>& had_in_view) {
  double gain = 0;
  for (size_t v = 0; v < had_in_view.size(); ++v) {
    gain += candidate.worth_in_view[v] / (1 + had_in_view[v]);
  }
  return gain;
}

void drop_near(const Candidate& taken, double min_distance_m, std::vector<Candidate>& candidates) {
  std::erase_if(candidates, [&](const Candidate& other) {
    return (other.feature.position_m - taken.feature.position_m).norm() < min_distance_m;
  });
}

void add_worths(const Candidate& taken, std::vector<double>& had_in_view) {
  for (size_t v = 0; v < had_in_view.size(); ++v) had_in_view[v] += taken.worth_in_view[v];
}

}  // namespace

std::vector<Eigen::Vector3d> directions_all_round(int count) {
  std::vector<Eigen::Vector3d> directions;
  const double golden_rad = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    const double radius = std::sqrt(1 - z * z);
    directions.emplace_back(radius * std::cos(i * golden_rad), radius * std::sin(i * golden_rad),
                            z);
  }
  return directions;
}

void choose(std::vector<Candidate> candidates, int most, double min_distance_m,
            std::vector<Candidate>& chosen) {
  if (candidates.empty()) return;
  std::vector<double> had_in_view(candidates.front().worth_in_view.size(), 0);
  for (const Candidate& before : chosen) {
    add_worths(before, had_in_view);
    drop_near(before, min_distance_m, candidates);
  }
  while (!candidates.empty() && static_cast<int>(chosen.size()) < most) {
    size_t best = 0;
    double best_gain = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
      const double gain = gain_of(candidates[i], had_in_view);
      if (gain > best_gain) {
        best = i;
        best_gain = gain;
      }
    }
    if (best_gain == 0) break;
    chosen.push_back(candidates[best]);
    const Candidate& taken = chosen.back();
    add_worths(taken, had_in_view);
    drop_near(taken, min_distance_m, candidates);
  }
}

}  // namespace sightline
