// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/study/study.h"

namespace sightline {

/// Labels of conditions are shortened to so many characters in tables of results.
inline constexpr size_t kLongestLabel = 42;

/// The labels of a study's conditions, one a row of a table.
std::vector<std::string> condition_labels(const Study& study, size_t longest = kLongestLabel);

}  // namespace sightline
