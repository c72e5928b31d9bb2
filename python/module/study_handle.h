// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "eval/study/study.h"
#include "renderer/renderer.h"

namespace sightline {

/// A study or a scene as Python holds it, with what draws its frames: made when first needed, one
/// thread at a time.
struct StudyHandle {
  explicit StudyHandle(Study read) : study(std::move(read)) {}

  /// To be called without Python's lock, for it may wait.
  template <typename Work>
  auto with_renderer(const Work& work) {
    const std::lock_guard lock(mutex);
    if (!renderer) renderer.emplace();
    return work(*renderer);
  }

  const Study study;
  std::mutex mutex;
  std::optional<Renderer> renderer;
};

}  // namespace sightline
