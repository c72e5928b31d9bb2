// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "eval/records/records.h"
#include "eval/study/label_limits.h"
#include "features/observation.h"
#include "pose/camera.h"
#include "scenes/target/target.h"

namespace sightline {

/// The lines along edges that extractors found, each against the true image of its edge: how far
/// that passes the line's pixel, and what offset and slope err by in units of the line's own
/// covariance. A line is wrong beyond `limits.line_px` or `limits.outlier_sigmas`, or where its
/// edge is not seen across it at all.
std::vector<LineRecord> compare_lines(std::span<const Observation> observations,
                                      const Target& target, const Camera& camera,
                                      const Pose& true_cam_from_target, const LabelLimits& limits);

}  // namespace sightline
