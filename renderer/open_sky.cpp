// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/open_sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "renderer/truth.h"

namespace sightline {
namespace {

constexpr int kFewestTexels = 8;  // of a side, those of the border among them

bool are_equal(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].rotation != b[i].rotation || a[i].translation != b[i].translation) return false;
  }
  return true;
}

// Where the bodies stand from the first, which of one alone is the same whatever its pose.
std::vector<Pose> places_of(const std::vector<PlacedBody>& bodies) {
  std::vector<Pose> places(1);
  const Pose first_from_cam = inverse(bodies.front().cam_from_body);
  for (size_t b = 1; b < bodies.size(); ++b) {
    places.push_back(first_from_cam * bodies[b].cam_from_body);
  }
  return places;
}

std::vector<std::shared_ptr<const Target>> targets_of(const Scene& scene) {
  std::vector<std::shared_ptr<const Target>> targets{scene.target};
  for (const OtherBody& other : scene.others) targets.push_back(other.target);
  return targets;
}

}  // namespace

OpenSky::OpenSky(const std::vector<PlacedBody>& bodies, size_t receiver, int texels) {
  constexpr double kAnyFiner = 0;  // the map takes as many texels as it may
  const Eigen::Matrix3d& turn = bodies[receiver].cam_from_body.rotation;
  maps_.reserve(kDirections);
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1) / static_cast<double>(kDirections);
    const double ring = std::sqrt(1 - z * z);
    const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
    directions_.emplace_back(ring * std::cos(angle), ring * std::sin(angle), z);
    maps_.emplace_back(bodies, receiver, turn * directions_.back(), kAnyFiner, texels);
  }
}

double OpenSky::share(const Eigen::Vector3d& x, const Eigen::Vector3d& facet,
                      const Eigen::Vector3d& normal) const {
  // Lifted off its triangle, so that neither the map's rounding nor a neighbour that rises a little
  // hides it.
  constexpr double kLiftTexels = 1.5;
  const Eigen::Vector3d up = facet.stableNormalized();
  double open = 0, all = 0;
  for (size_t i = 0; i < maps_.size(); ++i) {
    const double cosine = normal.dot(directions_[i]);
    if (!(cosine > 0) || !(up.dot(directions_[i]) > 0)) continue;
    all += cosine;
    if (maps_[i].is_lit(x + kLiftTexels * maps_[i].texel_m() * up, up)) open += cosine;
  }
  return all > 0 ? open / all : 1;
}

BodySky::BodySky(std::shared_ptr<const std::vector<PlacedBody>> bodies, size_t receiver, int texels)
    : bodies_(std::move(bodies)), receiver_(receiver), texels_(texels) {}

double BodySky::share(const Eigen::Vector3d& x, const Eigen::Vector3d& facet,
                      const Eigen::Vector3d& normal) {
  if (!sky_) sky_.emplace(*bodies_, receiver_, texels_);
  return sky_->share(x, facet, normal);
}

void SkyMemory::turn_to(const Scene& scene) {
  std::vector<std::shared_ptr<const Target>> targets;
  std::vector<Pose> places;
  std::vector<PlacedBody> bodies;
  if (scene.light.is_glow_occluded) {
    bodies = placed_bodies(scene, scene.cam_from_target);
    targets = targets_of(scene);
    places = places_of(bodies);
  }
  if (targets == targets_ && are_equal(places, first_from_body_)) return;
  skies_.clear();
  targets_ = std::move(targets);
  first_from_body_ = std::move(places);
  // Seen from the first body: where the camera stands must not move the maps' texels.
  for (size_t b = 0; b < bodies.size(); ++b) bodies[b].cam_from_body = first_from_body_[b];
  const auto shared = std::make_shared<const std::vector<PlacedBody>>(std::move(bodies));
  const double part = static_cast<double>(kWholeBodies) / static_cast<double>(shared->size());
  const int texels = static_cast<int>(OpenSky::kTexels * std::sqrt(std::min(1.0, part)));
  for (size_t b = 0; b < shared->size(); ++b) {
    skies_.emplace_back(shared, b, std::max(kFewestTexels, texels));
  }
}

}  // namespace sightline
