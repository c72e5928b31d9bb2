// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "features/observation.h"
#include "scenes/target/target.h"

namespace sightline {

/// Drops lines whose edge pixels count already. An edge between two features is looked at from
/// both: where both were found, their pixels say what its lines say; where one was, its line is
/// dropped in favour of the other's; where neither was and their edge pixels overlap, the line
/// whose slope is known better is kept.
void drop_shared_lines(const Target& target, std::vector<Observation>& observations);

}  // namespace sightline
