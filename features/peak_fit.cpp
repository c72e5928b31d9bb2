// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/peak_fit.h"

#include <array>
#include <cmath>

namespace sightline {
namespace {

// How far a peak may be from where the model expects it, round by round.
constexpr std::array kRoundsPx = {1.8, 1.3, 1.0, 0.8};

const EdgePeak* nearest_peak(const EdgePeaks& peaks, double expected_px, double most_px) {
  const EdgePeak* nearest = nullptr;
  double nearest_px = most_px;
  for (const EdgePeak& peak : peaks) {
    const double distance_px = std::abs(peak.offset_px - expected_px);
    if (distance_px > nearest_px) continue;
    nearest_px = distance_px;
    nearest = &peak;
  }
  return nearest;
}

}  // namespace

double known_beforehand(double sd) {
  constexpr double kPointPx = 0.2;  // the standard deviation of one independent measurement
  return kSamplesOfOne * kPointPx * kPointPx / (sd * sd);
}

std::optional<std::vector<ChosenPeak>> fit_to_peaks(std::span<const EdgePeaks> samples,
                                                    size_t fewest, PeakModel& model) {
  const double least = kLeastPeakSupport * static_cast<double>(samples.size());
  std::vector<ChosenPeak> chosen;
  chosen.reserve(samples.size());
  for (const double round_px : kRoundsPx) {
    chosen.clear();
    for (size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].size() == 0) continue;
      const EdgePeak* const peak = nearest_peak(samples[i], model.expected_px(i), round_px);
      if (peak != nullptr) chosen.push_back({i, *peak});
    }
    if (chosen.size() < fewest || static_cast<double>(chosen.size()) < least) return std::nullopt;
    if (!model.move_to(chosen)) return std::nullopt;
  }
  return chosen;
}

double mean_contrast_grey(const std::vector<ChosenPeak>& peaks) {
  double gradient = 0;
  for (const ChosenPeak& chosen : peaks) gradient += std::abs(chosen.peak.gradient);
  return gradient / static_cast<double>(peaks.size()) / kGradientOfUnitEdge;
}

}  // namespace sightline
