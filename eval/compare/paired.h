// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/compare/compare.h"
#include "eval/compare/measures.h"
#include "eval/compare/pairing.h"

namespace sightline {

/// How a measure differs between the two of each pair of trials, with the p-value and verdict that
/// it has by itself. Every test keeps its level whatever the numbers' law, if without a change the
/// two of a pair could as well be exchanged: the base is first made worse by the tolerance, and
/// then
/// - mean: signs of the differences are flipped (p_mean_above_zero), BCa's interval;
/// - middle: Wilcoxon's signed ranks and their interval, with no tolerance of the trials that
///   differ; told is the base's median and the middle of the changes;
/// - median, p90: McNemar's test of which of a pair lies beyond the quantile of all numbers of both
///   runs together, and the bootstrap's interval;
/// - rms, rates and counts: with R the ratio of the sums of both runs together, signs of the pairs'
///   (y - R x) of the new run less those of the base are flipped, and the bootstrap's interval;
/// - what is true or not of a trial: McNemar's test.
/// `stream` names the random numbers of the bootstrap.
Difference paired_difference(const Measure& measure, const PairedNumber& pairs, double tolerance,
                             const std::string& stream);

}  // namespace sightline
