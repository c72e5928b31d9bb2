// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// How the paper's claim stands in these trials, a sentence each; empty where the study has nothing
/// to hold against it.
std::vector<std::string> claim_verdicts(const Study& study, const Summary& summary);

}  // namespace sightline
