// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The images of a split, which the scenewise format has scene by scene in JSON files of all images,
// and the imagewise one as some files an image, side by side.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/datasets/bop/image.h"

namespace sightline {

/// Whether an image is asked for.
using AskedImages = std::function<bool(int scene_id, int64_t im_id)>;

/// Whether a folder has images in the imagewise format.
bool is_imagewise(const std::filesystem::path& folder);

/// The images of such a folder that are asked for, without targets, by scene and image. A file's
/// key is the numbers of scene and image with an underscore between them, or the image's alone,
/// of scene 0. Throws InputError, with the file, for what is missing or not so.
std::vector<BopImage> read_imagewise(const std::filesystem::path& folder,
                                     const AskedImages& is_asked);

/// Whether a folder has scenes of the scenewise format, whatever their names.
bool has_scenes(const std::filesystem::path& folder);

/// The scenes in a split's folder that have a truth; `notes` gains a line on those whose names are
/// no numbers. Throws InputError where there are such alone.
std::vector<int> scenes_in(const std::filesystem::path& split, std::vector<std::string>& notes);

/// The images of these scenes that are asked for, likewise: of each scene_gt.json,
/// scene_camera.json and, where there is one, scene_gt_info.json. Of a scene with several sensors,
/// as sets of 2024 and later have them (scene_gt_cam1.json), those of `sensor`. Where that is
/// empty, those of scene_gt.json, else of the one that BOP evaluates, else of the first by name;
/// `notes` gains a line on the others.
std::vector<BopImage> read_scenewise(const std::filesystem::path& split,
                                     const std::vector<int>& scenes, const std::string& sensor,
                                     const AskedImages& is_asked, std::vector<std::string>& notes);

}  // namespace sightline
