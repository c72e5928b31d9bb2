// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The files of BOP's scenewise format, as text and bytes (layout.h says where they lie). Poses,
// meshes and depths come in metres and stand in the files in millimetres.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "eval/datasets/set_file.h"
#include "eval/output/json.h"
#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline::bop {

/// What is seen of an instance in its image. "Whole" is the object as if nothing hid it, also
/// beyond the image's border.
struct Visibility {
  cv::Rect whole_box;
  cv::Rect visible_box;
  int whole_pixels = 0;
  int pixels_with_depth = 0;  ///< of the whole within the image, those that have a depth
  int visible_pixels = 0;
  double visible_fraction = 0;
};

/// An image's entry in a scene's file.
struct ImageEntry {
  int64_t im_id = 0;
  Json entry;
};

/// The camera of an image: its matrix, and millimetres a step of its depth.
Json camera_entry(const Camera& camera, double depth_scale);

/// The pose of an instance; an image's entry is an array of them.
Json truth_entry(int64_t obj_id, const Pose& cam_from_model);

/// How much of the instance is seen, in the order of the truth. Boxes are [x, y, w, h] with w and h
/// the difference of the greatest and the least coordinate, as the toolkit's calc_gt_info has them,
/// and -1 of what is not seen at all.
Json info_entry(const Visibility& seen);

/// One of a scene's three files: an image a line, as the toolkit writes it.
std::string scene_file(std::span<const ImageEntry> images);

/// What an image asks for, in elements of the list of targets: how many instances of each object
/// are visible enough. `instances` are pairs of obj_id and visible fraction.
std::vector<Json> target_elements(int64_t scene_id, int64_t im_id,
                                  std::span<const std::pair<int, double>> instances);

/// The camera that all images share.
std::string camera_file(const Camera& camera, double depth_scale);

/// models_info of a model's vertices as its PLY has them: diameter (the greatest distance of two),
/// min_x, ... and size_x, ...
Json model_info(const Mesh& mesh);

/// The folders models/ and models_eval/, which are equal but for normals and colours in models/ of
/// a set in colour: the i-th mesh is that of object i + 1.
std::vector<SetFile> model_files(std::span<const Mesh* const> meshes, bool is_in_colour);

/// A depth image in 16-bit steps of `depth_scale` millimetres, rounded; 0 of the background (0 m)
/// and of what lies beyond 16 bits. `depth_m` is CV_64F.
cv::Mat depth_steps(const cv::Mat& depth_m, double depth_scale);

}  // namespace sightline::bop
