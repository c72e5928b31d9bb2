// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/study/study.h"

namespace sightline {

/// The Cramér-Rao bounds of one condition's images: root mean squares over its scenes.
struct ImageBoundRow {
  std::string label;
  int scenes = 0;      ///< drawn
  int determined = 0;  ///< of these, whose image determines a pose with the light unknown
  /// In the order of kImageBoundKinds; NaN where no scene is determined.
  std::vector<double> theta_deg, t_percent;
};

/// What is known besides the image.
inline constexpr const char* kImageBoundKinds[] = {"light known", "light unknown", "outline alone"};

/// The bounds of so many scenes of each condition of a study of rendered images, before anything
/// is run.
std::vector<ImageBoundRow> image_bound_rows(const Study& study, int scenes);

/// The rows as a table of the terminal, with a bar for each row's bound with the light unknown, on
/// a logarithmic scale.
std::string image_bound_table(const std::string& title, const std::vector<ImageBoundRow>& rows);

/// The same as JSON.
std::string image_bound_json(const std::string& title, const std::vector<ImageBoundRow>& rows);

/// The rows as CSV.
std::string image_bound_csv(const std::vector<ImageBoundRow>& rows);

}  // namespace sightline
