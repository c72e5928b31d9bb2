// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// Numbers points in the order in which they come; those that are equal have one number. Files tell
/// most points six times over, once for each triangle around them. (An open table of numbers into
/// the list: 12 bytes a point where a standard map takes 70.)
class PointTable {
 public:
  /// The number of a point, which is appended to `points` if it is new; that list is the same at
  /// every call.
  int index_of(const Eigen::Vector3d& point, std::vector<Eigen::Vector3d>& points);

 private:
  void grow(const std::vector<Eigen::Vector3d>& points);
  size_t slot_of(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& points) const;

  std::vector<int> slots_;  // number + 1 of a point, 0: free; a power of two of them
};

/// Numbers the points that lie within a tolerance of each other alike: each takes the number of the
/// first that is near enough, or a new one.
class Welder {
 public:
  explicit Welder(double tolerance_m);

  int index_of(const Eigen::Vector3d& point);

  std::vector<Eigen::Vector3d> vertices;  ///< what the numbers stand for

 private:
  using Cell = Eigen::Matrix<int64_t, 3, 1>;
  size_t slot_of(const Cell& cell) const;
  void grow();

  double tolerance_m_;
  // Of every vertex the one before it in its slot, or -1; a slot holds the last of its cells.
  std::vector<int> before_;
  std::vector<int> slots_;
};

}  // namespace sightline
