// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "eval/records/records.h"
#include "eval/report/report.h"
#include "features/observation.h"
#include "registration/model_image.h"

namespace sightline {

// Pieces of SVG in the pixel coordinates of an image: one unit a pixel, pixel centres at integers.
// Every piece carries the class layer-<name> of its layer, by which the legend switches it off.

/// The picture of an image: of one with more than 256 pixels a side the part `of_interest` with a
/// margin; reduced by a whole number where that is still more than 1024; grey levels of more than 8
/// bits are brought to 8 by `bits`.
FramePicture picture_of(const cv::Mat& image, int bits, const cv::Rect& of_interest);

/// Residuals from blue (darker than the model) over white to red, in steps of half a standard
/// deviation up to this many; grey where nothing is compared.
inline constexpr int kMostResidualSds = 5;
ResidualPicture residual_picture(const std::string& solver, const ModelImage& model);

/// All that is drawn for one feature: window, its lines or its outline as it was laid, the edge
/// pixels of these, corners, truth, what was found.
/// `removers` names the solvers that judged it an outlier (their labels).
std::string feature_marks(const Observation& observation, const ObservationRecord& record,
                          const std::vector<std::string>& removers);

/// A line that solvers were given: along its edge pixels, with its errors as a title; struck out in
/// the layer of what is removed where solvers (their labels) judged it an outlier.
std::string observed_line_mark(const EdgeLine& found, const LineRecord& record,
                               const std::vector<std::string>& removers);

/// Closed polygons as the data of a path.
std::string outline_path(const Outline& outline);

/// The viewBox that shows exactly these pixels.
std::string view_box(const cv::Rect& pixels);

}  // namespace sightline
