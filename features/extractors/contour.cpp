// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The outline of the feature's parts as the prior pose shows it on the mesh, laid onto the image's
// edges: along each sample's normal the peaks of the gradient; they vote for a shift; robust least
// squares fits the shift and, unless the prior is good, a turn. It needs no straight edges, and is
// the only good way to a rounded nose or an engine.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "features/extractors/extractors.h"
#include "features/outline_search.h"
#include "features/peak_fit.h"

namespace sightline {
namespace {

constexpr int kFewestOutlineSamples = 8;
constexpr double kMaxShiftSdPx = 1.5;  // of the shift in its worst direction

// Votes for shifts, in cells of a pixel.
class Votes {
 public:
  explicit Votes(double half_px)
      : half_(static_cast<int>(std::ceil(half_px)) + 1),
        size_(2 * half_ + 1),
        counts_(static_cast<size_t>(size_) * size_) {}

  // One for every cell on the line normal . shift = offset.
  void add(const Eigen::Vector2d& normal, double offset_px) {
    const bool is_steep = std::abs(normal.x()) > std::abs(normal.y());
    const double across = is_steep ? normal.x() : normal.y();
    const double along = is_steep ? normal.y() : normal.x();
    for (int i = -half_; i <= half_; ++i) {
      const double j = (offset_px - along * i) / across;
      const int cell = static_cast<int>(std::lround(j));
      if (std::abs(cell) > half_) continue;
      at(is_steep ? cell : i, is_steep ? i : cell) += 1;
    }
  }

  // The shift with the most votes, neighbours' counted.
  Eigen::Vector2d best() const {
    float most = -1;
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();
    for (int v = -half_ + 1; v < half_; ++v) {
      for (int u = -half_ + 1; u < half_; ++u) {
        float sum = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) sum += count(u + du, v + dv);
        }
        sum += 0.1F * count(u, v) - 1e-3F * static_cast<float>(std::hypot(u, v));
        if (sum <= most) continue;
        most = sum;
        shift = {static_cast<double>(u), static_cast<double>(v)};
      }
    }
    return shift;
  }

 private:
  float& at(int u, int v) { return counts_[static_cast<size_t>((v + half_) * size_ + u + half_)]; }
  float count(int u, int v) const {
    return counts_[static_cast<size_t>((v + half_) * size_ + u + half_)];
  }

  int half_;
  int size_;
  std::vector<float> counts_;
};

// What a small motion of the outline, a shift in u and v and a turn about the feature, does to the
// offset of a sample along its normal.
Eigen::Vector3d offset_by_motion(const OutlineSample& sample, const Eigen::Vector2d& feature) {
  const Eigen::Vector2d arm = sample.pixel - feature;
  return {sample.normal.x(), sample.normal.y(),
          sample.normal.y() * arm.x() - sample.normal.x() * arm.y()};
}

// Where a sample of the outline comes to lie.
Eigen::Vector2d moved(const OutlineSample& sample, const Eigen::Vector2d& feature,
                      const Eigen::Vector3d& motion) {
  const Eigen::Vector2d arm = sample.pixel - feature;
  return sample.pixel + motion.head<2>() + motion[2] * Eigen::Vector2d(-arm.y(), arm.x());
}

double least_eigenvalue(const Eigen::Matrix2d& information) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(information).eigenvalues()[0];
}

// The outline's motion as a model of where its peaks lie.
class OutlineMotion : public PeakModel {
 public:
  OutlineMotion(const std::vector<OutlineSample>& samples, const Eigen::Vector2d& feature,
                const Eigen::Vector2d& shift, double turn_sd_rad)
      : known_turn_(known_beforehand(std::max(turn_sd_rad, kNoTurnRad))) {
    motion_ << shift, 0;
    rows_.reserve(samples.size());
    Eigen::Matrix2d all = Eigen::Matrix2d::Zero();
    for (const OutlineSample& sample : samples) {
      rows_.push_back(offset_by_motion(sample, feature));
      all += sample.normal * sample.normal.transpose();
    }
    least_held_ = kLeastPeakSupport * least_eigenvalue(all);
  }

  double expected_px(size_t sample) const override { return rows_[sample].dot(motion_); }

  // Peaks hold the outline where they hold its shift in every direction nearly as well as peaks at
  // all samples would.
  bool move_to(const std::vector<ChosenPeak>& peaks) override {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    information(2, 2) = known_turn_;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;
    for (const ChosenPeak& chosen : peaks) {
      const Eigen::Vector3d& row = rows_[chosen.sample];
      const double offset_px = chosen.peak.offset_px;
      information += row * row.transpose();
      sum += row * offset_px;
      squares += offset_px * offset_px;
    }
    if (!(least_eigenvalue(information.topLeftCorner<2, 2>()) >= least_held_)) return false;
    const Eigen::LDLT<Eigen::Matrix3d> factor(information);
    motion_ = factor.solve(sum);
    squares = std::max(0.0, squares - motion_.dot(sum));
    const double variance =
        std::max(squares / static_cast<double>(peaks.size()), kLeastScatterPx * kLeastScatterPx);
    covariance_ = factor.solve(Eigen::Matrix3d::Identity());
    covariance_ *= kSamplesOfOne * variance;
    return true;
  }

  /// The shift, px, and the turn, rad.
  const Eigen::Vector3d& motion() const { return motion_; }
  const Eigen::Matrix3d& covariance() const { return covariance_; }

