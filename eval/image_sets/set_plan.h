// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/image_sets/extras.h"
#include "eval/study/study_file.h"
#include "renderer/frame.h"
#include "renderer/renderer.h"

namespace sightline {

struct SetFormat;

/// Everything that determines an image set, byte by byte.
struct SetPlan {
  Study study;        ///< what the images show; always one of images
  int64_t count = 0;  ///< of images; image i is that of the study's trial i
  int chunk = 1000;   ///< images a numbered scene of the set
  const SetFormat* format = nullptr;
  bool has_full_truth = true;  ///< exact depth and part ids as well
  SetExtras extras;            ///< pictures on request
  std::string gl = "none";     ///< who draws: see gl_choice_names
  double depth_scale = 1;      ///< millimetres a step of a 16-bit depth image
  /// The distinct targets whose poses are told; the id of the first is 1.
  std::vector<std::shared_ptr<const Target>> objects;

  /// The study as what it is: one of images.
  const ImageStudy& images() const { return *study.images(); }
  int64_t chunk_count() const { return (count + chunk - 1) / chunk; }
  int64_t chunk_of(int64_t index) const { return index / chunk; }
  int64_t number_in_chunk(int64_t index) const { return index % chunk; }
};

/// What the command line says of a set.
struct SetRequest {
  std::string source;  ///< name of a target or study, or a file: see read_set_study
  StudyOverrides overrides;
  MeshUse mesh;  ///< what `overrides` say of the target's mesh
  int64_t count = 0;
  int chunk = 1000;
  std::string format = "bop";
  bool has_full_truth = true;
  std::vector<std::string> also;  ///< extra_names
  std::string gl = "none";
  std::optional<double> depth_scale;  ///< none: the finest that reaches all the scenes' depths
};

/// What an image set shows: a scene file, a study of images, or, by its name or file, a target with
/// a default scene. Throws InputError as read_study does.
Study read_set_study(const std::string& source, const StudyOverrides& overrides,
                     const MeshUse& use = {});

/// The default scene of a target, as a scene file says it: uniform attitudes, the middle of its box
/// at distances where a sphere round all of it covers three to seven tenths of the image's width.
/// It says nothing of how the mesh is taken, but is made for its size as taken.
std::string default_scene(const std::string& target, const MeshUse& use = {});

SetPlan plan_set(const SetRequest& request);

/// The farthest that any body of the plan's scenes reaches, metres.
double farthest_m(const ImageStudy& study);

/// The finest depth_scale, rounded up to four digits, with which `far_m` fits into 16 bits.
double finest_depth_scale(double far_m);

/// The id of a target in the set, 0 of none of its objects.
int object_id(const SetPlan& plan, const Target& target);

/// Whether some of the set's pictures are in colour, or in grey.
bool shows_colours(const SetPlan& plan);
bool shows_grey(const SetPlan& plan);

/// What is written down of a plan, sightline.json; equal for equal plans only.
std::string manifest_of(const SetPlan& plan);

/// The plan of the set in a folder, from its sightline.json and scene.toml. Throws InputError when
/// they cannot be read or do not fit each other.
SetPlan read_plan(const std::filesystem::path& folder);

/// An image of a set with all that is known of it.
struct SetImage {
  int64_t index = 0;
  DrawnScene drawn;
  Frame frame;  ///< empty where the scene cannot be imaged
};

/// Draws the scene of an image.
DrawnScene draw_scene(const SetPlan& plan, int64_t index);

/// Draws and renders it.
SetImage render_image(const SetPlan& plan, int64_t index, Renderer& renderer);

}  // namespace sightline
