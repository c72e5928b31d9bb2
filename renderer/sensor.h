// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <opencv2/core/mat.hpp>

#include "scenes/random/random.h"
#include "scenes/scene/sensor.h"

namespace sightline {

/// What the sensor makes of the light on the focal plane (CV_32F, 1 is white): vignetting, Gaussian
/// point spread, photon noise (Gaussian of the Poisson's variance), read noise, gain, sRGB encoding
/// where asked for, rounding to 2^bits - 1 steps, clipping, dead and hot pixels. CV_8U up to 8
/// bits, else CV_16U. Noise is drawn row by row from the stream; which pixels are dead or hot
/// depends on `defect_seed` and the image's size alone, and a larger dead_fraction adds to the dead
/// of a smaller one. Of light in colour (CV_32FC3) each channel goes through a sensor of its own,
/// which reads what `response` says of red, green and blue light behind the lens, with the defects
/// of the others, and gain times its white balance. JPEG is left
/// to the renderer, which keeps its file.
cv::Mat expose(const cv::Mat& linear, const Sensor& sensor, RandomStream noise);

/// The same of light in colour on a mosaic of photosites, the top-left four red, green, green and
/// blue: each photosite has noise and defects of its own, and what a pixel lacks is interpolated
/// bilinearly from its neighbours' numbers; only then sRGB encodes, where asked for. Three
/// channels.
cv::Mat expose_mosaic(const cv::Mat& linear, const Sensor& sensor, RandomStream noise);

}  // namespace sightline
