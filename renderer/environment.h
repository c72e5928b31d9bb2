// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A panorama as a light: blurred as dull and glossy surfaces see it, so that one look-up a pixel
// lights them. Without random numbers.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/camera.h"
#include "scenes/scene/environment.h"

namespace sightline {

/// Directions are unit vectors in the panorama's axes (scenes/scene/environment.h); light is red,
/// green, blue and a zero, as the panorama has it. It belongs to one thread.
class EnvironmentLight {
 public:
  explicit EnvironmentLight(std::shared_ptr<const cv::Mat> panorama);

  /// From one direction, as a pixel that spans this angle sees it.
  Eigen::Array4f seen(const Eigen::Vector3d& direction, double pixel_rad) const;

  /// What a white dull surface with this normal sends back: the mean over the directions above it,
  /// weighed by their cosines to it (irradiance over pi). A sum over the panorama at 64 x 32, whose
  /// texels count from their middles.
  Eigen::Array4f dull(const Eigen::Vector3d& normal) const;

  /// What a mirror of this roughness shows in the direction of reflection: the mean over GGX's
  /// microfacets seen along their mean normal and weighed by the light's cosine (B. Karis, Real
  /// shading in Unreal Engine 4, 2013), by 64 fixed directions with filtered look-ups; linear
  /// between roughnesses an eighth apart, each of which is blurred when it is first asked for.
  Eigen::Array4f glossy(const Eigen::Vector3d& direction, double roughness);

  const std::shared_ptr<const cv::Mat>& panorama() const { return panorama_; }

 private:
  static constexpr int kRoughnesses = 8;

  Eigen::Array4f at_level(const Eigen::Vector3d& direction, double level) const;
  cv::Mat dull_map() const;
  cv::Mat mirror_map() const;
  cv::Mat glossy_map(double roughness, cv::Size size) const;
  const cv::Mat& glossy_of(size_t step);

  std::shared_ptr<const cv::Mat> panorama_;
  std::vector<cv::Mat> levels_;  // the panorama, each half as wide as the one before
  cv::Mat dull_;
  std::array<cv::Mat, kRoughnesses + 1> glossy_;  // of roughness 0 to 1; empty: not yet made
};

/// What the camera sees of a scene's environment: CV_32FC3, blue, green, red.
cv::Mat environment_image(const EnvironmentLight& light, const Environment& environment,
                          const Camera& camera);

}  // namespace sightline
