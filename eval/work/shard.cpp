// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/shard.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
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
  const char* max_index;  // null: the engine tells none
};

constexpr std::array kEngines = {
    Engine{"Open MPI", "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", nullptr, nullptr},
    Engine{"PMI", "PMI_RANK", "PMI_SIZE", nullptr, nullptr},
    Engine{"Slurm array", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN",
           "SLURM_ARRAY_TASK_MAX"},
    Engine{"Slurm step", "SLURM_PROCID", "SLURM_STEP_NUM_TASKS", nullptr, nullptr},
    Engine{"Kubernetes indexed Job", "JOB_COMPLETION_INDEX", nullptr, nullptr, nullptr},
};

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<int> variable(const ProcessVariables& environment, const char* name) {
  const char* value = name == nullptr ? nullptr : environment(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  const std::optional<int> number = whole_number(value);
  if (number) return number;
  throw InputError(
      fmt::format("--shard: {} is '{}', must be a whole number below 2^31", name, value));
}

ShardChoice checked(const std::string& text, const std::string& source, int64_t index,
                    int64_t count) {
  if (count < 1 || index < 0 || index >= count) {
    throw InputError(fmt::format("--shard {}: shard {} of {} ({}) must have 0 <= I < N", text,
                                 index, count, source));
  }
  return {{index, count}, source};
}

// The ids of an array name its shards only where it has them all. One with gaps (--array=1,3,5),
// and a part of one that is submitted again (--array=2), has its tasks' ids, but not which N they
// were of: to count them from 0 would do other trials than before.
void require_whole_array(const std::string& text, const Engine& engine,
                         std::optional<int> given_count, const ProcessVariables& environment) {
  const std::optional<int> last = variable(environment, engine.max_index);
  const std::optional<int> tasks = variable(environment, engine.count);
  if (!last || !tasks) return;
  const int first = variable(environment, engine.min_index).value_or(0);
  const bool has_gaps = int64_t{*last} - first + 1 != *tasks;
  const bool may_be_part = *tasks == 1 && first > 0;
  const bool is_part = given_count && *given_count != *tasks;
  if (!has_gaps && !may_be_part && !is_part) return;
  throw InputError(fmt::format(
      "--shard {}: the {} has {} of the ids {} to {}, which do not say which shards they are; give "
      "I/N with the N of the whole array, such as --shard ${{SLURM_ARRAY_TASK_ID}}/N where its ids "
      "are 0 to N - 1",
      text, engine.name, *tasks, first, *last));
}

ShardChoice from_engine(const std::string& text, std::optional<int> given_count,
                        const ProcessVariables& environment) {
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
    require_whole_array(text, engine, given_count, environment);
    return checked(text, engine.name, int64_t{*index} - first, *count);
  }
  throw InputError(fmt::format(
      "--shard {}: no engine has set its variables (Open MPI, PMI, Slurm, Kubernetes); give I/N",
      text));
}

}  // namespace

ShardChoice read_shard(const std::string& text, const ProcessVariables& environment) {
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