 private:
  static constexpr double kNoTurnRad = 1e-6;

  std::vector<Eigen::Vector3d> rows_;  // of the samples
  double known_turn_;
  double least_held_;
  Eigen::Vector3d motion_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

// The standard deviation, px, of what the fit does not know of; it is added to the fit's own. A
// round body darkens towards its limb: against a darker background its edge is seen inside its
// outline. Upper estimates, measured on an airliner under many lights, of the errors that the fit's
// own sigma leaves unexplained: by `contrast_grey` for the edges of wings, greater for tips and
// other corners (0.9 px) than for engines and the like (0.2 px).
double floor_px(FeatureKind kind, double contrast_grey, int polarity) {
  constexpr double kMostPx = 1.5;
  const double by_contrast = std::min(kMostPx, 250 / std::pow(contrast_grey, 1.5));
  if (kind == FeatureKind::kLineIntersection) return by_contrast;
  if (polarity > 0) return 0.35;
  return std::hypot(kind == FeatureKind::kCorner ? 0.9 : 0.2, 2 * by_contrast);
}

// The samples with background beyond them, or all where there are few of those.
std::vector<OutlineSample> outermost(std::vector<OutlineSample> samples) {
  std::vector<OutlineSample> outer;
  for (const OutlineSample& sample : samples) {
    if (!sample.borders_target) outer.push_back(sample);
  }
  return 2 * outer.size() >= samples.size() ? outer : samples;
}

// The peaks of the gradient at each sample, as far along its normal as the outline may lie.
std::vector<EdgePeaks> peaks_at(const ExtractionInput& input,
                                const std::vector<OutlineSample>& samples, int polarity) {
  const GradientWindow gradients = gradients_around(input, samples);
  const double threshold = gradient_threshold(input.options.search);
  std::vector<EdgePeaks> peaks;
  peaks.reserve(samples.size());
  for (const OutlineSample& sample : samples) {
    peaks.push_back(find_peaks(gradients, sample.pixel, sample.normal,
                               search_half_px(input, sample.normal),
                               sample.borders_target ? 0 : polarity, threshold));
  }
  return peaks;
}

// The shift of the whole outline that most peaks are for.
Eigen::Vector2d voted_shift(const ExtractionInput& input, const std::vector<OutlineSample>& samples,
                            const std::vector<EdgePeaks>& peaks) {
  Votes votes(std::max(search_half_px(input, Eigen::Vector2d::UnitX()),
                       search_half_px(input, Eigen::Vector2d::UnitY())));
  for (size_t i = 0; i < samples.size(); ++i) {
    for (const EdgePeak& peak : peaks[i]) votes.add(samples[i].normal, peak.offset_px);
  }
  return votes.best();
}

// The observation with the outline laid on those peaks.
Observation laid(const ExtractionInput& input, const std::vector<OutlineSample>& samples,
                 const OutlineMotion& outline, const std::vector<ChosenPeak>& peaks, int polarity,
                 Observation observation) {
  const Eigen::Vector2d& feature = input.prediction.pixel;
  for (const ChosenPeak& chosen : peaks) {
    const OutlineSample& sample = samples[chosen.sample];
    observation.contour.push_back(sample.pixel + chosen.peak.offset_px * sample.normal);
  }
  observation.laid_outline.reserve(samples.size());
  for (const OutlineSample& sample : samples) {
    observation.laid_outline.push_back(moved(sample, feature, outline.motion()));
  }
  observation.contrast_grey = mean_contrast_grey(peaks);
  const double floor = input.options.search.floor_scale *
                       floor_px(input.prediction.kind, observation.contrast_grey, polarity);
  observation.covariance_px2 =
      outline.covariance().topLeftCorner<2, 2>() + floor * floor * Eigen::Matrix2d::Identity();
  if (!(worst_sd_px(observation.covariance_px2) <= kMaxShiftSdPx)) {
    observation.status = ObservationStatus::kParallelLines;
    return observation;
  }
  observation.status = ObservationStatus::kFound;
  observation.pixel = feature + outline.motion().head<2>();
  return observation;
}

}  // namespace

Observation extract_contour(const ExtractionInput& input) {
  const SearchOptions& options = input.options.search;
  const Eigen::Vector2d& feature = input.prediction.pixel;
  Observation observation = nothing_found(input);
  observation.window = window_around(feature, search_window_half_px(input), input.image.size());
  if (observation.window.empty()) {
    observation.status = ObservationStatus::kOutsideImage;
    return observation;
  }
  const std::vector<OutlineSample> samples =
      outermost(predict_outline(input.view, input.prediction, options.outline_reach_px));
  if (samples.size() < kFewestOutlineSamples) {
    observation.status = ObservationStatus::kNoOutline;
    return observation;
  }
  const int polarity = outline_polarity(input, samples);
  const std::vector<EdgePeaks> peaks = peaks_at(input, samples, polarity);
  OutlineMotion outline(samples, feature, voted_shift(input, samples, peaks),
                        is_prior_good(input) ? 0 : options.turn_sd_rad);
  const auto chosen = fit_to_peaks(peaks, kFewestOutlineSamples, outline);
  if (!chosen) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return observation;
  }
  return laid(input, samples, outline, *chosen, polarity, std::move(observation));
}

}  // namespace sightline
