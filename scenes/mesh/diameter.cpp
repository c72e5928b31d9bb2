// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/diameter.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

namespace sightline {
namespace {

constexpr size_t kLeafPoints = 16;

// A box about some of the points, halved until few are left.
struct Node {
  Eigen::AlignedBox3d box;
  std::span<Eigen::Vector3d> points;
  int children[2] = {-1, -1};
};

int build(std::span<Eigen::Vector3d> points, std::vector<Node>& nodes) {
  const int index = static_cast<int>(nodes.size());
  Node& node = nodes.emplace_back();
  node.points = points;
  for (const Eigen::Vector3d& point : points) node.box.extend(point);
  if (points.size() <= kLeafPoints) return index;
  Eigen::Index axis = 0;
  node.box.sizes().maxCoeff(&axis);
  const size_t middle = points.size() / 2;
  std::nth_element(
      points.begin(), points.begin() + static_cast<std::ptrdiff_t>(middle), points.end(),
      [axis](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[axis] < b[axis]; });
  const int first = build(points.first(middle), nodes);
  const int second = build(points.subspan(middle), nodes);
  nodes[index].children[0] = first;
  nodes[index].children[1] = second;
  return index;
}

// No two points of the boxes are farther apart than this, squared.
double bound(const Node& a, const Node& b) {
  const Eigen::Array3d reach =
      (a.box.max() - b.box.min()).array().max((b.box.max() - a.box.min()).array());
  return reach.square().sum();
}

// Raises `best`, the greatest squared distance found, by the pairs of two nodes.
void search(const std::vector<Node>& nodes, const Node& a, const Node& b, double& best) {
  if (bound(a, b) <= best) return;
  if (a.children[0] < 0 && b.children[0] < 0) {
    for (const Eigen::Vector3d& p : a.points) {
      for (const Eigen::Vector3d& q : b.points) best = std::max(best, (p - q).squaredNorm());
    }
    return;
  }
  const bool splits_a =
      b.children[0] < 0 || (a.children[0] >= 0 && a.points.size() >= b.points.size());
  const Node& whole = splits_a ? b : a;
  const Node* first = &nodes[(splits_a ? a : b).children[0]];
  const Node* second = &nodes[(splits_a ? a : b).children[1]];
  if (bound(*first, whole) < bound(*second, whole)) std::swap(first, second);
  search(nodes, *first, whole, best);
  search(nodes, *second, whole, best);
}

}  // namespace

double diameter(std::vector<Eigen::Vector3d> points) {
  if (points.size() < 2) return 0;
  std::vector<Node> nodes;
  build(points, nodes);
  // The point farthest from another gives a bound that is nearly tight.
  double best = 0;
  for (const Eigen::Vector3d& point : points) {
    best = std::max(best, (point - points.front()).squaredNorm());
  }
  search(nodes, nodes.front(), nodes.front(), best);
  return std::sqrt(best);
}

}  // namespace sightline
