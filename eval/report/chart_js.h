// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// The text of Chart.js with its licence, which the build takes from the system's package and puts
/// into the program.
std::string chart_js();

}  // namespace sightline
