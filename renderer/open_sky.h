// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Ambient occlusion: how much of an even sky reaches a surface.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "renderer/placed_body.h"
#include "renderer/shadow_map.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// What bodies leave open of the sky about one of them. 256 directions, spread evenly over the
/// sphere (Fibonacci's lattice, as in J. Hannay and J. Nye, 2004), have a shadow map each: 64 MB in
/// all where a side has kTexels.
class OpenSky {
 public:
  static constexpr int kDirections = 256;
  static constexpr int kTexels = 256;

  OpenSky(const std::vector<PlacedBody>& bodies, size_t receiver, int texels = kTexels);

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

/// The open sky about one of some bodies, made when a share of it is first asked for: a body that
/// no pixel shows takes neither time nor memory.
class BodySky {
 public:
  /// The bodies' meshes must outlive it.
  BodySky(std::shared_ptr<const std::vector<PlacedBody>> bodies, size_t receiver, int texels);

  /// As OpenSky has it.
  double share(const Eigen::Vector3d& x, const Eigen::Vector3d& facet,
               const Eigen::Vector3d& normal);

 private:
  std::shared_ptr<const std::vector<PlacedBody>> bodies_;
  size_t receiver_;
  int texels_;
  std::optional<OpenSky> sky_;
};

/// The skies of the last scene's bodies, kept while the bodies stand to each other as they did: of
/// a target alone, from frame to frame. They depend on the scene alone, not on those before it.
class SkyMemory {
 public:
  /// Of more bodies each has fewer texels, so that all take no more than this many do: 256 MB.
  static constexpr int kWholeBodies = 4;

  /// From now on the skies are those of this scene, as its bodies stand in the middle of its
  /// exposure.
  void turn_to(const Scene& scene);

  /// Of a body by its place in placed_bodies(); none where the scene's glow reaches everywhere. It
  /// holds until the next scene.
  BodySky* of(size_t body) { return skies_.empty() ? nullptr : &skies_[body]; }

 private:
  std::vector<std::shared_ptr<const Target>> targets_;  // held for their meshes
  std::vector<Pose> first_from_body_;
  std::vector<BodySky> skies_;  // a body each
};

}  // namespace sightline
