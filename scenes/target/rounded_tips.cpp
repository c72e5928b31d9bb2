// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/rounded_tips.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "scenes/target/proposal.h"

namespace sightline {
namespace {

using Eigen::Vector3d;

// Lengths are fractions of the target's size.
constexpr int kHullDirections = 400;
constexpr double kLeastShare = 0.02;  // of the directions: a ball's are some 0.1 % within that
constexpr double kLeastPart = 0.15;   // smaller parts are details
constexpr double kLeastHold = 0.006;  // the lesser eigenvalue: half the least edge of a corner
constexpr double kFullHold = 0.02;    // more is worth no more
constexpr double kSurfaceClearance = 0.003;
constexpr double kBesideOutline = 0.004;  // how far beside it its background is
constexpr double kEyeDistance = 100;      // as good as parallel rays
constexpr double kInnerWorth = 0.3;       // of an outline before other surfaces
constexpr int kOutlineSamples = 12;

// A place that sticks out.
struct Tip {
  Vector3d position_m = Vector3d::Zero();
  double spread_m = 0;  // to the farthest of its extreme points
  int part = 0;
};

// How many of the directions have each vertex for their extreme point.
std::map<int, int> extreme_counts(const Mesh& mesh, const std::vector<int>& vertices,
                                  const std::vector<Vector3d>& directions) {
  std::map<int, int> counts;
  for (const Vector3d& direction : directions) {
    int extreme = vertices.front();
    double farthest = mesh.vertices[extreme].dot(direction);
    for (const int v : vertices) {
      const double far = mesh.vertices[v].dot(direction);
      if (far <= farthest) continue;
      extreme = v;
      farthest = far;
    }
    ++counts[extreme];
  }
  return counts;
}

// Of how many directions an extreme point lies within the radius of a place.
int directions_near(const Mesh& mesh, const std::map<int, int>& counts, const Vector3d& place,
                    double radius_m) {
  int sum = 0;
  for (const auto& [vertex, count] : counts) {
    if ((mesh.vertices[vertex] - place).norm() <= radius_m) sum += count;
  }
  return sum;
}

// Gathers the extreme points into tips, the one with most directions first.
void add_tips(const Mesh& mesh, std::map<int, int> counts, int part, double size_m,
              std::vector<Tip>& tips) {
  const double radius_m = kTipRadius * size_m;
  while (!counts.empty()) {
    const auto& [heart, unused] = *std::ranges::max_element(counts, {}, [&](const auto& c) {
      return directions_near(mesh, counts, mesh.vertices[c.first], radius_m);
    });
    const Vector3d heart_m = mesh.vertices[heart];
    const int near = directions_near(mesh, counts, heart_m, radius_m);
    if (near < kLeastShare * kHullDirections) return;
    const auto is_near = [&](const auto& c) {
      return (mesh.vertices[c.first] - heart_m).norm() <= radius_m;
    };
    Tip tip{.part = part};
    for (const auto& c : counts) {
      if (is_near(c)) tip.position_m += c.second * mesh.vertices[c.first] / near;
    }
    for (const auto& c : counts) {
      if (!is_near(c)) continue;
      tip.spread_m = std::max(tip.spread_m, (mesh.vertices[c.first] - tip.position_m).norm());
    }
    std::erase_if(counts, is_near);
    tips.push_back(tip);
  }
}

std::vector<Tip> tips_of(const Mesh& mesh, double size_m) {
  std::vector<std::set<int>> vertices_of(mesh.parts.size());
  std::vector<int> part_of(mesh.vertices.size(), 0);
  std::set<int> all;
  for (const Triangle& triangle : mesh.triangles) {
    if (is_moving_part(mesh.parts[triangle.part].name)) continue;
    vertices_of[triangle.part].insert(triangle.vertex.begin(), triangle.vertex.end());
    all.insert(triangle.vertex.begin(), triangle.vertex.end());
    for (const int v : triangle.vertex) part_of[v] = triangle.part;
  }
  const std::vector<Vector3d> directions = directions_all_round(kHullDirections);
  std::vector<Tip> tips;
  const auto add = [&](const std::set<int>& vertices, int part) {
    if (vertices.empty()) return;
    Eigen::AlignedBox3d box;
    for (const int v : vertices) box.extend(mesh.vertices[v]);
    if (box.diagonal().norm() < kLeastPart * size_m) return;
    const std::vector<int> list(vertices.begin(), vertices.end());
    add_tips(mesh, extreme_counts(mesh, list, directions), part, size_m, tips);
  };
  add(all, -1);
  for (Tip& tip : tips) {  // those of the whole belong to the part that is nearest
    const int nearest = *std::ranges::min_element(
        all, {}, [&](int v) { return (mesh.vertices[v] - tip.position_m).squaredNorm(); });
    tip.part = part_of[nearest];
  }
  if (mesh.parts.size() == 1) return tips;
  for (size_t part = 0; part < mesh.parts.size(); ++part) {
    add(vertices_of[part], static_cast<int>(part));
  }
  return tips;
}

// Cuts off what of the edges lies beyond reach: an edge may be as long as a wing.
void cut_to_reach(const TargetFeature& feature, std::vector<MeshEdge>& edges) {
  for (MeshEdge& edge : edges) {
    const Vector3d whole = edge.end_m - edge.begin_m;
    const Vector3d arm = feature.position_m - edge.begin_m;
    const double nearest = arm.dot(whole) / whole.squaredNorm();
    const double off_m = (arm - nearest * whole).norm();
    const double chord_m =
        std::sqrt(std::max(0.0, feature.reach_m * feature.reach_m - off_m * off_m));
    const double half = chord_m / whole.norm();
    const Vector3d begin_m = edge.begin_m;
    edge.begin_m = begin_m + std::clamp(nearest - half, 0.0, 1.0) * whole;
    edge.end_m = begin_m + std::clamp(nearest + half, 0.0, 1.0) * whole;
  }
}

// A piece of the outline as seen from one side.
struct OutlinePiece {
  Vector3d middle_m;
  Vector3d along;  // in the image plane, unit
  double length_m;
};

std::vector<OutlinePiece> outline_pieces(const FeatureShape& shape, const Vector3d& to_eye) {
  std::vector<OutlinePiece> pieces;
  for (const MeshEdge& edge : shape.edges) {
    const bool turns =
        (edge.face_normal[0].dot(to_eye) > 0) != (edge.face_normal[1].dot(to_eye) > 0);
    if (!turns && !edge.is_open) continue;
    const Vector3d whole = edge.end_m - edge.begin_m;
    const Vector3d projected = whole - to_eye * to_eye.dot(whole);
    const double length_m = projected.norm();
    if (!(length_m > 0)) continue;
    pieces.push_back({(edge.begin_m + edge.end_m) / 2, projected / length_m, length_m});
  }
  return pieces;
}

// How the outline holds a shift, and how much of it is seen.
struct OutlineHold {
  double hold_m = 0;
  double seen = 0;     // of its length
  double outline = 0;  // of what is seen: before the background
};

// Looks at as many pieces as there are samples, evenly by their lengths: each stands for its share.
OutlineHold hold_of(const std::vector<OutlinePiece>& pieces, const Occluder& occluder,
                    const Vector3d& to_eye, double size_m) {
  double total_m = 0;
  for (const OutlinePiece& piece : pieces) total_m += piece.length_m;
  const double step_m = total_m / kOutlineSamples;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double passed_m = 0, next_m = step_m / 2;
  int seen = 0, outline = 0;
  for (const OutlinePiece& piece : pieces) {
    passed_m += piece.length_m;
    for (; next_m < passed_m; next_m += step_m) {
      const Vector3d eye = piece.middle_m + kEyeDistance * size_m * to_eye;
      if (occluder.hides_own(piece.middle_m, eye, kSurfaceClearance * size_m)) continue;
      ++seen;
      const Vector3d normal = piece.along.cross(to_eye);
      information += step_m * normal * normal.transpose();
      const Vector3d aside = kBesideOutline * size_m * normal;
      const Vector3d behind = piece.middle_m - 2 * size_m * to_eye;
      const bool is_free = !occluder.hides(behind + aside, eye + aside, 0) ||
                           !occluder.hides(behind - aside, eye - aside, 0);
      outline += is_free ? 1 : 0;
    }
  }
  if (seen == 0) return {};
  // Of the three eigenvalues one is zero, along the line of sight.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(information, Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()[1], static_cast<double>(seen) / kOutlineSamples,
          static_cast<double>(outline) / seen};
}

void look_from_all_sides(Candidate& candidate, const FeatureShape& shape,
                         const std::vector<Vector3d>& directions, const Occluder& occluder,
                         double size_m) {
  constexpr double kLeastSeen = 0.5;
  const TargetFeature& feature = candidate.feature;
  candidate.worth_in_view.assign(directions.size(), 0);
  int visible = 0;
  double outline = 0;
  for (size_t v = 0; v < directions.size(); ++v) {
    const Vector3d& to_eye = directions[v];
    const Vector3d eye = feature.position_m + kEyeDistance * size_m * to_eye;
    if (occluder.hides_own(feature.position_m, eye, feature.clearance_m)) continue;
    const std::vector<OutlinePiece> pieces = outline_pieces(shape, to_eye);
    const OutlineHold hold = hold_of(pieces, occluder, to_eye, size_m);
    if (hold.seen < kLeastSeen || hold.hold_m < kLeastHold * size_m) continue;
    ++visible;
    outline += hold.outline;
    candidate.worth_in_view[v] = std::min(1.0, hold.hold_m / (kFullHold * size_m)) *
                                 (kInnerWorth + (1 - kInnerWorth) * hold.outline);
  }
  if (visible == 0) return;
  candidate.visible_fraction =
      static_cast<double>(visible) / static_cast<double>(directions.size());
  candidate.outline_fraction = outline / visible;
}

}  // namespace

