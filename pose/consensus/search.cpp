// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "pose/consensus/noise.h"
#include "pose/consensus/score.h"
#include "pose/p3p.h"
#include "pose/robust.h"

namespace sightline::consensus {
namespace {

constexpr std::size_t kMostEnumerated = 12;
constexpr std::size_t kMostUnscreened = 32;
/// The chance that the better consensus is missed, and that a triple of inliers leads to it.
constexpr double kMissed = 1e-3;
constexpr double kLeads = 0.75;
constexpr int kFewestTriples = 20;
/// A hypothesis is worth a fit while its score is above this part of the record, and is dropped
/// when its count is below that part.
constexpr double kPromisingScore = 0.75;
constexpr double kPromisingCount = 0.7;
constexpr std::size_t kFittedEarly = 500;
constexpr std::size_t kFittedLate = 1000;
constexpr std::size_t kFullyFitted = 6;

/// How many triples it takes until one of a consensus of so many of n points was met.
double triples_needed(double inliers, double n) {
  const double chance =
      kLeads * std::max(0.0, inliers * (inliers - 1) * (inliers - 2)) / (n * (n - 1) * (n - 2));
  return chance > 0 ? std::log(kMissed) / std::log1p(-std::min(chance, 0.999999)) : kMostTriples;
}

/// The size of the smallest consensus of n points with noise of the usual size that chance does not
/// explain.
double smallest_significant(double n) {
  constexpr double kRadius2 = 6 * kTypicalNoise * kTypicalNoise;  // of 95 % of the inliers
  const double chance = std::numbers::pi * kRadius2;
  double inliers = 5;
  while (inliers < n && (n - 3) * bernoulli_divergence((inliers - 3) / (n - 3), chance) <
                            least_log_improbability(kMostTriples, n)) {
    ++inliers;
  }
  return inliers;
}

/// The hypotheses of the best scores, best first.
class Ranking {
 public:
  struct Entry {
    Pose cam_from_centred;
    double score, scale;
  };

  explicit Ranking(std::size_t most) : most_(most) {}

  bool add(const Entry& entry) {
    if (entries_.size() >= most_ && entry.score <= entries_.back().score) return false;
    const auto place =
        std::ranges::upper_bound(entries_, entry.score, std::ranges::greater{}, &Entry::score);
    entries_.insert(place, entry);
    if (entries_.size() > most_) entries_.pop_back();
    return true;
  }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::size_t most_;
  std::vector<Entry> entries_;
};

/// The radius, and the counts within it, by which hypotheses are dropped before they are scored.
class Screen {
 public:
  explicit Screen(const Cloud& cloud) : cloud_(cloud) {
    const double n = static_cast<double>(cloud.size());
    least_share_ = std::max(4 / n, std::cbrt(std::log(1 / kMissed) / (kLeads * kMostTriples)));
    expected_share_ = least_share_;
    chance_ = std::clamp(least_share_ / 20, 1e-5, 0.02);
    radius2_ = chance_ / std::numbers::pi;
    if (!cloud.is_sigma_known()) return;
    const double noise2 = cloud.sigma * cloud.sigma;
    constexpr double kNarrowest2 = 4.5 * 4.5, kWidest2 = 16 * 16;
    /// 4.5 pixels of an image of 640 x 480: so far the pose of three noisy points errs.
    constexpr double kPoseError2 = 6.5e-5;
    const double most = std::max(kWidest2 * noise2, cloud.whitening.empty() ? kPoseError2 : 0);
    const double unit = cloud.whitening.empty() ? radius2_ : kNarrowest2;
    radius2_ = std::min(std::max(unit, kNarrowest2 * noise2), most);
    chance_ = std::min(mean_chance(), 0.5);
  }

  /// The number of points within the radius; 0 for a pose of too few.
  int count(const Pose& pose) const {
    const double hit = 0.6 * expected_share_;
    const double stray = std::min(1.5 * chance_, 0.5 * hit);
    const double met = std::log(hit / stray), unmet = std::log((1 - hit) / (1 - stray));
    constexpr std::size_t kBlock = 32;
    constexpr double kHopeless = -3.5;
    const kernel::ScreenPose screen = screen_pose(cloud_, pose);
    const std::size_t padded = cloud_.screen.padded();
    int count = 0;
    for (std::size_t begin = 0; begin < padded; begin += kBlock) {
      const std::size_t end = std::min(begin + kBlock, padded);
      count +=
          kernel::count_within(cloud_.screen, screen, begin, end, static_cast<float>(radius2_));
      const int seen = static_cast<int>(std::min(end, cloud_.size()));
      if (count * met + (seen - count) * unmet < kHopeless) return 0;
    }
    return count;
  }

