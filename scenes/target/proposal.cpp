// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/proposal.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "pose/angles.h"
#include "scenes/target/candidate.h"
#include "scenes/target/rounded_tips.h"

namespace sightline {
namespace {

using Eigen::Vector3d;

constexpr double kMaxBendDeg = 15;       // between neighbouring edges of one chain
constexpr double kMaxBowDeg = 6;         // between the halves of a straight edge
constexpr size_t kMaxEdges = 4000;       // the longest; pairs are formed of them
constexpr size_t kMaxCandidates = 400;   // each takes thousands of rays
constexpr double kViewDistance = 100;    // of the size: as good as parallel rays
constexpr double kWindow = 0.06;         // of the size: what a window around a feature shows
constexpr double kFullLength = 0.05;     // projected, of the size: a longer edge is worth no more
constexpr double kFullAngleDeg = 40;     // between projected edges: wider is worth no more
constexpr double kLeastAngleDeg = 12;    // narrower is worth nothing
constexpr double kInnerEdgeWorth = 0.3;  // of an edge before other surfaces, against outline's 1
constexpr double kOutlineShift = 0.004;  // of the size: how far beside an edge its background is
constexpr double kLeastRest = 0.5;       // of the least length: an edge's, beyond where lines cross
constexpr double kTipDistance = 0.06;    // of the size: of a tip from any other feature
constexpr int kSamplesPerEdge = 3;
constexpr int kLeastSamplesInSight = 2;

struct Crease {
  int part = 0;
  std::array<int, 2> vertex{};
};

// The turn of the surface about an edge from one face to another, whatever their windings: 0 where
// they are one plane, pi where they lie on each other.
double turn_rad(const Mesh& mesh, const std::pair<int, int>& edge, int triangle_a, int triangle_b) {
  const Vector3d& begin = mesh.vertices[edge.first];
  const Vector3d along = (mesh.vertices[edge.second] - begin).normalized();
  const auto inwards = [&](int triangle) {
    for (const int v : mesh.triangles[triangle].vertex) {
      if (v == edge.first || v == edge.second) continue;
      const Vector3d arm = mesh.vertices[v] - begin;
      return Vector3d((arm - along * along.dot(arm)).normalized());
    }
    return Vector3d(Vector3d::Zero());
  };
  return std::acos(std::clamp(-inwards(triangle_a).dot(inwards(triangle_b)), -1.0, 1.0));
}

// Edges of one face are creases; of those of three faces and more, all that are not flat
// throughout.
std::vector<Crease> creases_of(const Mesh& mesh, double sharp_rad) {
  std::map<std::pair<int, int>, std::vector<int>> triangles_at;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t].vertex;
    for (int i = 0; i < 3; ++i) {
      triangles_at[std::minmax(v[i], v[(i + 1) % 3])].push_back(static_cast<int>(t));
    }
  }
  std::vector<Crease> creases;
  for (const auto& [edge, triangles] : triangles_at) {
    bool is_sharp = triangles.size() == 1;
    for (size_t i = 1; i < triangles.size(); ++i) {
      is_sharp = is_sharp || turn_rad(mesh, edge, triangles[0], triangles[i]) >= sharp_rad;
    }
    if (is_sharp) {
      creases.push_back({mesh.triangles[triangles[0]].part, {edge.first, edge.second}});
    }
  }
  return creases;
}

// For each end of each crease the crease that goes on from there, or -1: at every vertex the pairs
// that bend least find each other first.
std::vector<std::array<int, 2>> continuations(const Mesh& mesh,
                                              const std::vector<Crease>& creases) {
  struct End {
    int crease, end;
    Vector3d away;
  };
  std::map<int, std::vector<End>> ends_at;
  for (size_t i = 0; i < creases.size(); ++i) {
    for (int end = 0; end < 2; ++end) {
      const auto& v = creases[i].vertex;
      const Vector3d away = (mesh.vertices[v[1 - end]] - mesh.vertices[v[end]]).normalized();
      ends_at[v[end]].push_back({static_cast<int>(i), end, away});
    }
  }
  std::vector<std::array<int, 2>> next(creases.size(), {-1, -1});
  const double least_cos = std::cos(kMaxBendDeg * kDegree);
  for (const auto& [vertex, ends] : ends_at) {
    std::vector<std::pair<double, std::pair<size_t, size_t>>> pairs;
    for (size_t a = 0; a < ends.size(); ++a) {
      for (size_t b = a + 1; b < ends.size(); ++b) {
        const double cos_bend = -ends[a].away.dot(ends[b].away);
        if (cos_bend >= least_cos) pairs.push_back({-cos_bend, {a, b}});
      }
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [unused, pair] : pairs) {
      const End& a = ends[pair.first];
      const End& b = ends[pair.second];
      if (next[a.crease][a.end] >= 0 || next[b.crease][b.end] >= 0) continue;
      next[a.crease][a.end] = b.crease;
      next[b.crease][b.end] = a.crease;
    }
  }
  return next;
}

