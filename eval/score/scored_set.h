// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `score` reads: data sets with their truth, and what methods say of them, each in BOP's
// format or in that of SPEED+ and SPEED.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/datasets/bop/read.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/picture_names.h"

namespace sightline {

struct ScoredSet {
  BopDataset dataset;
  /// Of SPEED+, which knows images by their pictures' names: which image a picture is.
  PictureNames im_id_of_picture;
  bool is_speed() const { return !im_id_of_picture.empty(); }
};

/// A data set in BOP's scenewise format, or SPEED+'s: there `split` is its list without ".json",
/// `sensor` must be empty, the object is 1 and the model that of our own sets, model/target.ply, or
/// one without vertices. Throws InputError, with the file, for whatever is missing or not so.
ScoredSet read_scored_set(const std::filesystem::path& folder, const std::string& split,
                          const std::string& sensor = "");

/// The estimates of a file, in millimetres: a BOP results CSV, which may be of either kind of set;
/// of SPEED+'s also a list as the sets themselves have (filename, q_vbs2tango or q_vbs2tango_true,
/// r_Vo2To_vbs or r_Vo2To_vbs_true) or the challenges' CSV without head (filename, q0, q1, q2, q3,
/// x, y, z), q scalar first and metres. Throws InputError, with file and row, for whatever is not
/// so, for a picture that is named twice, and where the set has none of those that are named; what
/// else it has not is an estimate of no image.
std::vector<BopEstimate> read_estimates(const std::filesystem::path& file, const ScoredSet& set);

}  // namespace sightline
