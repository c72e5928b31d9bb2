// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "eval/records.h"
#include "eval/report/report.h"
#include "eval/study.h"
#include "renderer/renderer.h"

namespace sightline {

/// A trial that the report shows, and why.
struct FrameChoice {
  int64_t trial = 0;
  std::string caption;
};

/// At most eight trials, each once, with all its reasons. With several conditions: the first draw
/// of each (of four at most) and the worst pose; with one: the first draw, the median and the three
/// worst poses. Then the first in which an outlier was removed, an inlier was removed, and no pose
/// was found. All by the solver that the report is about (lead_solver).
std::vector<FrameChoice> choose_frames(const Study& study, std::span<const TrialRecord> trials);

/// Runs the chosen trials again (they depend on nothing but the study and their number) and traces
/// the target's outline in the pose of each solver that found one. On another machine or with
/// another version of the program the re-run may differ from the stored trial: the caption says so.
std::vector<FrameEvidence> gather_evidence(const Study& study, std::span<const TrialRecord> trials,
                                           Renderer& renderer);

}  // namespace sightline
