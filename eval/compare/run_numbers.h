// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/compare/measures.h"
#include "eval/records/records.h"

namespace sightline {

/// What one trial adds to a number: an error or a flag stands over a whole of one.
struct Share {
  double part = 0;
  double whole = 1;
};

/// A number of a run's trials, and where it comes from: one of the three.
struct RunNumber : TrialNumber {
  std::function<Share(const TrialRecord&, const EstimateRecord&)> of_estimate{};
  std::function<Share(const OrientationRecord&)> of_orientation{};
  std::function<Share(const TrialRecord&)> of_features{};
};

/// All of them, the errors in the order of quantities(). To add one: an entry here.
const std::vector<RunNumber>& run_numbers();

}  // namespace sightline
