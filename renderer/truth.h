// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "renderer/frame.h"
#include "renderer/shading.h"
#include "renderer/texture.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// The bodies of a scene, its main target first. `cam_from_target` is that one's pose, which in
/// motion is not the scene's.
std::vector<PlacedBody> placed_bodies(const Scene& scene, const Pose& cam_from_target);

/// Index of the body that an id (not 0) belongs to.
size_t body_of(const std::vector<PlacedBody>& bodies, uint32_t id);

/// Depth, ids and the truth of every body, at mid-exposure. Ids are those of the pixels' centres,
/// found in double precision; a depth is where the centre's ray meets the triangle of its id.
/// Fills all of the frame but its image. Which surface a pixel sees where some are see-through, the
/// scene's colouring says; their textures are kept in `textures`.
void state_truth(const Scene& scene, TextureCache& textures, Frame& frame);

/// What the centre of each pixel sees of the surfaces, at mid-exposure; zeros of background. The
/// surface is the one that state_truth tells of. CV_64FC3.
struct SurfaceMaps {
  /// Unit vectors in the camera's axes, as the light sees them: between the mesh's normals at the
  /// corners, and of the side that is seen.
  cv::Mat normals;
  cv::Mat positions_m;  ///< in the frame of the body that is seen
};
SurfaceMaps surface_maps(const Scene& scene);

/// Part ids (CV_16U, index plus one) of the main target as if it were alone.
cv::Mat part_ids_alone(const Scene& scene);

/// Depth (CV_64F, z, in the mesh's unit) of what each pixel's centre sees of a mesh alone; 0 where
/// that is nothing.
cv::Mat depth_alone(const Mesh& mesh, const Camera& camera, const Pose& cam_from_mesh);

}  // namespace sightline
