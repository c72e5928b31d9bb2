// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the scenewise format of the Benchmark for 6D Object Pose Estimation is, for its readers and
// its writers alike (Hodan et al., ECCV 2018; docs/bop_datasets_format.md of its toolkit): a set
// has a folder of models and folders of scenes ("splits"), a scene has a folder a kind of picture
// and three JSON files with an entry an image. Lengths are millimetres, x_cam = R x_model + t,
// pixel centres are at integers, as ours.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sightline::bop {

/// Of what is seen less than this fraction, no pose is asked for (BOP Challenge 2019).
inline constexpr double kLeastVisibleFraction = 0.1;

// Files of a set.
inline constexpr std::string_view kCameraFile = "camera.json";
inline constexpr std::string_view kTargetsFile = "test_targets_bop19.json";
/// The list of the detection task, of 2024 and later: of a set without the other it is the list.
inline constexpr std::string_view kDetectionTargetsFile = "test_targets_bop24.json";
inline constexpr std::string_view kModelsFolder = "models";
/// The models that errors are computed with; a set may lack them, then it is kModelsFolder.
inline constexpr std::string_view kEvaluatedModelsFolder = "models_eval";
inline constexpr std::string_view kModelsInfoFile = "models_info.json";
/// The split whose images kTargetsFile is of; the names of its variants begin so.
inline constexpr std::string_view kTestSplit = "test";

// Files and folders of a scene.
inline constexpr std::string_view kSceneCameraFile = "scene_camera.json";
inline constexpr std::string_view kSceneTruthFile = "scene_gt.json";
inline constexpr std::string_view kSceneInfoFile = "scene_gt_info.json";
/// Of the imagewise format, behind the image's key.
inline constexpr std::string_view kImageTruthFile = ".gt.json";
/// COCO's annotations of boxes and masks, as the toolkit's calc_gt_coco writes them.
inline constexpr std::string_view kSceneBoxesFile = "scene_gt_coco.json";
/// The same with keypoints, which is ours.
inline constexpr std::string_view kSceneKeypointsFile = "scene_gt_coco_keypoints.json";
inline constexpr std::string_view kColourFolder = "rgb";
inline constexpr std::string_view kGreyFolder = "gray";
inline constexpr std::string_view kDepthFolder = "depth";
inline constexpr std::string_view kMaskFolder = "mask";               ///< of whole objects
inline constexpr std::string_view kVisibleMaskFolder = "mask_visib";  ///< of what is seen of them

/// "obj_000001.ply", in a folder of models.
std::string model_file(int64_t obj_id);
/// "000017", a scene's folder in its split.
std::string scene_name(int64_t scene_id);
/// "000017", an image's files in their folders, but for the ending.
std::string image_name(int64_t im_id);
/// "rgb_cam1" and "scene_gt_cam1.json": a folder or a file of a scene with several sensors; the
/// name itself where the sensor has none.
std::string of_sensor(std::string_view name, std::string_view sensor);
/// "000017_000002", the masks of an instance, the last number its place in the image's truth.
std::string mask_name(int64_t im_id, int64_t gt_id);

}  // namespace sightline::bop
