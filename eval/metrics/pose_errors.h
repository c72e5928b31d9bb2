// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How far an estimated pose is from the true one: the errors of the BOP challenge over the vertices
// of a model, as it defines them (Hodan et al., "BOP: Benchmark for 6D Object Pose Estimation",
// ECCV 2018; "BOP Challenge 2020", ECCVW 2020, section 2.2), and those of other benchmarks. All
// poses are cam_from_model. Distances are in the unit in which vertices and translations come, or
// in pixels.
#pragma once

#include <span>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// Vertices of a model, a column each.
using Vertices = Eigen::Ref<const Eigen::Matrix3Xd>;

/// Those of a mesh, where it has them: it must outlive what is returned.
Eigen::Map<const Eigen::Matrix3Xd> vertices_of(const Mesh& mesh);

/// ADD: the mean distance of a vertex in the two poses (Hinterstoisser et al., ACCV 2012).
double add_distance(const Vertices& vertices, const Pose& estimated, const Pose& truth);

/// ADI, also called ADD-S: the mean distance of a vertex in the true pose from the nearest one in
/// the estimated pose, for symmetric objects (ibid.).
double adi_distance(const Vertices& vertices, const Pose& estimated, const Pose& truth);

/// MSSD, the maximum symmetry-aware surface distance, of an object without symmetries: the greatest
/// distance of a vertex in the two poses.
double mssd(const Vertices& vertices, const Pose& estimated, const Pose& truth);

/// The true pose at the symmetry of the model at which MSSD is least: MSSD is that against it.
Pose nearest_alike(const Vertices& vertices, const Pose& estimated, const Pose& truth,
                   std::span<const Pose> symmetries);

/// MSPD, the maximum symmetry-aware projection distance: the same of the vertices' pixels under the
/// camera matrix `k`, at the symmetry at which that is least. Points behind the camera are
/// projected like others, as the challenge does it; infinite where one is in its plane.
double mspd_px(const Vertices& vertices, const Eigen::Matrix3d& k, const Pose& estimated,
               const Pose& truth, std::span<const Pose> symmetries);

/// ADD, MSSD and MSPD of an object without symmetries, seen through a camera with its lens: MSPD is
/// infinite where a vertex is at or behind the camera's plane, but takes none of those that are so
/// in the true pose: of a body that reaches behind the camera, only what is in front is compared.
struct VertexErrors {
  double add = 0;
  double mssd = 0;
  double mspd_px = 0;
};

VertexErrors vertex_errors(const Vertices& vertices, const Camera& camera, const Pose& estimated,
                           const Pose& truth);

/// The least greatest distance of a vertex's pixels, as VertexErrors has it, over the true poses at
/// all symmetries.
double least_mspd_px(const Vertices& vertices, const Camera& camera, const Pose& estimated,
                     const Pose& truth, std::span<const Pose> symmetries);

/// The pose, turned about a line of its object by the angle at which its rotation is nearest to the
/// estimated one: with M = estimated^T pose, the trace of M Rot(phi) is greatest.
Pose turned_towards(const Pose& estimated, const Pose& pose, const Eigen::Vector3d& direction,
                    const Eigen::Vector3d& point);

/// Mean distance of the vertices' pixels (Brachmann et al., CVPR 2016: "2D projection", good below
/// 5 px). MSPD is the greatest instead.
double projection_px(const Vertices& vertices, const Eigen::Matrix3d& k, const Pose& estimated,
                     const Pose& truth);

/// Whether the attitude errs by less than 5 degrees and the position by less than 5 cm, of poses in
/// millimetres (Shotton et al., CVPR 2013).
bool is_within_5deg_5cm(const Pose& estimated, const Pose& truth);

/// The score of ESA's Pose Estimation Challenge (Kisantal et al., "Satellite Pose Estimation
/// Challenge", IEEE TAES 2020): the geodesic angle in radians plus the distance of the positions
/// over the true one's length.
double speed_score(const Pose& estimated, const Pose& truth);

/// The same of the challenge of 2021, SPEED+: an angle below 0.169 degrees and a distance below
/// 2.173 parts in a thousand count as zero, each for itself: what its hardware is calibrated to
/// (Park et al., "SPEED+", 2022).
double speed_plus_score(const Pose& estimated, const Pose& truth);

}  // namespace sightline