struct Chain {
  int part = 0;
  std::vector<int> vertices;
  bool is_ring = false;  // goes on at its end as it begins
};

std::vector<Chain> chains_of(const Mesh& mesh, const std::vector<Crease>& creases) {
  const auto next = continuations(mesh, creases);
  std::vector<bool> is_used(creases.size(), false);
  std::vector<Chain> chains;
  const auto follow = [&](int crease, int begin, bool is_ring) {
    Chain chain{creases[crease].part, {creases[crease].vertex[begin]}, is_ring};
    while (crease >= 0 && !is_used[crease]) {
      is_used[crease] = true;
      const auto& v = creases[crease].vertex;
      const int end = chain.vertices.back() == v[0] ? 1 : 0;
      chain.vertices.push_back(v[end]);
      crease = next[crease][end];
    }
    chains.push_back(std::move(chain));
  };
  for (int pass = 0; pass < 2; ++pass) {  // from open ends, then the rings that are left
    for (size_t i = 0; i < creases.size(); ++i) {
      for (int end = 0; end < 2; ++end) {
        const bool is_start = pass == 1 || next[i][end] < 0;
        if (is_start && !is_used[i]) follow(static_cast<int>(i), end, pass == 1);
      }
    }
  }
  return chains;
}

// A straight edge: the line fitted to a piece of a chain, cut where the piece ends.
struct StraightEdge {
  int part = 0;
  std::array<Vector3d, 2> end;
  std::array<bool, 2> has_end = {true, true};  // not where it is a piece of an arc that goes on
  Vector3d direction() const { return (end[1] - end[0]).normalized(); }
  double length_m() const { return (end[1] - end[0]).norm(); }
};