  /// A mode with this share of inliers was found: only better ones are looked for.
  void raise(double share) { expected_share_ = std::max(expected_share_, 0.9 * share); }

 private:
  double mean_chance() const {
    double sum = 0;
    for (const float reach : cloud_.screen.reach) sum += static_cast<double>(reach);
    return std::numbers::pi * radius2_ * sum / static_cast<double>(cloud_.size());
  }

  const Cloud& cloud_;
  double least_share_, expected_share_, chance_, radius2_;
};

class Search {
 public:
  explicit Search(const Cloud& cloud)
      : cloud_(cloud),
        n_(cloud.size()),
        is_exhaustive_(n_ <= kMostEnumerated),
        scorer_(cloud),
        screen_(cloud),
        ranking_(is_exhaustive_ ? 32 : 12),
        tight_ranking_(12) {
    for (std::size_t i = 0; i < n_; ++i) {
      rays_.emplace_back(cloud.image[i].cwiseQuotient(cloud.focal).homogeneous());
    }
  }

  Found run() {
    if (cloud_.initial_cam_from_centred) rank(*cloud_.initial_cam_from_centred);
    is_exhaustive_ ? try_all_triples() : try_drawn_triples();
    fit_ranked();
    fit_mirror();
    fit_fully();
    return std::move(found_);
  }

 private:
  void try_all_triples() {
    for (std::size_t a = 0; a < n_; ++a) {
      for (std::size_t b = a + 1; b < n_; ++b) {
        for (std::size_t c = b + 1; c < n_; ++c) try_triple({a, b, c});
      }
    }
  }

  void try_drawn_triples() {
    constexpr std::uint64_t kStream = 0x9e3779b97f4a7c15u;
    std::uint64_t counter = 0;
    const auto draw = [&] {
      const std::uint64_t bits = mixed_bits(kStream * ++counter);
      return static_cast<std::size_t>(((bits >> 32) * n_) >> 32);
    };
    while (found_.triples < kMostTriples &&
           (found_.triples < kFewestTriples || found_.triples < needed_)) {
      const std::size_t a = draw(), b = draw(), c = draw();
      if (a != b && a != c && b != c) try_triple({a, b, c});
    }
  }

  void try_triple(const std::array<std::size_t, 3>& triple) {
    ++found_.triples;
    std::array<Eigen::Vector3d, 3> points, rays;
    for (std::size_t k = 0; k < 3; ++k) {
      points[k] = cloud_.points_in_centred[triple[k]];
      rays[k] = rays_[triple[k]];
    }
    const P3pPoses poses = p3p(points, rays);
    for (const Pose& pose : poses.all()) {
      if (!pose.rotation.allFinite() || !pose.translation.allFinite()) continue;
      n_ <= kMostUnscreened ? consider_unscreened(pose) : consider(pose);
    }
  }

  void consider_unscreened(const Pose& pose) {
    const Score score = scorer_.score(pose);
    const bool is_ranked = rank(pose, score);
    if (is_exhaustive_ || !is_ranked || score.total <= record_) return;
    record_ = score.total;
    fit(pose, score.scale, n_);
    update_need();
  }

  void consider(const Pose& pose) {
    const int count = screen_.count(pose);
    if (count < 4 || count < kPromisingCount * record_count_) return;
    record_count_ = std::max(record_count_, count);
    const Score score = scorer_.score(pose);
    rank(pose, score);
    const bool is_record = score.total > record_;
    const bool is_promising =
        score.total > kPromisingScore * record_ && found_.fits < 10 + found_.triples / 400;
    if (!is_record && !is_promising) return;
    record_ = std::max(record_, score.total);
    fit(pose, score.scale, kFittedEarly);
    update_need();
    if (found_.modes.is_empty()) return;
    screen_.raise(inlier_share());
  }

  void rank(const Pose& pose) { rank(pose, scorer_.score(pose)); }

  bool rank(const Pose& pose, const Score& score) {
    if (score.tight_total > 0) {
      tight_ranking_.add({pose, score.tight_total, score.tight_scale});
    }
    return score.total > 0 && ranking_.add({pose, score.total, score.scale});
  }

  void fit(const Pose& pose, double scale, std::size_t points) {
    ++found_.fits;
    const double start =
        cloud_.is_sigma_known() ? std::clamp(scale, cloud_.sigma, 16 * cloud_.sigma) : scale;
    Mode mode;
    mode.cam_from_centred = pose;
    mode.law = outlier_law(cloud_);
    if (fit_mixture(cloud_, start, {15, 1e-4, points}, mode)) found_.modes.add(std::move(mode));
  }

