// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "eval/image_sets/set_plan.h"
#include "eval/work/shard.h"

namespace sightline {

struct SetOptions {
  std::filesystem::path out;
  int jobs = 1;
  Shard shard;
  bool is_resumed = false;  ///< continue what is there
  bool show_progress = true;
};

struct SetResult {
  int64_t images = 0;       ///< of this shard
  int64_t resumed = 0;      ///< of them, what was there when this run began
  int64_t failed = 0;       ///< of the set, as far as it is joined: scenes that cannot be imaged
  bool is_complete = true;  ///< false: other shards have yet to do theirs
};

/// Renders the images of a shard into the set's folder, in `jobs` processes, and, where that makes
/// the set complete, joins it: whoever does the last image writes the files that tell of several.
/// Every file is written whole or not at all, and an image counts once its truth is there, which is
/// written last; so a run that was killed is continued without loss. What lies in the folder at the
/// end depends on the plan alone. Throws InputError when the folder cannot be written, holds
/// something else, another set, or images of this shard of a run that is not continued, or is
/// being written by another run.
SetResult render_set(const SetPlan& plan, const SetOptions& options);

}  // namespace sightline
