// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>

namespace sightline {

/// Called by a worker for each step it has done.
using Tick = std::function<void()>;

/// Runs `work(0, tick)` to `work(count - 1, tick)` in a process each and waits for all; `on_ticks`
/// hears in this process how many steps were done. Rendering does not scale with threads, and a
/// process keeps a crash in one place. Must be called before this process makes a graphics context.
/// The workers end with this process, however it ends.
/// Throws InputError with the worker's text if one throws InputError, std::runtime_error for any
/// other failure or crash of a worker; the others are then ended.
void run_in_processes(int count, const std::function<void(int, const Tick&)>& work,
                      const std::function<void(int64_t)>& on_ticks);

}  // namespace sightline
