// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "renderer/frame.h"
#include "scenes/scene.h"

namespace sightline {

/// Draws scenes with OpenGL 4.5 core in software (OSMesa): no display, no GPU.
/// The image is linear (never gamma-encoded: that would move edges), box-filtered from a square
/// grid of samples; depth and part ids come from their own pass through the pixel centres. The
/// camera must be free of lens distortion. One renderer belongs to one thread; use processes for
/// speed.
class Renderer {
 public:
  /// Throws GraphicsError when there is no context to be had.
  Renderer();
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// A frame as the sensor gives it; `noise` is the stream of the sensor's noise.
  /// Throws InputError when the scene cannot be imaged (why_not_imageable).
  Frame render(const Scene& scene, RandomStream noise);

  /// The light on the focal plane before the sensor: CV_32F, 1 is white. Each sample is clipped at
  /// white, as if the highlights were saturated before the blur.
  cv::Mat render_linear(const Scene& scene);

  /// The part ids alone (CV_16U), for outlines of the target under any pose.
  cv::Mat render_part_ids(const Scene& scene);

  /// Driver and version, for a manifest: "Mesa ... llvmpipe ...".
  std::string description() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline
