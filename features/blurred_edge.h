// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "features/image_line.h"
#include "features/observation.h"

namespace sightline {

/// The grey levels within this distance of a line are what is fitted.
inline constexpr double kBlurredBandPx = 3;

/// Another edge that runs beside a line, nearly parallel to it, on one side of it alone.
struct EdgeBeside {
  /// From the line along its normal, px, at every pixel along the stretch from its beginning to
  /// beyond its end. Those far off do not matter.
  std::vector<double> offset_px;
  double sd_px;  ///< of these offsets, and over the stretch's half of their slope
};

/// The line moved to where the grey levels within 3 px of it look most like a straight edge
/// between two even areas, blurred by a Gaussian of unknown width: least squares on the grey levels
/// themselves, which for white noise is maximum likelihood. Noise of `noise_sd_grey`, or the
/// scatter about the fit if that is more, makes its covariance. None where that fits no edge near
/// the line: too few pixels, too little contrast, or a long way off. Edges beside it, one a side at
/// most, are fitted together with it. `image` is CV_8U.
std::optional<ImageLine> fit_blurred_edge(const cv::Mat& image, const ImageLine& line,
                                          const Stretch& stretch, double noise_sd_grey,
                                          std::span<const EdgeBeside> beside = {});

}  // namespace sightline
