// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "eval/work/shard.h"
#include "eval/work/workers.h"

namespace sightline {

/// The work of a shard, as a number of processes share it.
struct ShardWork {
  std::string label;  ///< of the progress bar
  Shard shard;
  int64_t to_do = 0;  ///< steps that are left
  int jobs = 1;       ///< at most one a step is started
  bool show_progress = true;

  /// The processes that will be at work.
  int processes() const;
};

/// How many of the indices 0 to count - 1 a shard has.
int64_t size_of(const Shard& shard, int64_t count);

/// Runs `work(job, share, tick)` for the share of each process, in this one if it is the only one,
/// and shows their ticks as progress. Throws as run_in_processes.
void run_shares(const ShardWork& shard_work,
                const std::function<void(int job, const Shard& share, const Tick& tick)>& work);

}  // namespace sightline
