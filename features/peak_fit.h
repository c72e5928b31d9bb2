// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The robust fit of a predicted outline, or of one edge of it, to the image. At every sample of
// the prediction the gradient along the normal has a few peaks (features/edge_search.h), of which
// at most one is the edge. The fit takes at each sample the peak nearest to where the model
// expects it, moves the model to the least squares of these, and does so again with peaks that
// must lie nearer. What the model is, a line or a shift and a turn, is the extractor's to say.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "features/edge_search.h"

namespace sightline {

/// The share of the samples that must have a peak on the model.
inline constexpr double kLeastPeakSupport = 0.4;

/// Smoothing and blur spread the noise of one pixel over the samples beside it: so many samples
/// count as one independent measurement.
inline constexpr double kSamplesOfOne = 3;

/// The scatter of peaks about a model is taken for at least this: fewer peaks may lie on it by
/// chance.
inline constexpr double kLeastScatterPx = 0.05;

/// What a parameter's standard deviation, known before the fit, adds to its entry on the diagonal
/// of a matrix that sums one for each sample.
double known_beforehand(double sd);

/// The peak that was taken at a sample.
struct ChosenPeak {
  size_t sample;
  EdgePeak peak;
};

/// What is fitted to peaks.
class PeakModel {
 public:
  virtual ~PeakModel() = default;

  /// Where the model, as it stands, expects that sample's peak: px along the sample's normal.
  virtual double expected_px(size_t sample) const = 0;

  /// Moves the model to the least squares of these peaks. False where they do not hold it.
  virtual bool move_to(const std::vector<ChosenPeak>& peaks) = 0;
};

/// Moves the model from where it stands onto the peaks, and gives those it lies on in the end.
/// None, and a model moved in vain, where fewer than `fewest` samples or less than
/// kLeastPeakSupport of them have a peak near it, or where they do not hold it.
std::optional<std::vector<ChosenPeak>> fit_to_peaks(std::span<const EdgePeaks> samples,
                                                    size_t fewest, PeakModel& model);

/// The contrast, grey levels, of an edge whose peaks are as high as these on average.
double mean_contrast_grey(const std::vector<ChosenPeak>& peaks);

}  // namespace sightline
