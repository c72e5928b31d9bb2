// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/target/feature_shape.h"

namespace sightline {

/// Whether two features have one edge of the target, either way round: their ends are the same to a
/// ten-thousandth of its length, to which files round.
bool is_same_edge(const Edge& a, const Edge& b);

}  // namespace sightline
