// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/score/score.h"

namespace sightline {

/// HTML with the images of targets that have an estimate: the part about the object, with its
/// outline in the true and in the estimated pose. Left out is what has no picture that can be read.
std::string score_pictures(const BopDataset& dataset, std::span<const BopTarget* const> targets,
                           std::span<const BopEstimate> estimates);

}  // namespace sightline
