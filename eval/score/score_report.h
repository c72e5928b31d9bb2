// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/report/chart.h"
#include "eval/score/score.h"

namespace sightline {

/// The charts of the page, in its order.
std::vector<Chart> score_charts(const ScoredResults& input);

/// The page: the answer with its intervals, recalls by object and threshold, how our own errors are
/// distributed, the worst estimates, definitions. Self-contained, as a study's.
std::string score_report(const ScoredResults& input);

}  // namespace sightline
