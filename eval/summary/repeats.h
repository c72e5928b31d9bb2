// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <unordered_set>

#include "eval/records/records.h"

namespace sightline {

/// Counts the trials of a cell that are an earlier one of it again: the same poses, errors and
/// pixels to the last bit. Its memory does not grow beyond ErrorStatistics::kMostValuesKept trials.
class Repeats {
 public:
  void add(const TrialRecord& trial);
  int count() const { return count_; }

 private:
  std::unordered_set<uint64_t> seen_;
  int count_ = 0;
};

}  // namespace sightline