StraightEdge fit(const Mesh& mesh, const Chain& chain, size_t first, size_t last) {
  Vector3d sum = Vector3d::Zero();
  double length = 0;
  for (size_t i = first; i < last; ++i) {
    const Vector3d& a = mesh.vertices[chain.vertices[i]];
    const Vector3d& b = mesh.vertices[chain.vertices[i + 1]];
    sum += (b - a).norm() * (a + b) / 2;
    length += (b - a).norm();
  }
  const Vector3d centre = sum / length;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();  // of the polyline, by Simpson's rule
  for (size_t i = first; i < last; ++i) {
    const Vector3d a = mesh.vertices[chain.vertices[i]] - centre;
    const Vector3d b = mesh.vertices[chain.vertices[i + 1]] - centre;
    const Vector3d middle = (a + b) / 2;
    scatter += (b - a).norm() / 6 *
               (a * a.transpose() + 4 * middle * middle.transpose() + b * b.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Vector3d along = solver.eigenvectors().col(2);
  const auto foot = [&](size_t i) {
    return Vector3d(centre + along * along.dot(mesh.vertices[chain.vertices[i]] - centre));
  };
  return {.part = chain.part, .end = {foot(first), foot(last)}};
}

// The turn from one half of a piece to the other, each from end to end: of an arc, half of its own.
double bow_rad(const Mesh& mesh, const Chain& chain, size_t first, size_t last) {
  const auto at = [&](size_t i) -> const Vector3d& { return mesh.vertices[chain.vertices[i]]; };
  double rest_m = 0;  // to the middle
  for (size_t i = first; i < last; ++i) rest_m += (at(i + 1) - at(i)).norm() / 2;
  size_t i = first;
  for (; i + 1 < last && (at(i + 1) - at(i)).norm() < rest_m; ++i) {
    rest_m -= (at(i + 1) - at(i)).norm();
  }
  const Vector3d middle = at(i) + rest_m * (at(i + 1) - at(i)).normalized();
  const Vector3d to = middle - at(first), onward = at(last) - middle;
  return std::atan2(to.cross(onward).norm(), to.dot(onward));
}

// Where a piece ends. Those of an arc are close to their chords too, but where these meet is no
// corner: an arc has ends only where its chain has.
std::array<bool, 2> ends_of(const Mesh& mesh, const Chain& chain, size_t first, size_t last) {
  if (bow_rad(mesh, chain, first, last) <= kMaxBowDeg * kDegree) return {true, true};
  if (chain.is_ring) return {false, false};
  return {first == 0, last + 1 == chain.vertices.size()};
}

// Douglas and Peucker: halves the piece at its farthest vertex until all are close to the chord.
void cut(const Mesh& mesh, const Chain& chain, size_t first, size_t last, double tolerance_m,
         std::vector<StraightEdge>& edges) {
  std::vector<std::pair<size_t, size_t>> pieces = {{first, last}};
  while (!pieces.empty()) {
    const auto [begin, end] = pieces.back();
    pieces.pop_back();
    const Vector3d& a = mesh.vertices[chain.vertices[begin]];
    const Vector3d chord = mesh.vertices[chain.vertices[end]] - a;
    const double squared = chord.squaredNorm();
    size_t farthest = begin;
    double distance_m = tolerance_m;
    for (size_t i = begin + 1; i < end; ++i) {
      const Vector3d arm = mesh.vertices[chain.vertices[i]] - a;
      const double along = squared > 0 ? std::clamp(arm.dot(chord) / squared, 0.0, 1.0) : 0;
      const double off_m = (arm - along * chord).norm();
      if (off_m > distance_m) {
        farthest = i;
        distance_m = off_m;
      }
    }
    if (farthest == begin) {
      if (squared == 0) continue;
      edges.push_back(fit(mesh, chain, begin, end));
      edges.back().has_end = ends_of(mesh, chain, begin, end);
    } else {
      pieces.push_back({farthest, end});
      pieces.push_back({begin, farthest});
    }
  }
}

std::vector<StraightEdge> straight_edges(const Mesh& mesh, double size_m,
                                         const ProposalOptions& options) {
  std::vector<StraightEdge> edges;
  for (const Chain& chain : chains_of(mesh, creases_of(mesh, options.sharp_angle_deg * kDegree))) {
    cut(mesh, chain, 0, chain.vertices.size() - 1, options.straightness * size_m, edges);
  }
  std::erase_if(edges, [&](const StraightEdge& edge) {
    return edge.length_m() < options.min_length * size_m ||
           is_moving_part(mesh.parts[edge.part].name);
  });
  std::stable_sort(edges.begin(), edges.end(), [](const StraightEdge& a, const StraightEdge& b) {
    return a.length_m() > b.length_m();
  });
  if (edges.size() > kMaxEdges) edges.resize(kMaxEdges);
  return edges;
}

// The candidate of two edges with the given ends together, if their lines meet there.
void add_candidate(const StraightEdge& a, int end_a, const StraightEdge& b, int end_b,
                   const Occluder& occluder, double size_m, const ProposalOptions& options,
                   std::vector<Candidate>& candidates) {
  if (!a.has_end[end_a] || !b.has_end[end_b]) return;
  if ((a.end[end_a] - b.end[end_b]).norm() > 2 * options.max_gap * size_m) return;
  const Vector3d along_a = end_a == 0 ? a.direction() : Vector3d(-a.direction());
  const Vector3d along_b = end_b == 0 ? b.direction() : Vector3d(-b.direction());
  const double sine = along_a.cross(along_b).norm();
  if (sine < std::sin(options.min_angle_deg * kDegree)) return;
  // The closest points of the two lines.
  const Vector3d between = b.end[end_b] - a.end[end_a];
  const double cosine = along_a.dot(along_b);
  const double on_a = (between.dot(along_a) - cosine * between.dot(along_b)) / (sine * sine);
  const double on_b = (cosine * between.dot(along_a) - between.dot(along_b)) / (sine * sine);
  const Vector3d point_a = a.end[end_a] + on_a * along_a;
  const Vector3d point_b = b.end[end_b] + on_b * along_b;
  const bool meets = (point_a - point_b).norm() <= 2 * options.straightness * size_m &&
                     std::max(std::abs(on_a), std::abs(on_b)) <= options.max_gap * size_m;
  if (!meets) return;
  const Vector3d position = (point_a + point_b) / 2;
  // Where the lines cross within an edge, what is left of it must still be one.
  const Vector3d rest_a = a.end[1 - end_a] - position;
  const Vector3d rest_b = b.end[1 - end_b] - position;
  const double least_m = kLeastRest * options.min_length * size_m;
  if (std::min(rest_a.dot(along_a), rest_b.dot(along_b)) < least_m) return;
  const double off_m = occluder.distance_m(position);
  if (off_m > options.max_gap * size_m) return;

  Candidate candidate;
  candidate.part = a.part;
  candidate.feature.kind = FeatureKind::kLineIntersection;
  candidate.feature.position_m = position;
  candidate.feature.clearance_m = off_m + 2 * options.straightness * size_m;
  candidate.feature.edges = {Edge{position, a.end[1 - end_a]}, Edge{position, b.end[1 - end_b]}};
  const double full_m = 2 * kFullLength * size_m;
  candidate.worth = std::min(a.length_m(), full_m) * std::min(b.length_m(), full_m) * sine;
  candidates.push_back(std::move(candidate));
}

std::vector<Candidate> candidates_of(const Mesh& mesh, const Occluder& occluder, double size_m,
                                     const ProposalOptions& options) {
  const std::vector<StraightEdge> edges = straight_edges(mesh, size_m, options);
  std::vector<Candidate> candidates;
  for (size_t i = 0; i < edges.size(); ++i) {
    for (size_t j = i + 1; j < edges.size(); ++j) {
      for (int end = 0; end < 4; ++end) {
        add_candidate(edges[i], end / 2, edges[j], end % 2, occluder, size_m, options, candidates);
      }
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.worth > b.worth; });
  if (candidates.size() > kMaxCandidates) candidates.resize(kMaxCandidates);
  return candidates;
}

// How one edge of a feature looks from one side.
struct EdgeView {
  int in_sight = 0;  // of the samples
  int outline = 0;   // of those in sight
  double length_m = 0;
  Vector3d along;  // in the image plane, unit length
};

EdgeView look_at(const Edge& edge, const Occluder& occluder, const Vector3d& to_eye,
                 double clearance_m, double size_m) {
  EdgeView view;
  const Vector3d whole = edge.end_m - edge.begin_m;
  const Vector3d projected = whole - to_eye * to_eye.dot(whole);
  view.length_m = projected.norm();
  if (view.length_m == 0) return view;
  view.along = projected / view.length_m;
  const Vector3d aside = kOutlineShift * size_m * view.along.cross(to_eye);
  const Vector3d shown = whole * std::min(1.0, kWindow * size_m / whole.norm());
  for (int i = 1; i <= kSamplesPerEdge; ++i) {
    const Vector3d point = edge.begin_m + shown * i / (kSamplesPerEdge + 1);
    const Vector3d eye = point + kViewDistance * size_m * to_eye;
    if (occluder.hides_own(point, eye, clearance_m)) continue;
    ++view.in_sight;
    const Vector3d behind = point - 2 * size_m * to_eye;
    const bool is_outline = !occluder.hides(behind + aside, eye + aside, 0) ||
                            !occluder.hides(behind - aside, eye - aside, 0);
    if (is_outline) ++view.outline;
  }
  return view;
}

void look_from_all_sides(Candidate& candidate, const std::vector<Vector3d>& directions,
                         const Occluder& occluder, double size_m) {
  const TargetFeature& feature = candidate.feature;
  int visible = 0;
  std::array<int, 2> in_sight{}, outline{};
  candidate.worth_in_view.assign(directions.size(), 0);
  for (size_t v = 0; v < directions.size(); ++v) {
    const Vector3d& to_eye = directions[v];
    const Vector3d eye = feature.position_m + kViewDistance * size_m * to_eye;
    if (occluder.hides_own(feature.position_m, eye, feature.clearance_m)) continue;
    std::array<EdgeView, 2> edges;
    for (int i = 0; i < 2; ++i) {
      edges[i] = look_at(feature.edges[i], occluder, to_eye, feature.clearance_m, size_m);
    }
    if (std::min(edges[0].in_sight, edges[1].in_sight) < kLeastSamplesInSight) continue;
    const double sine = edges[0].along.cross(edges[1].along).norm();
    if (sine < std::sin(kLeastAngleDeg * kDegree)) continue;
    ++visible;
    double worth = std::min(1.0, sine / std::sin(kFullAngleDeg * kDegree));
    for (int i = 0; i < 2; ++i) {
      const EdgeView& edge = edges[i];
      in_sight[i] += edge.in_sight;
      outline[i] += edge.outline;
      const double share = static_cast<double>(edge.outline) / kSamplesPerEdge;
      worth *= std::min(1.0, edge.length_m / (kFullLength * size_m)) *
               (kInnerEdgeWorth + (1 - kInnerEdgeWorth) * share);
    }
    candidate.worth_in_view[v] = worth;
  }
  candidate.visible_fraction =
      static_cast<double>(visible) / static_cast<double>(directions.size());
  if (visible == 0) return;
  candidate.outline_fraction = std::min(static_cast<double>(outline[0]) / in_sight[0],
                                        static_cast<double>(outline[1]) / in_sight[1]);
}

// Lower-case letters, digits and single underscores.
std::string as_word(const std::string& name) {
  std::string word;
  for (const char c : name) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80 && std::isalnum(code)) {
      word += static_cast<char>(std::tolower(code));
    } else if (!word.empty() && word.back() != '_') {
      word += '_';
    }
  }
  while (!word.empty() && word.back() == '_') word.pop_back();
  return word.empty() ? "part" : word;
}

