// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "eval/image_sets/set_plan.h"

namespace sightline {

/// What a set will take, from a few of its images made in memory: time by stage, disk, files; in
/// words. `out` is where it would lie.
std::string estimate_set(const SetPlan& plan, int jobs, const std::filesystem::path& out);

/// What a user of this plan should know before it is rendered, a line each; empty when nothing.
std::string warnings_of(const SetPlan& plan);

}  // namespace sightline
