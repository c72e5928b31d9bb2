// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "eval/report/report.h"
#include "pose/pose.h"
#include "renderer/renderer.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// The silhouette of the scene's target in another pose, traced to a quarter of a pixel: its outer
/// borders as closed polygons in pixel coordinates of the scene's camera. Empty where the target
/// cannot be imaged in that pose.
Outline target_outline(Renderer& renderer, const Scene& scene, const Pose& cam_from_target);

/// The same of a mesh alone, in whatever unit both have; empty where it is not wholly in front of
/// the camera.
Outline mesh_outline(const Mesh& mesh, const Camera& camera, const Pose& cam_from_mesh);

/// The camera that sees the same with `factor` pixels for each: its pixels are the parts of the
/// coarse ones. It has the same lens: a distortion stays.
Camera finer(const Camera& camera, int factor);

}  // namespace sightline
