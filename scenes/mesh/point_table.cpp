// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/point_table.h"

#include <algorithm>
#include <bit>

namespace sightline {
namespace {

constexpr size_t kFirstSlots = 64;

// One of 2^64 numbers for three others, well mixed in its upper and its lower bits.
uint64_t mixed(uint64_t x, uint64_t y, uint64_t z) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const uint64_t number : {x, y, z}) {
    hash = (hash ^ number) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

// Zero has two signs and is one number.
uint64_t bits_of(double number) {
  return std::bit_cast<uint64_t>(number == 0 ? 0.0 : number);
}

}  // namespace

int PointTable::index_of(const Eigen::Vector3d& point, std::vector<Eigen::Vector3d>& points) {
  if (2 * (points.size() + 1) > slots_.size()) grow(points);
  int& slot = slots_[slot_of(point, points)];
  if (slot == 0) {
    points.push_back(point);
    slot = static_cast<int>(points.size());
  }
  return slot - 1;
}

// The slot that holds the point's number, or the free one where it belongs.
size_t PointTable::slot_of(const Eigen::Vector3d& point,
                           const std::vector<Eigen::Vector3d>& points) const {
  const size_t mask = slots_.size() - 1;
  size_t at = mixed(bits_of(point.x()), bits_of(point.y()), bits_of(point.z())) & mask;
  while (slots_[at] != 0 && points[slots_[at] - 1] != point) at = (at + 1) & mask;
  return at;
}

void PointTable::grow(const std::vector<Eigen::Vector3d>& points) {
  slots_.assign(std::max(kFirstSlots, 2 * slots_.size()), 0);
  for (size_t i = 0; i < points.size(); ++i) {
    slots_[slot_of(points[i], points)] = static_cast<int>(i) + 1;
  }
}

namespace {

// Cells are this many tolerances wide: a point has most often one cell to look into, and a cell
// never has more vertices than a few hundred, however far the mesh's size exceeds its details.
constexpr double kCellTolerances = 8;

Eigen::Matrix<int64_t, 3, 1> cell_of(const Eigen::Vector3d& point, double cell_m) {
  return (point / cell_m).array().floor().cast<int64_t>();
}

}  // namespace

Welder::Welder(double tolerance_m) : tolerance_m_(tolerance_m), slots_(kFirstSlots, -1) {}

size_t Welder::slot_of(const Cell& cell) const {
  return mixed(static_cast<uint64_t>(cell.x()), static_cast<uint64_t>(cell.y()),
               static_cast<uint64_t>(cell.z())) &
         (slots_.size() - 1);
}

int Welder::index_of(const Eigen::Vector3d& point) {
  const double cell_m = kCellTolerances * tolerance_m_;
  const Cell low = cell_of(point.array() - tolerance_m_, cell_m);
  const Cell high = cell_of(point.array() + tolerance_m_, cell_m);
  int first = -1;  // the chains run from the last
  for (int64_t x = low.x(); x <= high.x(); ++x) {
    for (int64_t y = low.y(); y <= high.y(); ++y) {
      for (int64_t z = low.z(); z <= high.z(); ++z) {
        for (int at = slots_[slot_of({x, y, z})]; at >= 0; at = before_[at]) {
          const bool is_near = (vertices[at] - point).norm() <= tolerance_m_;
          if (is_near && (first < 0 || at < first)) first = at;
        }
      }
    }
  }
  if (first >= 0) return first;
  if (vertices.size() >= slots_.size()) grow();
  int& slot = slots_[slot_of(cell_of(point, cell_m))];
  before_.push_back(slot);
  vertices.push_back(point);
  slot = static_cast<int>(vertices.size()) - 1;
  return slot;
}

void Welder::grow() {
  slots_.assign(2 * slots_.size(), -1);
  for (size_t i = 0; i < vertices.size(); ++i) {
    int& slot = slots_[slot_of(cell_of(vertices[i], kCellTolerances * tolerance_m_))];
    before_[i] = slot;
    slot = static_cast<int>(i);
  }
}

}  // namespace sightline
