// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "eval/doors/observation_file.h"
#include "pose/camera.h"

namespace sightline {

/// A pixel as ours, its centre at integers, from one that is counted otherwise.
Eigen::Vector2d pixel_of(const Eigen::Vector2d& given, PixelOrigin origin, const Camera& camera);

/// read_observations of COCO's keypoint results.
GivenObservations read_coco_results(const ObservationSource& source, const ShownPictures& pictures);

}  // namespace sightline