// Drops what is seen from too few sides, or hardly ever before the background.
void drop_poor(const ProposalOptions& options, std::vector<Candidate>& candidates) {
  std::erase_if(candidates, [&](const Candidate& candidate) {
    return candidate.visible_fraction < options.min_visible_fraction ||
           candidate.outline_fraction < options.min_outline_fraction;
  });
}

}  // namespace

bool is_moving_part(const std::string& name) {
  // A word of its name: what turns, what it looks like then, or both in one.
  constexpr std::array<std::string_view, 4> kTurns = {"propeller", "prop", "rotor", "fan"};
  constexpr std::array<std::string_view, 4> kLooks = {"disc", "disk", "blur", "blade"};
  const auto is_moving_word = [&](std::string_view word) {
    while (!word.empty() && std::isdigit(static_cast<unsigned char>(word.back()))) {
      word.remove_suffix(1);
    }
    if (word.ends_with('s')) word.remove_suffix(1);
    const bool looks = std::ranges::find(kLooks, word) != kLooks.end();
    return looks || std::ranges::any_of(kTurns, [&](std::string_view turns) {
             if (!word.starts_with(turns)) return false;
             const std::string_view rest = word.substr(turns.size());
             return rest.empty() || std::ranges::find(kLooks, rest) != kLooks.end();
           });
  };
  const std::string words = as_word(name);
  size_t begin = 0;
  while (begin <= words.size()) {
    const size_t end = std::min(words.find('_', begin), words.size());
    if (is_moving_word(std::string_view(words).substr(begin, end - begin))) return true;
    begin = end + 1;
  }
  return false;
}

