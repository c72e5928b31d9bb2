// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/datasets/set_file.h"
#include "eval/image_sets/set_plan.h"
#include "eval/output/json.h"

namespace sightline {

/// The member of a truth that chunk_files is given; it stands in no file.
inline constexpr std::string_view kToldByFiles = "told_by_files";

/// A layout that image sets are written in. To add one: write formats/<name>.cpp and name it in
/// set_format.cpp. Every function is pure but for what it reads: the engine
/// writes.
/// `truth` is what truth_of (truth.h) says of an image, and images that could not be made have no
/// part in it.
struct SetFormat {
  std::string_view name;
  std::string_view summary;
  /// What to tell whoever renders with lens distortion, where the format has no place for it.
  std::string_view lens_note;
  /// More pictures that it has a place for (render --also), and which sets in grey have unasked.
  SetExtras extras = {.has_normals = true, .has_coordinates = true};
  SetExtras grey_extras = {};

  /// The files of one image, the picture first.
  std::vector<SetFile> (*image_files)(const SetPlan& plan, const SetImage& image);
  /// The paths of the same.
  std::vector<std::string> (*image_paths)(const SetPlan& plan, const Json& truth);
  /// What is wrong with those files, which are there, of an image with this truth.
  std::vector<std::string> (*image_problems)(const SetPlan& plan,
                                             const std::filesystem::path& folder,
                                             const Json& truth);
  /// What chunk_files has to know of an image's files beyond its truth, where it finds it as
  /// kToldByFiles; null where they cannot be read. No function, of a format whose truths suffice.
  Json (*told_by_files)(const SetPlan& plan, const std::filesystem::path& folder,
                        const Json& truth);
  /// What joins a chunk's images: the truths are in the order of the images.
  std::vector<SetFile> (*chunk_files)(const SetPlan& plan, int64_t chunk,
                                      std::span<const Json> truths);
  /// The list of all images, an array in a file of this path, and its elements for one of them.
  std::string_view list_path;
  std::vector<Json> (*list_elements)(const SetPlan& plan, const Json& truth);
  /// What is there once a set.
  std::vector<SetFile> (*set_files)(const SetPlan& plan);
};

/// How the grey levels of a set's images stand for light, in words for its description.
struct EncodingText {
  std::string grey;      ///< "linear grey"
  std::string sentence;  ///< "Nothing is gamma-encoded."
};

EncodingText encoding_text(const SetPlan& plan);

/// The catalogue, in the order in which it is listed.
std::span<const SetFormat> set_formats();

/// The format of that name; throws InputError with a suggestion when there is none.
const SetFormat& find_set_format(const std::string& name);

}  // namespace sightline
