// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/same_edge.h"

namespace sightline {

bool is_same_edge(const Edge& a, const Edge& b) {
  constexpr double kRounding = 1e-4;
  const double same_m = kRounding * (a.end_m - a.begin_m).norm();
  const auto are_ends = [&](const Eigen::Vector3d& begin_m, const Eigen::Vector3d& end_m) {
    return (a.begin_m - begin_m).norm() <= same_m && (a.end_m - end_m).norm() <= same_m;
  };
  return are_ends(b.begin_m, b.end_m) || are_ends(b.end_m, b.begin_m);
}

}  // namespace sightline
