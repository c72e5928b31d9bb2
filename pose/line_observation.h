// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sightline {

/// A straight edge of the target and the line in the image on which the camera saw it. Where on
/// that line the ends of the edge lie need not be known, nor which way along it the edge runs.
struct LineObservation {
  /// Two different points of the edge, metres.
  Eigen::Vector3d begin_in_target = Eigen::Vector3d::Zero();
  Eigen::Vector3d end_in_target = Eigen::Vector3d::UnitX();
  /// A pixel on the line, amid the edge pixels that it was found by, and a vector along it. Through
  /// a lens a straight edge is seen as a curve: then the line is the one that touches it there.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  /// Of the line's offset along its normal at `pixel` (px) and of its slope there (rad); the normal
  /// is the direction turned by a right angle, (-y, x). A slope of infinite variance, uncorrelated,
  /// is not known: the line then passes by the pixel, in any direction.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};

/// The line through two pixels, each of which is known across the line with standard deviation
/// `sigma_px`; its edge is still to be said. The pixels must differ.
LineObservation line_through(const Eigen::Vector2d& begin_px, const Eigen::Vector2d& end_px,
                             double sigma_px);

/// The covariance of offset and slope of a line that is fitted, about the middle of a stretch of
/// it, to edge pixels spread evenly along that stretch: so many and so long that the sums are
/// integrals.
Eigen::Matrix2d covariance_of_edge_pixels(double length_px, double pixels_per_px, double sigma_px);

/// Whether a line can be used: its numbers are finite, and not so large that products of them are
/// not, the edge has a length, the direction is not
/// zero, and the covariance is that of noise.
bool is_usable(const LineObservation& line);

}  // namespace sightline
