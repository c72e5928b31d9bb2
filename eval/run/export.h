// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sightline {

enum class ExportFormat {
  kBop,    ///< results CSV: poses in the set's own frame of the model, mm
  kSpeed,  ///< ESA's CSV: filename, quaternion scalar first, metres; of a data set's images alone
  kCoco,   ///< keypoint results: all features of the target in its order, score 0 of what was not
           ///< found
};

/// What of a run is written, and how.
struct ExportRequest {
  std::filesystem::path run;
  ExportFormat format = ExportFormat::kBop;
  /// Whose poses; of kCoco, whose judgement: features that it removed have score 0. Empty: the only
  /// solver, of kCoco nobody's.
  std::string solver;
  /// The label of the condition whose trials count; needed where a run has several.
  std::string condition;
  /// Of a run of several scenes: the one that is written; none: all, which COCO's results cannot
  /// tell apart.
  std::optional<int> scene;
};

/// What a run found, as other people's tools read it: a line or an entry a trial with a pose (of
/// kCoco: a trial). Pictures are named as TrialName says. Throws InputError for a run, a solver or
/// a condition that is not there, and for a run of a kind that has no such thing.
std::string export_run(const ExportRequest& request);

}  // namespace sightline
