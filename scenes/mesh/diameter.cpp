// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/diameter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace sightline {
namespace {

using Eigen::Vector3d;

constexpr size_t kLeafPoints = 16;
constexpr double kRounding = 1e-13;  // relative: more than the arithmetic of a bound can lose

// A box along the principal axes of some of the points, halved until few are left. A piece of a
// curved surface fills a box about as thick as the square of its width, however it is tilted.
struct Node {
  Vector3d centre;
  Eigen::Matrix3d half_axes;  // columns, from the centre to the sides
  double radius = 0;          // half the box's diagonal
  Eigen::AlignedBox3d aligned;
  std::span<Vector3d> points;
  std::array<int, 2> children = {-1, -1};
  bool is_leaf() const { return children[0] < 0; }
};

Eigen::Matrix3d principal_axes(std::span<const Vector3d> points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& point : points) sum += point - points.front();
  const Vector3d mean = points.front() + sum / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Vector3d& point : points) scatter += (point - mean) * (point - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
}

Node box_about(std::span<Vector3d> points) {
  const Eigen::Matrix3d axes = principal_axes(points);
  Eigen::AlignedBox3d box;
  for (const Vector3d& point : points) box.extend(axes.transpose() * (point - points.front()));
  Node node;
  node.centre = points.front() + axes * box.center();
  Vector3d half = Vector3d::Zero();  // measured about the centre as it is rounded
  for (const Vector3d& point : points) {
    half = half.cwiseMax((axes.transpose() * (point - node.centre)).cwiseAbs());
  }
  node.half_axes = axes * half.asDiagonal();
  node.radius = half.norm();
  for (const Vector3d& point : points) node.aligned.extend(point);
  node.points = node.radius > 0 ? points : points.first(1);  // any number in one place is one
  return node;
}

int build(std::span<Vector3d> points, std::vector<Node>& nodes) {
  const int index = static_cast<int>(nodes.size());
  const Node node = nodes.emplace_back(box_about(points));
  if (node.points.size() <= kLeafPoints) return index;
  Eigen::Index longest = 0;
  node.half_axes.colwise().squaredNorm().maxCoeff(&longest);
  const Vector3d along = node.half_axes.col(longest);
  const size_t middle = points.size() / 2;
  std::nth_element(
      points.begin(), points.begin() + static_cast<std::ptrdiff_t>(middle), points.end(),
      [&](const Vector3d& a, const Vector3d& b) { return along.dot(a) < along.dot(b); });
  const int first = build(points.first(middle), nodes);
  const int second = build(points.subspan(middle), nodes);
  nodes[index].children = {first, second};
  return index;
}

// Two nodes, and what no point of the one is farther than from any of the other, squared.
struct NodePair {
  const Node* a = nullptr;
  const Node* b = nullptr;
  double bound = 0;
};

// With x and y from the centres to the points and d from one centre to the other, their distance
// squared is d^2 + 2 d (y - x) + (y - x)^2: each term is taken at its greatest. Two points that are
// farthest apart see each other along the normals of their surfaces, where the boxes are thin, so
// that the bound is too great by no more than the order of the boxes' widths squared. This is why
// few pairs of boxes are left even of a ball, all of whose diameters are nearly the longest.
//
// Of two small and distant boxes the terms are lost in the rounding. Those along x, y and z have a
// bound that needs no slack: no operation that rounds makes less of more.
NodePair pair_of(const Node& a, const Node& b) {
  const Vector3d between = b.centre - a.centre;
  const double reach = (a.half_axes.transpose() * between).lpNorm<1>() +
                       (b.half_axes.transpose() * between).lpNorm<1>();
  const double across = a.radius + b.radius;
  const double squared = between.squaredNorm() + 2 * reach + across * across;
  const Vector3d farthest =
      (b.aligned.max() - a.aligned.min()).cwiseMax(a.aligned.max() - b.aligned.min());
  return {&a, &b, std::min(squared * (1 + kRounding), farthest.squaredNorm())};
}

// The greatest squared distance found, and how many more may be compared with it to be exact.
struct Search {
  double best = 0;
  uint64_t pairs_left = 0;

  bool may_gain(const NodePair& pair) const {
    return pair.bound > (pairs_left > 0 ? best : best * (1 + 2 * kRounding));
  }
};

void compare_points(const Node& a, const Node& b, Search& found) {
  for (const Vector3d& p : a.points) {
    for (const Vector3d& q : b.points) found.best = std::max(found.best, (p - q).squaredNorm());
  }
  found.pairs_left -= std::min<uint64_t>(found.pairs_left, a.points.size() * b.points.size());
}

void search(const std::vector<Node>& nodes, const NodePair& pair, Search& found) {
  if (!found.may_gain(pair)) return;
  const Node& a = *pair.a;
  const Node& b = *pair.b;
  if (a.is_leaf() && b.is_leaf()) return compare_points(a, b, found);
  const bool is_one = &a == &b;
  const bool splits_a = b.is_leaf() || (!a.is_leaf() && a.radius >= b.radius);
  const Node& first = nodes[(splits_a ? a : b).children[0]];
  const Node& second = nodes[(splits_a ? a : b).children[1]];
  if (is_one) search(nodes, pair_of(first, second), found);
  const Node& other = splits_a ? b : a;
  NodePair nearer = pair_of(first, is_one ? first : other);
  NodePair farther = pair_of(second, is_one ? second : other);
  if (nearer.bound > farther.bound) std::swap(nearer, farther);
  search(nodes, farther, found);
  search(nodes, nearer, found);
}

const Vector3d& farthest_from(const Vector3d& from, const std::vector<Vector3d>& points) {
  size_t farthest = 0;
  double best = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const double squared = (points[i] - from).squaredNorm();
    if (squared <= best) continue;
    best = squared;
    farthest = i;
  }
  return points[farthest];
}

// Two points far from each other.
struct LongPair {
  Vector3d a, b;
  double squared() const { return (a - b).squaredNorm(); }
  Vector3d middle() const { return a + (b - a) / 2; }
};

// From a point to the farthest from it, and from there on while that is farther. A few times: points
// can be laid such that it goes on through all of them.
LongPair climb(const Vector3d& start, const std::vector<Vector3d>& points) {
  constexpr int kMostSteps = 8;
  LongPair pair{start, farthest_from(start, points)};
  for (int step = 0; step < kMostSteps; ++step) {
    const LongPair next{pair.b, farthest_from(pair.b, points)};
    if (next.squared() <= pair.squared()) break;
    pair = next;
  }
  return pair;
}

}  // namespace

double diameter(std::vector<Vector3d> points, uint64_t most_pairs) {
  if (points.size() < 2) return 0;
  LongPair pair = climb(points.front(), points);
  const LongPair other = climb(farthest_from(pair.middle(), points), points);
  if (other.squared() > pair.squared()) pair = other;
  Search found{.best = pair.squared(), .pairs_left = most_pairs};
  // Two points are no farther apart than the sum of their distances from any third: one that is
  // too near to that is of no longer pair.
  const Vector3d centre = pair.middle();
  const double farthest = (farthest_from(centre, points) - centre).norm();
  const double least = std::sqrt(found.best) * (1 - kRounding) - farthest;
  std::erase_if(points, [&](const Vector3d& point) { return (point - centre).norm() <= least; });
  if (points.empty()) return std::sqrt(found.best);
  std::vector<Node> nodes;
  build(points, nodes);
  search(nodes, pair_of(nodes.front(), nodes.front()), found);
  return std::sqrt(found.best);
}

}  // namespace sightline
