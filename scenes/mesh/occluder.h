// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// Says what a mesh hides from an eye (CGAL's AABB tree; the mesh may be an open triangle soup).
/// The tree is built when it is first asked, by whichever thread that is.
class Occluder {
 public:
  explicit Occluder(const Mesh& mesh);

  /// True when the mesh blocks the line from the eye to the point, both in the target's frame. The
  /// line stops `clearance_m` short of the point, so that the surface it lies on does not count. A
  /// triangle with one side blocks what looks at its front.
  bool hides(const Eigen::Vector3d& point_m, const Eigen::Vector3d& eye_m,
             double clearance_m) const;

  /// True when a point of the mesh's own surface is not seen from the eye: the mesh blocks the line
  /// to it, or is not drawn there, as all of it within `clearance_m` of the point (at least the
  /// triangles nearest to it) has one side and is seen from behind.
  bool hides_own(const Eigen::Vector3d& point_m, const Eigen::Vector3d& eye_m,
                 double clearance_m) const;

  /// The distance from a point to the mesh's nearest triangle, metres.
  double distance_m(const Eigen::Vector3d& point_m) const;

 private:
  struct Tree;
  std::shared_ptr<Tree> tree_;
};

}  // namespace sightline
