// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/report/report.h"
#include "eval/study/study.h"
#include "renderer/renderer.h"

namespace sightline {

/// A trial that the report shows, and why.
struct FrameChoice {
  int64_t trial = 0;
  std::string caption;
};

/// A report's pictures: this many, fewer of images above four megapixels, which take long to draw
/// again.
constexpr size_t kMostFrames = 60;

/// Trials that show a study, each once, with all its reasons, what matters most first: the first
/// draw of each condition (of four at most), the median and the worst poses, the first of each kind
/// of success and failure, of every solver that needs no truth and of the features; and random
/// ones, as far as there is room. At most `limit`.
std::vector<FrameChoice> choose_frames(const Study& study, std::span<const TrialRecord> trials,
                                       size_t limit = kMostFrames);

/// Runs the chosen trials again (they depend on nothing but the study and their number) and traces
/// the target's outline in the pose of each solver that found one. On another machine or with
/// another version of the program the re-run may differ from the stored trial: the caption says so.
/// Of
/// a study that asks processes the frames are made anew, but the answers are those recorded: a
/// folder that came from elsewhere names commands, which reading it must not run. Ends early when
/// the pictures would make a page too large to open at once.
std::vector<FrameEvidence> gather_evidence(const Study& study, std::span<const TrialRecord> trials,
                                           Renderer& renderer);

}  // namespace sightline
