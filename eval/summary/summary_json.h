// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// summary.json: the contract that other programs read; stable order; numbers read back as
/// they were, null for NaN and infinity. "capped" counts the trials whose geodesic
/// error is at the cap, failures among them. In an orientation study cells have a method's name as
/// "solver", and besides "copies" (a trial), "failed_copies" (in all) and "angle_error_deg". "nees"
/// is null of a solver that reports no covariance.
std::string to_json(const Study& study, const Summary& summary);

/// summary.json's "extraction": a list of cells, each with its features.
std::string to_json(const Study& study, const FeatureStatistics& statistics);

}  // namespace sightline
