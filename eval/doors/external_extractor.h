// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "eval/doors/external_process.h"
#include "eval/doors/trial_extractor.h"

namespace sightline {

/// What a study says of an extractor that is a process: a table of [[external.extractor]].
struct ExtractorProcessSource : ProcessSource {
  double sigma_px = 1;  ///< of observations that state none
};

std::vector<Key> keys_of(ExtractorProcessSource& source);

/// An extractor that a process is. It is told the image as a file: that of the data set or, where
/// the image was rendered, one that is there until it has answered. What fails is the problem of
/// its answer, with the reason in the process's log. Throws InputError for a command without words,
/// and while it runs where an image cannot be written.
TrialExtractor external_extractor(const ExtractorProcessSource& source);

}  // namespace sightline
