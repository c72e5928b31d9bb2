// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "eval/report/chart.h"
#include "eval/study/study.h"
#include "eval/target/image_bound_report.h"

namespace sightline {

/// Charts of the bounds of theta_error and T_error over a study's conditions, a row each. Where the
/// conditions differ in one key alone that is a number, or a range ("poses.range_m"), they lie at
/// its value, or at the range's middle; elsewhere beside each other, by name.
std::vector<Chart> bound_charts(std::span<const Condition> conditions,
                                std::span<const ImageBoundRow> rows);

}  // namespace sightline