std::set<std::string> parts_about(const Mesh& mesh, const Vector3d& position_m, double reach_m) {
  std::set<std::string> names;
  for (const Triangle& triangle : mesh.triangles) {
    const std::string& name = mesh.parts[triangle.part].name;
    const bool is_near = std::ranges::any_of(
        triangle.vertex, [&](int v) { return (mesh.vertices[v] - position_m).norm() <= reach_m; });
    if (is_near) names.insert(name);
  }
  return names;
}

std::vector<Candidate> rounded_tips(const Mesh& mesh, const Occluder& occluder,
                                    const std::vector<Vector3d>& directions) {
  const Bounds box = bounds(mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  std::vector<Candidate> candidates;
  std::vector<TargetFeature> features;
  for (const Tip& tip : tips_of(mesh, size_m)) {
    Candidate candidate{.part = tip.part, .feature = {}, .worth_in_view = {}};
    candidate.feature.kind = FeatureKind::kContour;
    candidate.feature.position_m = tip.position_m;
    candidate.feature.clearance_m =
        occluder.distance_m(tip.position_m) + tip.spread_m / 2 + kSurfaceClearance * size_m;
    candidate.feature.reach_m = kTipReach * size_m;
    std::set<std::string> parts = parts_about(mesh, tip.position_m, kTipRadius * size_m);
    std::erase_if(parts, is_moving_part);
    parts.insert(mesh.parts[tip.part].name);
    candidate.feature.parts.assign(parts.begin(), parts.end());
    features.push_back(candidate.feature);
    candidates.push_back(std::move(candidate));
  }
  std::vector<FeatureShape> shapes = feature_shapes(mesh, features);
  for (size_t i = 0; i < candidates.size(); ++i) {
    cut_to_reach(features[i], shapes[i].edges);
    look_from_all_sides(candidates[i], shapes[i], directions, occluder, size_m);
  }
  return candidates;
}

}  // namespace sightline
