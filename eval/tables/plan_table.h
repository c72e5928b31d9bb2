// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/output/json.h"
#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// How many trials each cell needs for 95 % intervals of its means of +- `target` of them, from the
/// summary of a pilot: a row a condition, a column a solver, and the most of all.
std::string plan_table(const Study& study, const Summary& summary, double target);

/// The same as JSON: null where the pilot says nothing.
Json plan_json(const Study& study, const Summary& summary, double target);

}  // namespace sightline
