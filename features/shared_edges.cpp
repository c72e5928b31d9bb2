// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/shared_edges.h"

#include <algorithm>
#include <utility>

#include "features/image_line.h"
#include "scenes/target/same_edge.h"

namespace sightline {
namespace {

// A line of an observation.
struct Place {
  Observation* observation;
  size_t line;

  const EdgeLine& edge_line() const { return observation->edge_lines[line]; }
  bool is_found() const { return observation->status == ObservationStatus::kFound; }
};

// Whether two lines are of one edge, which two features look at from its two ends.
bool is_one_edge(const Target& target, const Place& a, const Place& b) {
  const auto edge_of = [&target](const Place& place) -> const Edge& {
    return target.features[place.observation->feature].edges[place.edge_line().edge];
  };
  return a.observation != b.observation && is_same_edge(edge_of(a), edge_of(b));
}

bool overlap(const ImageLine& a, const ImageLine& b) {
  const double apart_px = (seen_middle(a) - seen_middle(b)).norm();
  return apart_px < seen_stretch(a).half_length_px() + seen_stretch(b).half_length_px();
}

// Which of two lines of one edge are to be dropped.
std::vector<Place> dropped_of(const Place& a, const Place& b) {
  if (a.is_found() && b.is_found()) return {a, b};
  if (a.is_found()) return {a};
  if (b.is_found()) return {b};
  const ImageLine& in_a = a.edge_line().line;
  const ImageLine& in_b = b.edge_line().line;
  if (!overlap(in_a, in_b)) return {};
  return {in_a.covariance(1, 1) <= in_b.covariance(1, 1) ? b : a};
}

}  // namespace

void drop_shared_lines(const Target& target, std::vector<Observation>& observations) {
  std::vector<Place> places;
  for (Observation& observation : observations) {
    for (size_t i = 0; i < observation.edge_lines.size(); ++i) places.push_back({&observation, i});
  }
  std::vector<Place> dropped;
  for (size_t i = 0; i < places.size(); ++i) {
    for (size_t k = i + 1; k < places.size(); ++k) {
      if (!is_one_edge(target, places[i], places[k])) continue;
      for (const Place& place : dropped_of(places[i], places[k])) dropped.push_back(place);
    }
  }
  for (Observation& observation : observations) {
    std::vector<EdgeLine> kept;
    for (size_t i = 0; i < observation.edge_lines.size(); ++i) {
      const bool is_dropped = std::ranges::any_of(dropped, [&](const Place& place) {
        return place.observation == &observation && place.line == i;
      });
      if (!is_dropped) kept.push_back(std::move(observation.edge_lines[i]));
    }
    observation.edge_lines = std::move(kept);
  }
}

}  // namespace sightline
