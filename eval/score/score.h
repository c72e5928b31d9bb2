// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/statistics/error_statistics.h"

namespace sightline {

constexpr int kBopThresholds = 10;
using BopPasses = std::array<bool, kBopThresholds>;

/// The i-th threshold: of MSSD, VSD's tau (both of the diameter) and VSD's theta 0.05, 0.1, ...
/// 0.5; of MSPD, px in an image 640 px wide, 5, 10, ... 50.
constexpr double bop_fraction(int i) {
  return 0.05 + i * 0.05;  // rounded as the challenge's own list
}
constexpr double bop_pixels(int i) {
  return 5.0 * (i + 1);
}

/// An estimate against a true pose of the same object in the same image. measures.cpp says how each
/// number comes about and what files call it.
struct BopPair {
  size_t estimate = 0;  ///< index in the results
  size_t instance = 0;  ///< index in the image
  double mssd_mm = 0;
  double mspd_px = 0;  ///< of this image's pixels
  double add_mm = 0;
  double adi_mm = 0;
  std::vector<double> vsd;  ///< one a tau; empty where the image has no depth
  double projection_px = 0;
  // Ours, and what other benchmarks judge by, against the true pose at the symmetry that is
  // nearest.
  double theta_error_deg = 0;
  double t_error_percent = 0;
  double geodesic_deg = 0;
  double speed_score = 0;
  double speed_plus_score = 0;
  double within_5deg_5cm = 0;  ///< 1 where it is, else 0
};

/// What became of one instance that the data set asks for.
struct BopTarget {
  size_t image = 0;     ///< index in the data set
  size_t instance = 0;  ///< index in the image
  int obj_id = 0;
  BopPasses mssd{}, mspd{};                     ///< below each threshold
  std::array<BopPasses, kBopThresholds> vsd{};  ///< [tau][theta]
  bool is_add_good = false;                     ///< below a tenth of the diameter
  bool is_adi_good = false;
  bool is_symmetric = false;     ///< its object looks alike in several poses
  std::vector<BopPair> pairs;    ///< with every estimate that counts
  std::optional<size_t> chosen;  ///< of those the one that our own errors are of, if any
};

struct BopScores {
  std::vector<BopTarget> targets;
  size_t ignored_estimates = 0;  ///< of what is not asked for, or beyond the number of instances
  /// Images have depth, and every object has faces. A target in an image whose depth is missing
  /// or cannot be read, while others' can, is missed by VSD.
  bool has_vsd = true;
  bool has_faces = true;         ///< every object has faces
  int images_without_depth = 0;  ///< where some have it
  bool has_models = true;        ///< every object has vertices
};

/// Why there is no VSD, or what it lacks, in a line; empty where it lacks nothing.
std::string note_on_vsd(const BopScores& scores);

/// Of one target: the share of the thresholds that it passes, of VSD the mean over tau.
struct TargetRecalls {
  double mssd = 0;
  double mspd = 0;
  double vsd = 0;
  double mean() const { return (mssd + mspd + vsd) / 3; }
};

TargetRecalls recalls_of(const BopTarget& target);

/// ADD(-S) (Xiang et al., "PoseCNN", RSS 2018): below a tenth of the diameter by ADI where the
/// object has symmetries, else by ADD.
bool is_add_s_good(const BopTarget& target);

/// Scores estimates as the BOP challenge of 2019 and later does (task: localisation of a known
/// number of instances): of every object in an image count as many estimates as instances are asked
/// for, those of the highest scores, and as truth as many instances, the most visible. For every
/// error and threshold the estimates, best score first, each take the free instance with the least
/// error below the threshold. Our own errors are of the same without a threshold, by MSSD. `tick`
/// is called for every image. Of an object without vertices there are the errors of the pose alone,
/// by T_error.
/// An estimate that is none, and every one of an instance without a true pose, has no pair: the
/// target is missed.
BopScores score_bop(
    const BopDataset& dataset, std::span<const BopEstimate> estimates, double vsd_delta_mm,
    const std::function<void()>& tick = [] {});

/// The greatest SPEED score that is told apart: an attitude upside down, and a position that errs
/// by its own length. A target that is missed counts so.
constexpr double kSpeedScoreCap = std::numbers::pi + 1;

/// A rate or a mean, with its 95 % interval.
struct BopRate {
  double value = kNoNumber;
  Interval95 ci95 = kNoInterval;
};

/// Average recalls of some targets, and the rates and errors of measures.cpp; a target without an
/// estimate is missed. What needs VSD is NaN without depth, what needs vertices without a model.
struct BopSummary {
  int64_t targets = 0;
  int64_t estimated = 0;  ///< targets that have an estimate
  BopRate ar, ar_mssd, ar_mspd, ar_vsd;
  BopRate add, adi;  ///< recall at a tenth of the diameter
  BopRate add_s;     ///< ADD(-S): ADI of objects with symmetries, ADD of the others
  BopRate projection_5px, within_5deg_5cm;
  std::array<double, kBopThresholds> mssd_recalls{}, mspd_recalls{};
  ErrorSummary theta_error_deg, t_error_percent, geodesic_deg;  ///< a missed one has failed
  ErrorSummary speed_score, speed_plus_score;                   ///< a missed one has failed
};

/// All that is told of a scored results file.
struct ScoredResults {
  std::string results;  ///< the file's name as it was given
  std::string set;      ///< the data set's folder, alike
  double vsd_delta_mm = 0;
  const BopDataset& dataset;
  std::span<const BopEstimate> estimates;
  const BopScores& scores;
};

/// A line where no estimate is at a distance like the true one, as in another unit; else empty.
std::string note_on_units(const BopDataset& dataset, std::span<const BopEstimate> estimates,
                          const BopScores& scores);

BopSummary summarise(const BopScores& scores);
/// The same of each object's targets.
std::map<int, BopSummary> summarise_by_object(const BopScores& scores);

}  // namespace sightline
