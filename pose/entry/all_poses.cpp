// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/all_poses.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "pose/entry/cleaning.h"
#include "pose/entry/rivals.h"
#include "pose/p3p.h"
#include "pose/robust.h"
#include "pose/starts.h"

namespace sightline {
namespace {

/// Minima closer than this are one.
constexpr double kOneMinimumRad = 1e-5;

P3pPoses poses_of_triple(const Correspondences& c, const std::array<std::size_t, 3>& triple) {
  std::array<Eigen::Vector3d, 3> points, rays;
  for (std::size_t k = 0; k < 3; ++k) {
    points[k] = c.points_in_centred[triple[k]];
    rays[k] = {c.pixels[triple[k]].x() / c.fx_px, c.pixels[triple[k]].y() / c.fy_px, 1};
  }
  return p3p(points, rays);
}

/// Triples of n points, all or every so many of them, in an order that does not depend on how the
/// points are given.
std::vector<std::array<std::size_t, 3>> start_triples(const Correspondences& c) {
  constexpr std::size_t kMostPoints = 40;
  const std::vector<std::size_t> order = canonical_order(c);
  const std::size_t n = std::min(order.size(), kMostPoints);
  const std::size_t count = n * (n - 1) * (n - 2) / 6;
  const std::size_t stride = (count + kMostStartTriples - 1) / kMostStartTriples;
  std::vector<std::array<std::size_t, 3>> triples;
  std::size_t next = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        if (next++ % stride == 0) triples.push_back({order[i], order[j], order[k]});
      }
    }
  }
  return triples;
}

/// The minima found so far, cam_from_centred.
class Minima {
 public:
  explicit Minima(const WhitenedCorrespondences& c) : c_(c), points_(packed(c)) {}

  void add_from(const Pose& start) {
    const LeastSquares fit = least_squares(points_, {&start, 1}, {});
    if (fit.status != PoseStatus::kOk) return;
    const auto is_same = [&fit](const LeastSquares& known) {
      const Pose& a = known.cam_from_centred;
      const Pose& b = fit.cam_from_centred;
      return geodesic_angle_rad(a.rotation, b.rotation) < kOneMinimumRad &&
             (a.translation - b.translation).norm() < kOneMinimumRad * a.translation.norm();
    };
    if (std::ranges::none_of(found_, is_same)) found_.push_back(fit);
  }

  void add_mirrors() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      add_from(entry::mirror_of(c_.points, found_[i].cam_from_centred));
    }
  }

  const std::vector<LeastSquares>& found() const { return found_; }

 private:
  const WhitenedCorrespondences& c_;
  PackedPoints points_;
  std::vector<LeastSquares> found_;
};

std::vector<LeastSquares> minima_of(const WhitenedCorrespondences& c,
                                    const std::optional<Pose>& initial) {
  Minima minima(c);
  if (c.size() == 3) {
    const P3pPoses poses = poses_of_triple(c.points, {0, 1, 2});
    for (const Pose& pose : poses.all()) minima.add_from(pose);
    return minima.found();
  }
  if (initial) minima.add_from(to_centred(*initial, c.points));
  for (const Pose& start : starting_poses(c.points, std::nullopt)) minima.add_from(start);
  for (const auto& triple : start_triples(c.points)) {
    const P3pPoses poses = poses_of_triple(c.points, triple);
    for (const Pose& pose : poses.all()) minima.add_from(pose);
  }
  minima.add_mirrors();
  return minima.found();
}

}  // namespace

PoseMinima solve_all(const PoseProblem& problem, std::span<const int> left_out) {
  PoseMinima result;
  const std::size_t n = problem.points_in_target.size();
  const std::size_t covariances = problem.covariances_px2.size();
  if (n < 3 || problem.pixels.size() != n || (covariances != 0 && covariances != n)) return result;
  result.status = PoseStatus::kDegenerate;
  result.ignored = entry::usable_part(problem).left_out;
  std::vector<int> unused;
  std::ranges::set_union(result.ignored, left_out, std::back_inserter(unused));
  entry::Part part = entry::without_points(problem, std::move(unused));
  const std::optional<Pose> initial =
      entry::usable_part(part.problem).problem.initial_cam_from_target;
  // Three points are enough here, as they are for a solver that has an initial pose.
  part.problem.initial_cam_from_target = Pose{};
  const PreparedWhitened prepared = prepare_whitened(part.problem);
  if (prepared.status != PoseStatus::kOk) return result;
  const WhitenedCorrespondences& c = prepared.correspondences;
  for (const LeastSquares& fit : minima_of(c, initial)) {
    const Pose pose = from_centred(fit.cam_from_centred, c.points);
    if (!is_valid(pose)) continue;
    result.minima.push_back(
        {pose, fit.cost_px2,
         covariance_from_centred(fit.unit_covariance, fit.cam_from_centred, c.points)});
  }
  std::ranges::sort(result.minima, {}, &PoseMinimum::cost);
  result.status = result.minima.empty() ? PoseStatus::kDiverged : PoseStatus::kOk;
  return result;
}

}  // namespace sightline
