// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "renderer/frame.h"
#include "renderer/gl_context.h"
#include "scenes/scene/scene.h"

namespace sightline {

struct RendererOptions {
  /// Who finds what the image's samples see: our own rasteriser, or OpenGL.
  GlChoice gl = GlChoice::kNone;
};

/// What drawing cost, milliseconds, summed over all frames of a renderer.
struct DrawTimes {
  double draw_ms = 0;      ///< projecting the bodies, and finding what each sample sees
  double readback_ms = 0;  ///< of OpenGL: fetching it
  double resolve_ms = 0;   ///< shading it, and adding up each pixel's samples
  double truth_ms = 0;     ///< depth, ids and the truth of bodies and features
};

/// Draws scenes on the processor: no display, no GPU.
///
/// The image is linear (never gamma-encoded: that would move edges) and box-filtered: each pixel is
/// the mean of its samples (sample_pattern), where nothing is of its background. A surface that
/// only turns is shaded once a pixel, at the sample nearest to the pixel's centre; stripes, shadows
/// and highlights at every sample, and so are textures, filtered (colour_resolver.h). The grey
/// image of a picture in colour is made of its stored numbers, as OpenCV does. Depth, ids and all
/// other truth are those of the pixels' centres and never depend on how the image is drawn. One
/// renderer belongs to one thread.
class Renderer {
 public:
  /// Throws GraphicsError when OpenGL is asked for and there is no context to be had.
  explicit Renderer(const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// A frame as the sensor gives it; `noise` is the stream of the sensor's noise.
  /// Throws InputError when the scene cannot be imaged (why_not_imageable).
  Frame render(const Scene& scene, RandomStream noise);

  /// The light on the focal plane before the sensor: CV_32F, of a scene in colour CV_32FC3 (blue,
  /// green, red), 1 is white. Each sample is clipped at
  /// white, as if the highlights were saturated before the blur. A moving target is the mean of its
  /// images along the way.
  cv::Mat render_linear(const Scene& scene);

  /// The main target's part ids (CV_16U) as if it were alone, for its outline under any pose.
  cv::Mat render_part_ids(const Scene& scene);

  /// Who draws, for a manifest: "own rasteriser", or context, driver and version.
  std::string description() const;

  const DrawTimes& times() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline
