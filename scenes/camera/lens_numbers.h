// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lenses as files state them: a list of coefficients, whose number says the model where OpenCV
// wrote it.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "pose/camera.h"
#include "pose/lenses/catalogue.h"

namespace sightline {

/// "4 or 5 numbers (k1, k2, p1, p2, k3)": what a model's list may be.
std::string allowed_numbers(const LensModel& model);

/// The lens of that model. Throws InputError, whose text begins with "has", for a number of
/// coefficients that the model has not or one that is not finite.
Lens lens_of(const LensModel& model, std::span<const double> coefficients);

/// The lens of a list as OpenCV's calibration writes it: none is a pinhole, 4 or 5 are Brown and
/// Conrady's, 8 the rational model, 12 that with a thin prism, 14 that on a tilted sensor, which
/// must not be tilted. What is 0 beyond the fifth is left out. Throws InputError as above.
Lens lens_of_opencv(std::span<const double> coefficients);

/// A pixel of the image, of its border or through the principal point, where the lens cannot be
/// undone because its model folds the image over; none of a camera that can be used. A fisheye that
/// sees 90 degrees there or more is no fold: nothing is seen there.
std::optional<Eigen::Vector2d> folded_pixel(const Camera& camera);

/// What is wrong with a camera whose image has such a pixel, in words; empty where it has none.
std::string why_folded(const Camera& camera);

}  // namespace sightline
