// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "eval/study.h"
#include "scenes/random.h"

namespace sightline {

/// The pose of an attitude (pitch, yaw, roll) in degrees and a translation in metres.
Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m);

/// cam_from_target drawn from the ranges of a law.
Pose drawn_pose(const PoseLaw& law, RandomStream& stream);

}  // namespace sightline
