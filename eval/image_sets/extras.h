// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Pictures that a set has on request (render --also). Those of normals and of object coordinates
// lie beside our own truth, sightline/<scene>/<image>_normals.png and _nocs.png, in every format:
// 16 bits, black where nothing is seen.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "eval/datasets/set_file.h"

namespace sightline {

struct SetImage;

/// Which there are.
struct SetExtras {
  bool has_itodd_tif = false;    ///< BOP's grey and depth as .tif, as its toolkit reads ITODD
  bool has_grey_tiff = false;    ///< BOP's grey as .tiff, as its toolkit's readers of folders do
  bool has_rgb_of_grey = false;  ///< BOP's rgb/ of grey pictures, for who reads nothing else
  bool has_normals = false;      ///< of the surfaces that pixels see
  bool has_coordinates = false;  ///< where on their body these points lie
};

/// The words that --also takes, in the order in which a set's manifest has them.
std::vector<std::string> extra_names();
std::vector<std::string> names_of(const SetExtras& extras);
/// Throws InputError when a name is none.
SetExtras extras_named(std::span<const std::string> names);
/// Those of either.
SetExtras joined(const SetExtras& a, const SetExtras& b);

/// The pictures of one image, and their paths, which begin with `stem`. Red, green and blue of
/// normals are x, y and z in the camera's axes, 65535 (n + 1) / 2; those of object coordinates x, y
/// and z in the body's frame, 65535 ((x - middle) / diagonal + 1/2), by the box of its mesh
/// (H. Wang et al., Normalized object coordinate space, 2019).
std::vector<SetFile> extra_files(const SetExtras& extras, const SetImage& image,
                                 const std::string& stem);
std::vector<std::string> extra_paths(const SetExtras& extras, const std::string& stem);

/// What they mean, for the description of a set; empty where there are none.
std::string extras_text(const SetExtras& extras);

}  // namespace sightline
