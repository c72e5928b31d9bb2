// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pose/pose.h"

namespace sightline {

// Everything of datasets/bop that is read is in millimetres, BOP's unit, its poses' translations as
// well: errors are compared with those of BOP's own toolkit digit by digit.

/// What a method says of one object in one image.
struct BopEstimate {
  int scene_id = 0;
  int64_t im_id = 0;
  int obj_id = 0;
  double score = 0;
  Pose cam_from_model;  ///< mm; its rotation as usable_rotation has it
  double time_s = -1;   ///< of the whole image; -1: not known
  int line = 0;         ///< of the file, from 1
  /// Why the row is no estimate: its image then has a failed one. Empty where it is one.
  std::string problem{};
  // What BOP does not know, from columns that may follow its own.
  std::optional<Matrix6d> covariance_rad_m{};  ///< of (w, dt), as PoseEstimate::covariance
  std::vector<std::string> removed{};          ///< names of features judged outliers
};

/// Reads a results file of the BOP challenge: the header scene_id,im_id,obj_id,score,R,t,time, then
/// a line an estimate; R is nine numbers row by row and t three, in mm, with spaces between them.
/// Two more columns may follow: `covariance`, 21 numbers with spaces between them, the upper
/// triangle by rows of the covariance of (w, dt), cam_from_model = (Exp(w) R, t + dt), radians and
/// metres; and `removed`, names of features with semicolons between them. Either may be empty.
/// A file without the header, whose first row is an estimate, is read as well. A row with a score,
/// a time or a pose that is not finite, or an R that is no rotation within what a few printed
/// digits leave (1e-2; usable_rotation mends it), is kept as a failure (`problem`), of the lowest
/// score where it has none. Throws InputError, with file and line, for whatever else is not so.
std::vector<BopEstimate> read_bop_results(const std::filesystem::path& file);

/// One line on the rows that are failures, with the first of them; empty where there is none.
std::string failed_rows(std::span<const BopEstimate> estimates);

}  // namespace sightline
