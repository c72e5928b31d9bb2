// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "eval/compare/pairing.h"

namespace sightline {

/// The values of settings by their names.
using Settings = std::map<std::string, std::string>;

/// Which of them differ, as one line: "settings differ: noise.scale 1.0 to 2.0; solver.rho not
/// stated to 5.0", or "settings: the same in both". Numbers that are equal do not differ in how
/// they are written.
std::string settings_text(const Settings& base, const Settings& now);

/// The same of two runs, by their studies as run; texts that only explain a study are left out.
/// Says so where a study is not known.
std::string settings_text(const ComparedRun& base, const ComparedRun& now);

}  // namespace sightline
