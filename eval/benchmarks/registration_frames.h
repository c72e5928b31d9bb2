// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Frames with a known pose to lay a mesh on: rendered, and photographs where there are any.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "features/prediction.h"
#include "scenes/mesh/mesh.h"
#include "scenes/scene/prior.h"

namespace sightline {

struct ShownFrame {
  Camera camera;
  cv::Mat image;  ///< CV_8U
  Pose cam_from_target;
};

/// A target and frames of it.
struct FramedTarget {
  std::string name;
  Mesh mesh;
  PriorError prior;
  bool is_photographed = false;
  std::vector<ShownFrame> frames = {};
};

/// Frames of boeing-random ("boeing707") or feature-localisation ("cube"), 512 x 512.
FramedTarget rendered_frames(const std::string& target, int count);

/// The sets in BOP's layout that are in the folder which SIGHTLINE_TEST_REAL names, in the order of
/// their names; none where it names none. Throws InputError for a set that cannot be read.
std::vector<FramedTarget> photographs();

/// One of the priors of a target's frame.
PosePrior drawn_prior(const FramedTarget& target, size_t frame, uint64_t seed);

}  // namespace sightline
