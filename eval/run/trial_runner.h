// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

#include "eval/datasets/set_frame.h"
#include "eval/records/records.h"
#include "eval/study/study.h"
#include "renderer/renderer.h"

namespace sightline {

/// Runs trials of any kind of study. Only images need a renderer. One is made in the process that
/// uses it: graphics libraries do not survive a fork.
class TrialRunner {
 public:
  /// The study must outlive it.
  TrialRunner(const Study& study, const RendererOptions& renderer);

  /// Trial number `index` of the study with its own seed.
  TrialRecord run(int64_t index) { return run(index, study_.seed); }
  /// The same with another.
  TrialRecord run(int64_t index, uint64_t seed);

 private:
  const Study& study_;
  std::optional<Renderer> renderer_;
  SetFiles files_;  // of a data set, what was read last
};

}  // namespace sightline
