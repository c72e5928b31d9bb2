// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "eval/compare/compare.h"
#include "eval/compare/measures.h"
#include "eval/output/json.h"

namespace sightline {

/// How a measure of a solver's cell differs between two summary.json, by the intervals that stand
/// there (difference_interval, and Student's t of the fewer of both runs' trials) and of failures
/// by Fisher's test; for the middle stands the median. None where one of them does not tell it.
std::optional<Difference> stored_difference(const Measure& measure, const Json& base,
                                            const Json& now, double tolerance);

/// The same of the features of a condition. Each is what `extraction` has of it, with the number
/// of `trials`.
std::optional<Difference> stored_feature_difference(const Measure& measure, const Json& base,
                                                    const Json& now, double tolerance);

}  // namespace sightline
