// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace sightline {

/// One share of a study's trials: those whose number modulo `count` is `index`.
struct Shard {
  int64_t index = 0;  // 64 bits: a shard of a shard multiplies the counts
  int64_t count = 1;
};

/// The environment's variables that engines set, read through this so that tests can stand in.
using ProcessVariables = std::function<const char*(const char*)>;

struct ShardChoice {
  Shard shard;
  std::string source;  ///< "given", or which engine's variables said so
};

/// Reads "I/N", "auto" or "auto/N". `auto` takes I and N from the engine that started the process:
/// Open MPI, PMI, a Slurm step, a Slurm array, an indexed Kubernetes Job (which has no count:
/// auto/N). Throws InputError for anything else, for I outside 0..N-1, or when no engine has set
/// its variables.
ShardChoice read_shard(const std::string& text, const ProcessVariables& environment);

/// The shard that the option --shard names, with the process's environment; the whole where it is
/// empty. Says on stderr which, and by whose word, if `is_told`.
Shard chosen_shard(const std::string& option, bool is_told);

}  // namespace sightline
