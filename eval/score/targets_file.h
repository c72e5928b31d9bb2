// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// targets.csv: what became of each target that the data set asks for, a row each. It is all that
// `compare` needs, so that the file alone is a baseline.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/score/score.h"

namespace sightline {

inline constexpr const char* kTargetsFile = "targets.csv";

/// Whose estimates they are, and their scores.
struct MethodScores {
  std::string name;
  ScoredResults scored;
};

struct TargetRow {
  std::string method;
  std::array<int64_t, 4> id{};  ///< scene_id, im_id, obj_id, gt_id
  Eigen::Vector3d true_t_mm = Eigen::Vector3d::Zero();
  bool is_estimated = false;
  std::vector<double> numbers;  ///< as TargetNumber::of has them
};

struct TargetsTable {
  std::vector<std::string> numbers;  ///< the names of the rows' numbers
  std::vector<TargetRow> rows;
};

void write_targets_csv(std::span<const MethodScores> methods, std::ostream& out);

/// Throws InputError, with file and line, for what is no such file.
TargetsTable read_targets_csv(const std::filesystem::path& file);

}  // namespace sightline
