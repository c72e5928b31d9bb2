// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The outline of the feature's parts as the prior pose shows it on the mesh, laid onto the image's
// edges: along each sample's normal the peaks of the gradient; they vote for a shift; robust least
// squares fits the shift and, unless the prior is good, a turn. It needs no straight edges, and is
// the only good way to a rounded nose or an engine.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "features/extractors/extractors.h"
#include "features/outline_search.h"

namespace sightline {
namespace {

constexpr double kMinSupport = 0.4;  // of the samples must have a peak on the outline
constexpr int kFewestSamples = 8;
constexpr std::array kRoundsPx = {1.8, 1.3, 1.0, 0.8};  // of a peak from the outline
constexpr double kSamplesOfOne = 3;                     // as in model_edges
constexpr double kLeastScatterPx = 0.05;
constexpr double kMaxSdPx = 1.5;  // of the shift in its worst direction

struct SamplePeaks {
  const OutlineSample* sample;
  EdgePeaks peaks;
};

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

struct Registration {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();  // shift, and turn about the feature
  Eigen::Matrix3d covariance;
  std::vector<Eigen::Vector2d> edge_pixels;
  double gradient = 0;
};

Eigen::Vector3d row_of(const OutlineSample& sample, const Eigen::Vector2d& feature) {
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

// True where what was found holds the shift in every direction nearly as well as all samples would.
bool is_held(const Eigen::Matrix2d& found, const std::vector<SamplePeaks>& samples) {
  Eigen::Matrix2d all = Eigen::Matrix2d::Zero();
  for (const SamplePeaks& at : samples) all += at.sample->normal * at.sample->normal.transpose();
  const auto least = [](const Eigen::Matrix2d& information) {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(information).eigenvalues()[0];
  };
  return least(found) >= kMinSupport * least(all);
}

std::optional<Registration> registered(const std::vector<SamplePeaks>& samples,
                                       const Eigen::Vector2d& feature, const Eigen::Vector2d& shift,
                                       double turn_sd_rad) {
  constexpr double kPointPx = 0.2;
  constexpr double kNoTurnRad = 1e-6;
  const double turn_sd = std::max(turn_sd_rad, kNoTurnRad);
  Registration fit;
  fit.motion << shift, 0;
  double squares = 0;
  for (const double round_px : kRoundsPx) {
    fit.edge_pixels.clear();
    fit.gradient = 0;
    squares = 0;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    information(2, 2) = kSamplesOfOne * kPointPx * kPointPx / (turn_sd * turn_sd);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const SamplePeaks& at : samples) {
      const Eigen::Vector3d row = row_of(*at.sample, feature);
      const double expected_px = row.dot(fit.motion);
      const EdgePeak* nearest = nullptr;
      double nearest_px = round_px;
      for (const EdgePeak& peak : at.peaks) {
        const double distance_px = std::abs(peak.offset_px - expected_px);
        if (distance_px > nearest_px) continue;
        nearest_px = distance_px;
        nearest = &peak;
      }
      if (nearest == nullptr) continue;
      information += row * row.transpose();
      sum += row * nearest->offset_px;
      squares += nearest->offset_px * nearest->offset_px;
      fit.gradient += std::abs(nearest->gradient);
      fit.edge_pixels.push_back(at.sample->pixel + nearest->offset_px * at.sample->normal);
    }
    const double n = static_cast<double>(fit.edge_pixels.size());
    if (n < kFewestSamples || n < kMinSupport * static_cast<double>(samples.size())) {
      return std::nullopt;
    }
    if (!is_held(information.topLeftCorner<2, 2>(), samples)) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix3d> factor(information);
    fit.motion = factor.solve(sum);
    squares = std::max(0.0, squares - fit.motion.dot(sum));
    fit.covariance = factor.solve(Eigen::Matrix3d::Identity());
  }
  const double n = static_cast<double>(fit.edge_pixels.size());
  fit.gradient /= n;
  const double variance = std::max(squares / n, kLeastScatterPx * kLeastScatterPx);
  fit.covariance *= kSamplesOfOne * variance;
  return fit;
}

// What the fit does not know of. A round body darkens towards its limb: against a darker background
// its edge is seen inside its outline.
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

}  // namespace

void extract_contour(const ExtractionInput& input, Observation& observation) {
  const SearchOptions& options = input.options.search;
  const Eigen::Vector2d& feature = input.prediction.pixel;
  observation.window = window_around(feature, search_window_half_px(input), input.image.size());
  if (observation.window.empty()) {
    observation.status = ObservationStatus::kOutsideImage;
    return;
  }
  const std::vector<OutlineSample> samples =
      outermost(predict_outline(input.view, input.prediction, options.outline_reach_px));
  if (samples.size() < kFewestSamples) {
    observation.status = ObservationStatus::kNoOutline;
    return;
  }
  const GradientWindow gradients = gradients_around(input, samples);
  const int polarity = outline_polarity(input, samples);
  const double threshold = gradient_threshold(options);
  Votes votes(std::max(search_half_px(input, Eigen::Vector2d::UnitX()),
                       search_half_px(input, Eigen::Vector2d::UnitY())));
  std::vector<SamplePeaks> peaks;
  peaks.reserve(samples.size());
  for (const OutlineSample& sample : samples) {
    peaks.push_back({&sample, find_peaks(gradients, sample.pixel, sample.normal,
                                         search_half_px(input, sample.normal),
                                         sample.borders_target ? 0 : polarity, threshold)});
    for (const EdgePeak& peak : peaks.back().peaks) votes.add(sample.normal, peak.offset_px);
  }
  const auto fit =
      registered(peaks, feature, votes.best(), is_prior_good(input) ? 0 : options.turn_sd_rad);
  if (!fit) {
    observation.status = ObservationStatus::kTooFewEdgePixels;
    return;
  }
  observation.contour = fit->edge_pixels;
  observation.laid_outline.reserve(samples.size());
  for (const OutlineSample& sample : samples) {
    observation.laid_outline.push_back(moved(sample, feature, fit->motion));
  }
  observation.contrast_grey = fit->gradient / kGradientOfUnitEdge;
  const double floor =
      options.floor_scale * floor_px(input.prediction.kind, observation.contrast_grey, polarity);
  observation.covariance_px2 =
      fit->covariance.topLeftCorner<2, 2>() + floor * floor * Eigen::Matrix2d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(observation.covariance_px2);
  if (!(eigen.eigenvalues()[1] <= kMaxSdPx * kMaxSdPx)) {
    observation.status = ObservationStatus::kParallelLines;
    return;
  }
  observation.status = ObservationStatus::kFound;
  observation.pixel = feature + fit->motion.head<2>();
}

}  // namespace sightline