std::vector<FeatureProposal> propose_features(const Mesh& mesh, const Occluder& occluder,
                                              const ProposalOptions& options) {
  const Bounds box = bounds(mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  std::vector<Candidate> corners = candidates_of(mesh, occluder, size_m, options);
  const std::vector<Vector3d> directions = directions_all_round(options.views);
  for (Candidate& corner : corners) look_from_all_sides(corner, directions, occluder, size_m);
  drop_poor(options, corners);
  std::vector<Candidate> chosen;
  choose(std::move(corners), options.max_features, options.min_distance * size_m, chosen);
  const int enough = std::min(options.max_features, options.enough_corners);
  if (static_cast<int>(chosen.size()) < enough) {
    std::vector<Candidate> tips = rounded_tips(mesh, occluder, directions);
    drop_poor(options, tips);
    choose(std::move(tips), enough, kTipDistance * size_m, chosen);
  }
  std::vector<FeatureProposal> proposals;
  std::map<std::string, int> last_number;
  for (Candidate& candidate : chosen) {
    const std::string part = as_word(mesh.parts[candidate.part].name);
    candidate.feature.name = fmt::format("{}_{}", part, ++last_number[part]);
    proposals.push_back(
        {candidate.feature, candidate.visible_fraction, candidate.outline_fraction});
  }
  return proposals;
}

}  // namespace sightline
