// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Every small set of points tried as the set of outliers, in closed form on the linearised problem.
// The formulas, and where they come from, stand in pose/solvers/orpe_weighed.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/kernels/removal_kernel.h"
#include "pose/packed_points.h"
#include "pose/reprojection.h"
#include "pose/robust.h"

namespace sightline {

/// The sum of squares, whitened, below which residuals look like noise: 1.3 times what is expected,
/// less where so many points are left that their sum is better known (1.5 of its standard
/// deviations).
inline double noise_like_rss(int degrees) {
  return std::min(1.3 * degrees, degrees + 1.5 * std::sqrt(2.0 * degrees));
}

/// Where the size of the noise is not known: a scaled inverse chi-square prior of its variance.
inline constexpr double kPriorDegrees = 2;
inline constexpr double kPriorSigmaPx = 2;

/// What does not depend on the pose. Holds a pointer to the correspondences.
struct RemovalModel {
  const Correspondences* c = nullptr;
  bool is_sigma_known = false;
  /// Of an inlier's errors where all points have one; of unit noise where it is not known.
  std::optional<double> common_variance;
  std::vector<Eigen::Matrix2d> information;  ///< else: the inverse covariance of each inlier
  std::vector<double> gamma;                 ///< of each point, noise over slab, squared
  std::vector<double> log_odds;              ///< of being an outlier, with the slab's height
  int max_removed = 0;

  /// A point's squared error in deviations of the noise.
  double squared(int point, const Eigen::Vector2d& r) const {
    return common_variance ? r.squaredNorm() / *common_variance : r.dot(information[point] * r);
  }

  int n() const { return static_cast<int>(c->size()); }
  int degrees(int removed) const { return 2 * n() - 6 - 2 * removed; }
};

RemovalModel removal_model(const WhitenedCorrespondences& c, const OutlierOptions& options);

/// The points weighed by their information.
PackedPoints packed(const RemovalModel& s);

/// A set of points held to be the outliers.
struct RemovalSet {
  std::array<unsigned short, kernel::kMaxRemoved> points;  ///< ascending
  int size = 0;

  std::span<const unsigned short> span() const& { return {points.data(), points.data() + size}; }
  void span() const&& = delete;  // of a temporary, which a loop over it would not keep alive
  bool operator==(const RemovalSet& other) const {
    return std::ranges::equal(span(), other.span());
  }
};

/// A set in the linear model.
struct WeighedSet {
  RemovalSet set;
  double log_weight = 0;
  double rss = 0;  ///< of the kept points, whitened
};

/// Numbers to work in, not set to anything; as many as up to eight points need without an
/// allocation.
class NumberRoom {
 public:
  NumberRoom() {}  // NOLINT(modernize-use-equals-default): that would set the numbers to zero
  NumberRoom(const NumberRoom&) = delete;
  NumberRoom& operator=(const NumberRoom&) = delete;

  double* take(std::size_t count) {
    if (count <= kInline) return inline_.data();
    heap_ = std::make_unique_for_overwrite<double[]>(count);
    return heap_.get();
  }

 private:
  static constexpr std::size_t kInline = 1792;
  std::array<double, kInline> inline_;
  std::unique_ptr<double[]> heap_;
};

/// What a sweep over the sets of up to max_size points gave, the empty one first.
struct Sweep {
  int max_size = 0;
  std::size_t count = 0;
  kernel::SweptSets of = {};
  double* workspace = nullptr;
};

/// A problem linearised at a pose, with the room that the work on it needs.
struct Linearisation {
  Pose pose;
  kernel::LinearModel model;
  std::size_t stride = 0;  ///< 0: no room yet
  double* basis = nullptr;
  double* residuals = nullptr;
  Sweep sweep;
  NumberRoom room;
  std::vector<WeighedSet> sets;

  double residual_at(int half, int i) const { return residuals[half * stride + i]; }
};

/// False when a point is behind the camera or the points do not determine the pose.
bool linearise(const RemovalModel& s, const PackedPoints& points, const Pose& pose,
               Linearisation& linear);

/// Weighs all sets of up to `max_size` points into linear.sets, the empty one first. What all sets
/// of a start have in common is included, so that weights of different starts compare.
void weigh_sets(const RemovalModel& s, int max_size, Linearisation& linear);

/// Sweeps the sets of up to `fewest` points, or of as few more as it takes for one of them to leave
/// what looks like noise; of all sizes allowed where the noise is not known. Weighs into
/// linear.sets those that have at least `least` of the weight of the heaviest, or more of them.
void weigh_explaining_sets(const RemovalModel& s, int fewest, double least, Linearisation& linear);

/// Weighs all sets of the last sweep.
void weigh_swept_sets(const RemovalModel& s, Linearisation& linear);

const WeighedSet& heaviest(const std::vector<WeighedSet>& sets);

/// The heaviest sets, at most `count`, none below `least` of the heaviest.
std::vector<RemovalSet> heaviest_sets(const std::vector<WeighedSet>& sets, std::size_t count,
                                      double least);

/// For each size the two sets that leave the least.
std::vector<RemovalSet> least_residual_sets(const std::vector<WeighedSet>& all, int max_size);

/// What stands on the diagonal for the points of a set (Gamma: noise over slab, squared, of
/// Student's law), and the step to its pose.
struct SetStep {
  std::array<double, kernel::kMaxRemoved> slab;
  Vector6d delta;
};

SetStep step_of(const RemovalModel& s, const Linearisation& linear, const RemovalSet& set);

}  // namespace sightline
