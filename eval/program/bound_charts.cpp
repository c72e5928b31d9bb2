// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/bound_charts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>

namespace sightline {
namespace {

// Where the conditions lie along a chart.
struct BoundPlaces {
  ChartAxis axis;
  std::vector<double> x;
  std::vector<size_t> order;  // of the conditions, by x
};

// The middle of "[1000.0,2000.0]"; none of other words.
std::optional<double> middle_of(const std::string& range) {
  std::istringstream in(range);
  char open = 0, comma = 0, close = 0;
  double low = 0, high = 0;
  if (!(in >> open >> low >> comma >> high >> close) || in.peek() != EOF) return std::nullopt;
  if (open != '[' || comma != ',' || close != ']' || low > high) return std::nullopt;
  return (low + high) / 2;
}

// The number at which a condition lies on the axis of a key. The number of a given pose, which is
// no key of a table, is but its name.
std::optional<double> place_of(const Condition& condition, const std::string& key) {
  if (key.find('.') == std::string::npos) return std::nullopt;
  if (condition.values.size() + condition.words.size() != 1) return std::nullopt;
  const auto value = condition.values.find(key);
  if (value != condition.values.end()) return value->second;
  const auto word = condition.words.find(key);
  return word != condition.words.end() ? middle_of(word->second) : std::nullopt;
}

std::string first_key(const Condition& condition) {
  if (!condition.values.empty()) return condition.values.begin()->first;
  return condition.words.empty() ? "" : condition.words.begin()->first;
}

BoundPlaces places_of(std::span<const Condition> conditions) {
  BoundPlaces places;
  places.order.resize(conditions.size());
  std::iota(places.order.begin(), places.order.end(), size_t{0});
  const std::string key = first_key(conditions.front());
  for (const Condition& condition : conditions) {
    const auto x = place_of(condition, key);
    if (!x) break;
    places.x.push_back(*x);
  }
  if (places.x.size() == conditions.size()) {
    places.axis.label = key;
    choose_sweep_scale(places.axis, places.x);
    std::stable_sort(places.order.begin(), places.order.end(),
                     [&](size_t a, size_t b) { return places.x[a] < places.x[b]; });
    return places;
  }
  places.x.clear();
  for (const Condition& condition : conditions) {
    places.x.push_back(static_cast<double>(places.axis.names.size()));
    places.axis.names.push_back(condition.label);
  }
  return places;
}

Chart bound_chart(const BoundPlaces& places, std::span<const ImageBoundRow> rows,
                  std::vector<double> ImageBoundRow::*values) {
  Chart chart;
  chart.kind = places.axis.names.empty() ? ChartKind::kLines : ChartKind::kPoints;
  chart.x = places.axis;
  for (size_t kind = 0; kind < std::size(kImageBoundKinds); ++kind) {
    ChartSeries series;
    series.label = kImageBoundKinds[kind];
    series.style = static_cast<int>(kind);
    for (const size_t row : places.order) {
      series.x.push_back(places.x[row]);
      series.y.push_back((rows[row].*values)[kind]);
      series.count.push_back(rows[row].scenes);
    }
    chart.series.push_back(std::move(series));
  }
  choose_y_scale(chart);
  return chart;
}

}  // namespace

std::vector<Chart> bound_charts(std::span<const Condition> conditions,
                                std::span<const ImageBoundRow> rows) {
  if (conditions.empty()) return {};
  const BoundPlaces places = places_of(conditions);
  Chart theta = bound_chart(places, rows, &ImageBoundRow::theta_deg);
  theta.id = "bound-theta";
  theta.title = "What an image tells of the attitude at most";
  theta.y.label = "bound of theta_error / deg";
  Chart t = bound_chart(places, rows, &ImageBoundRow::t_percent);
  t.id = "bound-t";
  t.title = "What an image tells of the position at most";
  t.y.label = "bound of T_error / %";
  return {std::move(theta), std::move(t)};
}

}  // namespace sightline
