// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "eval/datasets/bop/image.h"
#include "eval/datasets/bop/models.h"

namespace sightline {

struct BopDataset {
  std::map<int, BopModel> models;       ///< by obj_id, those of the targets
  std::vector<BopImage> images;         ///< those with targets
  std::vector<std::string> notes = {};  ///< as BopImages has them
};

/// The images of a data set, and what of it is told but does not count, a line each.
struct BopImages {
  std::vector<BopImage> images;  ///< those with targets
  std::vector<std::string> notes;
};

/// The images of a data set in BOP's scenewise or imagewise format, whoever made it, by scene and
/// image, as read_scenewise and read_imagewise have them (scenes.h). Files of JSON and models may
/// be packed by gzip, with ".gz" behind their names. `split` is a folder; empty: "test", or the
/// only one whose name begins so, or the set's own where the images lie there; `sensor` is one of
/// its scenes', which the imagewise format has not, empty: as read_scenewise says. The targets are
/// those of test_targets_bop19.json, else of test_targets_bop24.json or, without either, all
/// instances of which a tenth is visible. A list may name images alone, as that of detection does:
/// then it asks for all such instances in them. Throws InputError, with the file, for whatever is
/// missing or not so; a true pose that is none is an instance without a pose.
BopImages read_bop_images(const std::filesystem::path& folder, const std::string& split,
                          const std::string& sensor = "");

/// The instances of an object that the image asks for, as indices: the most visible first, those
/// that tie in their order.
std::vector<int> asked_instances(const BopImage& image, int obj_id);

/// The same images with the models of all their targets.
BopDataset read_bop_dataset(const std::filesystem::path& folder, const std::string& split,
                            const std::string& sensor = "");

}  // namespace sightline
