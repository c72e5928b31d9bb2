// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "eval/study/study.h"
#include "eval/summary/cells.h"
#include "eval/summary/summary.h"

namespace sightline {

/// One solver over all conditions of a study that have trials (a shard may lack some), each
/// condition weighing the same: what the paper's text calls its average.
struct SolverMeans {
  std::string solver;
  int trials = 0;
  int failures = 0;
  Measured theta_error_deg;
  Measured t_error_percent;
  std::optional<PaperFigure> paper;  ///< of the same conditions, where it prints one for each
};

SolverMeans means_over_conditions(const Study& study, const Summary& summary,
                                  std::string_view solver);

}  // namespace sightline