  /// Of the best mode; it may have been fitted to some of the points only.
  double inlier_share() const {
    const Mode& best = found_.modes.best();
    return best.inliers / static_cast<double>(best.weights.size());
  }

  void update_need() {
    if (found_.modes.is_empty()) return;
    const double n = static_cast<double>(n_);
    needed_ = triples_needed(std::min(inlier_share() * n, n), n);
    if (cloud_.is_sigma_known()) return;
    // Where the noise is not known, many points that are met roughly may hide fewer that are met
    // precisely, and some agree with any pose of three.
    constexpr double kRoughVariance = 9e-6;
    const Mode& best = found_.modes.best();
    const double share = best.variance > kRoughVariance ? 0.3 : 0.5;
    needed_ = std::max(needed_, -std::log(kMissed) / (share * share * share * kLeads));
    const bool is_significant = scorer_.log_improbability(best.cam_from_centred) >
                                least_log_improbability(found_.triples, n);
    if (!is_significant) needed_ = std::max(needed_, triples_needed(smallest_significant(n), n));
  }

  void fit_ranked() {
    for (const Ranking::Entry& entry : tight_ranking_.entries()) {
      fit(entry.cam_from_centred, entry.scale, kFittedLate);
    }
    std::size_t left = n_ <= 100 ? 12 : 4;
    for (const Ranking::Entry& entry : ranking_.entries()) {
      if (is_near_a_mode(entry.cam_from_centred)) continue;
      if (!is_exhaustive_ && left-- == 0) break;
      if (!is_exhaustive_ && entry.score < 0.6 * ranking_.entries().front().score) break;
      fit(entry.cam_from_centred, entry.scale, kFittedLate);
    }
  }

  bool is_near_a_mode(const Pose& pose) const {
    constexpr double kNear = 0.06;
    return std::ranges::any_of(found_.modes.all(), [&](const Mode& mode) {
      if (squared_distance(mode, pose) < 1) return true;
      const Pose& other = mode.cam_from_centred;
      return !is_exhaustive_ && geodesic_angle_rad(other.rotation, pose.rotation) < kNear &&
             (other.translation - pose.translation).norm() < kNear * other.translation.norm();
    });
  }

  void fit_mirror() {
    if (found_.modes.is_empty()) return;
    const Mode& best = found_.modes.best();
    const std::optional<Pose> mirror = mirrored(cloud_, best);
    if (!mirror) return;
    /// The mirror pose of perspective is only near the one of weak perspective.
    constexpr double kMirrorError = 8;
    Mode mode;
    mode.cam_from_centred = *mirror;
    mode.outlier_share = best.outlier_share;
    mode.law = outlier_law(cloud_);
    const double scale = kMirrorError * std::sqrt(best.variance);
    if (fit_mixture(cloud_, scale, {25, 1e-5, kFittedLate}, mode)) {
      found_.modes.add(std::move(mode));
    }
  }

  void fit_fully() {
    ModeList full;
    std::size_t kept = 0;
    for (const Mode& mode : found_.modes.all()) {
      const double best = found_.modes.best().log_likelihood;
      const double margin = n_ <= kFittedLate ? std::max(12.0, 0.1 * std::abs(best))  //
                                              : 0.3 * std::abs(best);
      if (kept == kFullyFitted || (kept > 0 && mode.log_likelihood < best - margin)) break;
      ++kept;
      Mode fitted;
      fitted.cam_from_centred = mode.cam_from_centred;
      fitted.outlier_share = mode.outlier_share;
      fitted.law = mode.law;
      const double tolerance = n_ <= 50 ? 1e-7 : 1e-6;
      if (fit_mixture(cloud_, std::sqrt(mode.variance), {30, tolerance}, fitted)) {
        full.add(std::move(fitted));
      }
    }
    found_.modes = std::move(full);
  }

  const Cloud& cloud_;
  const std::size_t n_;
  const bool is_exhaustive_;
  Scorer scorer_;
  Screen screen_;
  Ranking ranking_, tight_ranking_;
  std::vector<Eigen::Vector3d> rays_;
  Found found_;
  double needed_ = kMostTriples;
  double record_ = -std::numeric_limits<double>::infinity();
  int record_count_ = 0;
};

}  // namespace

Found search(const Cloud& cloud) {
  return Search(cloud).run();
}

}  // namespace sightline::consensus
