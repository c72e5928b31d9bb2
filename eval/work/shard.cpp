// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/shard.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct Engine {
  const char* name;
  const char* index;
  const char* count;      // null: the engine tells none
  const char* min_index;  // subtracted from the index; null: 0
};

constexpr std::array kEngines = {
    Engine{"Open MPI", "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", nullptr},
    Engine{"PMI", "PMI_RANK", "PMI_SIZE", nullptr},
    Engine{"Slurm array", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN"},
    Engine{"Slurm step", "SLURM_PROCID", "SLURM_STEP_NUM_TASKS", nullptr},
    Engine{"Kubernetes indexed Job", "JOB_COMPLETION_INDEX", nullptr, nullptr},
};

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<int> variable(const Environment& environment, const char* name) {
  const char* value = name == nullptr ? nullptr : environment(name);
  return value == nullptr ? std::nullopt : whole_number(value);
}

ShardChoice checked(const std::string& text, const std::string& source, int index, int count) {
  if (count < 1 || index < 0 || index >= count) {
    throw InputError(fmt::format("--shard {}: shard {} of {} ({}) must have 0 <= I < N", text,
                                 index, count, source));
  }
  return {{index, count}, source};
}

ShardChoice from_engine(const std::string& text, std::optional<int> given_count,
                        const Environment& environment) {
  for (const Engine& engine : kEngines) {
    const std::optional<int> index = variable(environment, engine.index);
    if (!index) continue;
    const std::optional<int> count =
        given_count ? given_count : variable(environment, engine.count);
    if (!count) {
      throw InputError(
          fmt::format("--shard {}: {} tells no count; give --shard auto/N", text, engine.name));
    }
    const int first = variable(environment, engine.min_index).value_or(0);
    return checked(text, engine.name, *index - first, *count);
  }
  throw InputError(fmt::format(
      "--shard {}: no engine has set its variables (Open MPI, PMI, Slurm, Kubernetes); give I/N",
      text));
}

}  // namespace

ShardChoice read_shard(const std::string& text, const Environment& environment) {
  const size_t slash = text.find('/');
  const std::string_view before = std::string_view(text).substr(0, slash);
  std::optional<int> count;
  if (slash != std::string::npos) {
    count = whole_number(std::string_view(text).substr(slash + 1));
    if (!count) throw InputError(fmt::format("--shard {}: N must be a whole number", text));
  }
  if (before == "auto") return from_engine(text, count, environment);
  const std::optional<int> index = whole_number(before);
  if (!index || !count) {
    throw InputError(fmt::format("--shard {}: must read I/N, auto or auto/N", text));
  }
  return checked(text, "given", *index, *count);
}

Shard chosen_shard(const std::string& option, bool is_told) {
  if (option.empty()) return {};
  const auto [shard, source] =
      read_shard(option, [](const char* name) { return std::getenv(name); });
  if (is_told) fmt::print(stderr, "shard {} of {} ({})\n", shard.index, shard.count, source);
  return shard;
}

}  // namespace sightline
