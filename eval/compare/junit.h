// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/compare/compare.h"

namespace sightline {

/// A comparison as JUnit XML, which services that run tests can show: a test case a cell, which
/// fails where the cell is worse or missing. Characters that XML cannot hold become U+FFFD.
std::string to_junit(const Comparison& comparison);

}  // namespace sightline
