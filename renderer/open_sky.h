// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ambient occlusion: how much of an even sky reaches a surface.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "renderer/placed_body.h"
#include "renderer/shadow_map.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// What bodies leave open of the sky about one of them. 256 directions, spread evenly over the
/// sphere (Fibonacci's lattice, as in J. Hannay and J. Nye, 2004), have a shadow map each: 256
/// texels a side and 64 MB in all at most.
class OpenSky {
 public:
  static constexpr int kDirections = 256;
  static constexpr int kTexels = 256;

  OpenSky(const std::vector<PlacedBody>& bodies, size_t receiver);

  /// The share, from 0 to 1, of the directions above a surface that nothing hides, weighed by their
  /// cosines to its normal. `x` and `facet`, the normal of its triangle on the side that is seen,
  /// are in the receiver's frame, as `normal` is, by which it is lit; both of any length.
  /// Directions below the triangle count neither way. What rises from it by less than some two
  /// texels hides nothing.
  double share(const Eigen::Vector3d& x, const Eigen::Vector3d& facet,
               const Eigen::Vector3d& normal) const;

 private:
  std::vector<Eigen::Vector3d> directions_;  // receiver's frame
  std::vector<ShadowMap> maps_;
};

/// The skies of the last scene's bodies, kept while the bodies stand to each other as they did: of
/// a target alone, from frame to frame. They are made when they are first asked for.
class SkyMemory {
 public:
  /// None where the scene's glow reaches everywhere.
  std::shared_ptr<const OpenSky> of(const Scene& scene, const std::vector<PlacedBody>& bodies,
                                    size_t body);

 private:
  std::vector<std::shared_ptr<const Target>> targets_;  // held, so that no other has their place
  std::vector<Pose> first_from_body_;
  std::vector<std::shared_ptr<const OpenSky>> skies_;  // a body each
};

}  // namespace sightline
