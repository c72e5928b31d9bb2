// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What scores must be for `score` to end well: "add_recall>=0.9".
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "eval/score/score.h"
#include "eval/score/targets_file.h"

namespace sightline {

/// The figures of a summary by the names that scores.json has: "ar", "add_recall",
/// "geodesic_deg.median"; "failure_rate", the share of targets without an estimate; and ADD(-S) as
/// "add_s_recall".
std::vector<std::pair<std::string, double>> summary_numbers(const BopSummary& summary);

struct Requirement {
  std::string text;  ///< as it was given
  std::string name;  ///< of summary_numbers()
  bool is_least;     ///< the limit is the least that will do, else the greatest
  double limit = 0;
};

/// Reads NAME>=NUMBER or NAME<=NUMBER. Throws InputError for anything else and for a name that is
/// none of summary_numbers(), with the nearest that is.
Requirement parse_requirement(const std::string& text);

/// A requirement held against one method's scores.
struct RequirementResult {
  std::string method;
  Requirement requirement;
  double value = 0;
  bool is_met = false;
};

/// All requirements of all methods. Throws InputError where the data set does not let a figure be
/// known, as AR without depth images.
std::vector<RequirementResult> check_requirements(std::span<const Requirement> requirements,
                                                  std::span<const MethodScores> methods);

/// "A: add_recall is 0.71, must be 0.9 or more".
std::string to_text(const RequirementResult& result);

/// JUnit XML with a test case a requirement and method.
std::string to_junit(std::span<const RequirementResult> results, const std::string& set);

}  // namespace sightline
