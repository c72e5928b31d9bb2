// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Straight lines in an image and where they meet: what the extractors of line intersections share.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "features/observation.h"
#include "pose/line_observation.h"
#include "scenes/target/feature_shape.h"

namespace sightline {

/// The least-squares line (orthogonal distances) through two or more edge pixels, each of which
/// errs by the scatter about it, or by `least_sd_px` if that is more.
ImageLine fit_line(std::vector<Eigen::Vector2d> edge_pixels, double least_sd_px);

/// Of those pixels the ones within `distance_px` of the line.
std::vector<Eigen::Vector2d> pixels_near(const std::vector<Eigen::Vector2d>& pixels,
                                         const Eigen::Vector2d& point,
                                         const Eigen::Vector2d& normal, double distance_px);

/// The stretch of a line, px along its direction from its point.
struct Stretch {
  double from_px = 0;
  double to_px = 0;

  double half_length_px() const { return (to_px - from_px) / 2; }
};

/// Where along a line its edge pixels lie; of no length where it has none.
Stretch seen_stretch(const ImageLine& line);

/// The place on a line amid its edge pixels.
Eigen::Vector2d seen_middle(const ImageLine& line);

/// Adds noise of that standard deviation, independent at either end of its edge pixels, to what is
/// known of a line.
void add_noise_at_ends(double sd_px, ImageLine& line);

/// A line along one of a feature's edges, as solvers take it.
LineObservation line_observation(const EdgeLine& found, const TargetFeature& feature);

/// The variance of a line's offset along its normal, abreast of a pixel.
double offset_variance_px2(const ImageLine& line, const Eigen::Vector2d& pixel);

/// What a line says that the offset at a pixel, abreast of which it is taken, does not: its offset
/// at the place along it where the two err independently. None where that is farther from the
/// line's point than `most_px`: the slope is hardly known then.
std::optional<ImageLine> beyond_offset_at(const ImageLine& line, const Eigen::Vector2d& pixel,
                                          double most_px);

/// True where the pixel lies in the window.
bool contains(const cv::Rect& window, const Eigen::Vector2d& pixel);

/// Where lines meet.
struct Meeting {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;
  double squares = 0;  ///< of the lines' distances from it, each in its own sigmas; 0 for two lines
};

/// The point of least squares of two or more lines, each weighed by its variance abreast of it;
/// none where no two of them are `min_angle_deg` apart.
std::optional<Meeting> meeting_of(std::span<const ImageLine> lines, double min_angle_deg);

/// The observation with these lines as its own, found where they meet and with the covariance that
/// theirs give. Where they do not meet its status says why: fewer than two lines, no two of them
/// `min_angle_deg` apart, or the meeting outside the observation's window.
Observation found_at_meeting(Observation observation, std::vector<ImageLine> lines,
                             double min_angle_deg);

/// The least of the lines' contrasts, grey levels; infinite where there are none.
double weakest_contrast_grey(std::span<const ImageLine> lines);

}  // namespace sightline
