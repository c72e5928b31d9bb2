// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The functions of the catalogue of absolute orientation with outliers
// (pose/robust_alignment.cpp), one a file of this folder. Reach them through
// find_robust_alignment_method.
#pragma once

#include "pose/robust_alignment.h"

namespace sightline {

RobustAlignment align_by_consensus(const MatchedPoints& points,
                                   const RobustAlignmentOptions& options);
RobustAlignment align_by_orpe(const MatchedPoints& points, const RobustAlignmentOptions& options);
RobustAlignment align_by_ransac_umeyama(const MatchedPoints& points,
                                        const RobustAlignmentOptions& options);

}  // namespace sightline
