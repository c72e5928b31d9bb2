// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "eval/image_sets/set_plan.h"
#include "eval/output/json.h"

namespace sightline {

/// What a set will take, from a few of its images made in memory.
struct SetEstimate {
  int sampled = 0;  ///< images that were made; of none the rest says nothing
  int jobs = 1;
  double render_ms = 0;  ///< these four are of an image
  double encode_ms = 0;
  double image_files = 0;
  double image_bytes = 0;
  double seconds = 0;  ///< these four of all, on a processor for each job
  double files = 0;
  double bytes = 0;
  double disk_bytes = 0;             ///< whole blocks
  std::optional<double> free_bytes;  ///< where the set would lie; none where nobody says
};

/// `out` is where the set would lie.
SetEstimate estimate_set(const SetPlan& plan, int jobs, const std::filesystem::path& out);

/// The estimate in words, and as JSON.
std::string text_of(const SetEstimate& estimate, const SetPlan& plan);
Json json_of(const SetEstimate& estimate, const SetPlan& plan);

/// What a user of this plan should know before it is rendered, a line each; empty when nothing.
std::string warnings_of(const SetPlan& plan);

}  // namespace sightline
