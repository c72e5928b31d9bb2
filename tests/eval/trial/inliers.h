// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "eval/records/records.h"

namespace sightline {

/// How many features of a trial were found and are no outliers.
inline int inliers_of(const TrialRecord& record) {
  int count = 0;
  for (const ObservationRecord& o : record.observations()) count += o.is_found() && !o.is_outlier;
  return count;
}

}  // namespace sightline
