// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/shares.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/work/progress.h"

namespace sightline {

int ShardWork::processes() const {
  return static_cast<int>(std::clamp<int64_t>(to_do, 1, jobs));
}

int64_t size_of(const Shard& shard, int64_t count) {
  return shard.index >= count ? 0 : (count - shard.index + shard.count - 1) / shard.count;
}

void run_shares(const ShardWork& shard_work,
                const std::function<void(int job, const Shard& share, const Tick& tick)>& work) {
  const Shard& shard = shard_work.shard;
  const int processes = shard_work.processes();
  const std::string label = processes == 1
                                ? shard_work.label
                                : fmt::format("{}, {} processes", shard_work.label, processes);
  Progress progress(label, shard_work.to_do, shard_work.show_progress);
  if (processes == 1) {
    work(0, shard, [&progress] { progress.advance(1); });
    return;
  }
  const auto work_of = [&](int job, const Tick& tick) {
    work(job, {shard.index + shard.count * job, shard.count * processes}, tick);
  };
  run_in_processes(processes, work_of, [&progress](int64_t n) { progress.advance(n); });
}

}  // namespace sightline
