// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "renderer/renderer.h"

namespace sightline {

/// A renderer for many scenes. One keeps every texture that it has drawn; where scenes draw theirs
/// from a folder, another takes its place now and then, so that memory does not grow with them.
class RenewedRenderer {
 public:
  explicit RenewedRenderer(const RendererOptions& options) : options_(options), own_(options) {}

  Renderer& get() { return own_; }

  /// To be told of each scene once it has been rendered.
  void count(const Scene& scene) {
    constexpr int kMostTextures = 32;  // 4 MB each
    for (const DrawnMaterial& drawn : scene.materials) textures_ += drawn.texture.empty() ? 0 : 1;
    if (textures_ <= kMostTextures) return;
    own_ = Renderer(options_);
    textures_ = 0;
  }

 private:
  RendererOptions options_;
  Renderer own_;
  int textures_ = 0;
};

}  // namespace sightline
