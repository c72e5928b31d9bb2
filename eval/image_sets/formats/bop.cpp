// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets in BOP's scenewise format (datasets/bop/layout.h): a scene is a chunk of the set.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/write.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/pictures.h"
#include "eval/image_sets/coco_keypoints.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "pose/lenses/catalogue.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string scene_folder(int64_t chunk) {
  return fmt::format("{}/{}/", bop::kTestSplit, bop::scene_name(chunk));
}

// Where the files of an image lie, in the order in which they are told.
struct ImagePaths {
  std::string grey;
  std::string grey_tiff;  // empty where the set has none
  std::string colour;     // empty where the image has none
  std::string depth;
  std::vector<std::string> masks;          // an instance each
  std::vector<std::string> visible_masks;  // an instance each: its pixels that are seen
};

ImagePaths paths_of(const SetPlan& plan, int64_t index, int64_t instances, bool has_colour) {
  const std::string scene = scene_folder(plan.chunk_of(index));
  const int64_t im_id = plan.number_in_chunk(index);
  const auto path = [&scene](std::string_view folder, const std::string& name) {
    return fmt::format("{}{}/{}.png", scene, folder, name);
  };
  ImagePaths paths;
  paths.grey = path(bop::kGreyFolder, bop::image_name(im_id));
  if (plan.extras.has_grey_tiff) {
    paths.grey_tiff = fs::path(paths.grey).replace_extension(".tiff").string();
  }
  if (has_colour) paths.colour = path(bop::kColourFolder, bop::image_name(im_id));
  paths.depth = path(bop::kDepthFolder, bop::image_name(im_id));
  for (int64_t gt_id = 0; gt_id < instances; ++gt_id) {
    const std::string name = bop::mask_name(im_id, gt_id);
    paths.masks.push_back(path(bop::kMaskFolder, name));
    paths.visible_masks.push_back(path(bop::kVisibleMaskFolder, name));
  }
  return paths;
}

// What of an image's bodies BOP tells of, in the order of scene_gt.
std::vector<Json> annotated(const Json& truth) {
  std::vector<Json> bodies;
  if (!truth.contains("bodies")) return bodies;
  for (const Json& body : truth["bodies"]) {
    if (!body.at("is_occluder").get<bool>()) bodies.push_back(body);
  }
  return bodies;
}

ImagePaths paths_of(const SetPlan& plan, const Json& truth) {
  return paths_of(plan, truth.at("index"), static_cast<int64_t>(annotated(truth).size()),
                  is_in_colour(truth));
}

std::vector<std::string> bop_image_paths(const SetPlan& plan, const Json& truth) {
  const ImagePaths paths = paths_of(plan, truth);
  std::vector<std::string> all = {paths.grey, paths.depth};
  for (size_t gt_id = 0; gt_id < paths.masks.size(); ++gt_id) {
    all.push_back(paths.masks[gt_id]);
    all.push_back(paths.visible_masks[gt_id]);
  }
  if (!paths.grey_tiff.empty()) all.push_back(paths.grey_tiff);
  if (!paths.colour.empty()) all.push_back(paths.colour);
  return all;
}

std::vector<SetFile> bop_image_files(const SetPlan& plan, const SetImage& image) {
  const Frame& frame = image.frame;
  std::vector<size_t> told;  // bodies
  for (size_t i = 0; i < frame.truth.bodies.size(); ++i) {
    if (!frame.truth.bodies[i].is_occluder) told.push_back(i);
  }
  const ImagePaths paths =
      paths_of(plan, image.index, static_cast<int64_t>(told.size()), !frame.colour.empty());
  std::vector<SetFile> files = {
      {paths.grey, png_bytes(frame.image)},
      {paths.depth, png_bytes(bop::depth_steps(frame.depth_m, plan.depth_scale))},
  };
  for (size_t gt_id = 0; gt_id < told.size(); ++gt_id) {
    const cv::Mat& whole = frame.truth.bodies[told[gt_id]].amodal_mask;
    const cv::Mat seen = frame.body_ids == static_cast<int>(told[gt_id]) + 1;
    const std::string whole_png = png_bytes(whole);
    const bool is_all_seen = cv::norm(whole, seen, cv::NORM_INF) == 0;
    files.push_back({paths.masks[gt_id], whole_png});
    files.push_back({paths.visible_masks[gt_id], is_all_seen ? whole_png : png_bytes(seen)});
  }
  if (!paths.grey_tiff.empty()) files.push_back({paths.grey_tiff, tiff_bytes(frame.image)});
  if (!paths.colour.empty()) files.push_back({paths.colour, png_bytes(frame.colour)});
  return files;
}

Json camera_of(const Json& truth, double depth_scale) {
  const Json& stated = truth.at("camera");
  Camera camera;
  camera.fx_px = stated.at("fx_px");
  camera.fy_px = stated.at("fy_px");
  camera.cx_px = stated.at("cx_px");
  camera.cy_px = stated.at("cy_px");
  camera.skew_px = stated.value("skew_px", 0.0);
  return bop::camera_entry(camera, depth_scale);
}

Json poses_of(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    entries.push_back(bop::truth_entry(body.at("obj_id"), pose_in(body)));
  }
  return entries;
}

cv::Rect rect_of(const Json& box) {
  return {box.at(0).get<int>(), box.at(1).get<int>(), box.at(2).get<int>(), box.at(3).get<int>()};
}

Json visibilities_of(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    entries.push_back(bop::info_entry({.whole_box = rect_of(body.at("amodal_box")),
                                       .visible_box = rect_of(body.at("visible_box")),
                                       .whole_pixels = body.at("amodal_pixels"),
                                       .pixels_with_depth = body.at("amodal_pixels_with_depth"),
                                       .visible_pixels = body.at("visible_pixels"),
                                       .visible_fraction = body.at("visible_fraction")}));
  }
  return entries;
}

Json bop_told_by_files(const SetPlan& plan, const fs::path& folder, const Json& truth) {
  return segmentations_in(folder, paths_of(plan, truth).visible_masks);
}

AnnotatedImage annotated_image(const SetPlan& plan, const std::string& scene, const Json& truth) {
  const Json& camera = truth.at("camera");
  const ImagePaths paths = paths_of(plan, truth);
  const std::string& picture = paths.colour.empty() ? paths.grey : paths.colour;
  return {.id = plan.number_in_chunk(truth.at("index")),
          .file_name = picture.substr(scene.size()),
          .width_px = camera.at("width_px"),
          .height_px = camera.at("height_px"),
          .bodies = annotated(truth),
          .segmentations = truth.at(kToldByFiles)};
}

std::vector<SetFile> bop_chunk_files(const SetPlan& plan, int64_t chunk,
                                     std::span<const Json> truths) {
  const std::string scene = scene_folder(chunk);
  std::vector<bop::ImageEntry> cameras, poses, visibilities;
  std::vector<AnnotatedImage> keypoints;
  for (const Json& truth : truths) {
    const int64_t im_id = plan.number_in_chunk(truth.at("index"));
    cameras.push_back({im_id, camera_of(truth, plan.depth_scale)});
    poses.push_back({im_id, poses_of(truth)});
    visibilities.push_back({im_id, visibilities_of(truth)});
    keypoints.push_back(annotated_image(plan, scene, truth));
  }
  const auto path = [&](std::string_view file) { return scene + std::string(file); };
  return {{path(bop::kSceneCameraFile), bop::scene_file(cameras)},
          {path(bop::kSceneTruthFile), bop::scene_file(poses)},
          {path(bop::kSceneInfoFile), bop::scene_file(visibilities)},
          {path(bop::kSceneKeypointsFile), coco_keypoints_file(plan, keypoints)}};
}

std::vector<Json> bop_list_elements(const SetPlan& plan, const Json& truth) {
  std::vector<std::pair<int, double>> instances;
  for (const Json& body : annotated(truth)) {
    instances.emplace_back(body.at("obj_id").get<int>(), body.at("visible_fraction").get<double>());
  }
  const int64_t index = truth.at("index");
  return bop::target_elements(plan.chunk_of(index), plan.number_in_chunk(index), instances);
}

std::string colour_line(const SetPlan& plan) {
  const auto& setups = plan.images().setups;
  const bool has_colour = std::any_of(setups.begin(), setups.end(), [](const ImageSetup& setup) {
    return setup.scene.colouring.mode != ColourMode::kGrey;
  });
  if (!has_colour) return "";
  return "- rgb/: the same in red, green and blue of Rec. 709, which gray/ is made of as OpenCV "
         "does "
         "it\n  (0.299, 0.587, 0.114 of the stored numbers).\n";
}

std::string dataset_info(const SetPlan& plan) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  const LensModel& lens = model_of(camera.lens);
  const EncodingText encoding = encoding_text(plan);
  std::string objects;
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    objects += fmt::format("- obj_{}: {}\n", six_digits(static_cast<int64_t>(i) + 1),
                           plan.objects[i]->name);
  }
  return fmt::format(
      R"(# {name}

{count} images rendered by Sightline {version} from scene.toml with seed {seed}, in the scenewise
format of BOP (https://bop.felk.cvut.cz), up to {chunk} images a scene.

{objects}
- gray/: {grey}, {bits} bits; white is {white}. {encoding}
{rgb}- depth/: 16 bits; times depth_scale = {depth_scale} mm it is z of what the pixel's centre sees.
  0 is background. sightline/ has the exact depth (truth: {truth}).
- mask/: the whole object as if nothing hid it; mask_visib/: what of it is seen. By ids, pixel by
  pixel, without any tolerance of depth.
- Pixel centres are at integers: (0, 0) is the centre of the top-left pixel. Camera: x right,
  y down, z forward. Millimetres here, metres in sightline/.
- Lens distortion has no place in this format: {names} = {coefficients}
  ({model}, OpenCV's signs), also in sightline/.
{extras}- models_eval/ has the meshes as they were rendered; models/ the same, of a set in colour with
  normals and colours.
)",
      fmt::arg("name", plan.study.name), fmt::arg("count", plan.count),
      fmt::arg("version", SIGHTLINE_VERSION), fmt::arg("seed", plan.study.seed),
      fmt::arg("chunk", plan.chunk), fmt::arg("objects", objects), fmt::arg("grey", encoding.grey),
      fmt::arg("encoding", encoding.sentence), fmt::arg("extras", extras_text(plan.extras)),
      fmt::arg("rgb", colour_line(plan)),
      fmt::arg("bits", plan.images().setups.front().scene.sensor.bits),
      fmt::arg("white", (1 << plan.images().setups.front().scene.sensor.bits) - 1),
      fmt::arg("depth_scale", plan.depth_scale),
      fmt::arg("truth", plan.has_full_truth ? "full" : "minimal: it has not"),
      fmt::arg("names", fmt::join(lens.coefficients, ", ")),
      fmt::arg("coefficients", fmt::join(coefficients_of(camera.lens), ", ")),
      fmt::arg("model", lens.title));
}

bool shows_colours(const SetPlan& plan) {
  const auto& setups = plan.images().setups;
  return std::any_of(setups.begin(), setups.end(), [](const ImageSetup& setup) {
    return setup.scene.colouring.mode != ColourMode::kGrey;
  });
}

std::vector<SetFile> bop_set_files(const SetPlan& plan) {
  std::vector<SetFile> files = {
      {std::string(bop::kCameraFile),
       bop::camera_file(plan.images().setups.front().scene.camera, plan.depth_scale)},
      {"dataset_info.md", dataset_info(plan)}};
  std::vector<const Mesh*> meshes;
  for (const auto& object : plan.objects) meshes.push_back(&object->mesh);
  for (SetFile& file : bop::model_files(meshes, shows_colours(plan)))
    files.push_back(std::move(file));
  return files;
}

// ---- checks

Json box_json(const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  return {box.x, box.y, box.width, box.height};
}

// Depths outside the sphere about a body's origin cannot be its.
bool is_at_its_distance(const cv::Mat& depth, const cv::Mat& mask, double depth_scale,
                        const Json& body, double radius_m) {
  double least = 0;
  double greatest = 0;
  cv::minMaxLoc(depth, &least, &greatest, nullptr, nullptr, mask);
  const double z_m = body.at("cam_from_target").at("translation_m")[2];
  const double step_m = depth_scale / kMillimetresPerMetre;
  return least * step_m >= z_m - radius_m - step_m && greatest * step_m <= z_m + radius_m + step_m;
}

std::vector<std::string> depth_problems(const SetPlan& plan, const fs::path& folder,
                                        const Json& truth, const cv::Mat& depth) {
  const std::vector<std::string> exact_path = truth_file_paths(plan, truth.at("index"));
  if (exact_path.empty()) return {};
  const cv::Mat exact = read_picture(folder / exact_path.front());
  if (exact.size() != depth.size() || exact.type() != CV_32F) return {};  // said elsewhere
  const double z0_m = truth.at("z0_m");
  int wrong = 0;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z_m = z0_m + exact.at<float>(v, u);
      const double steps = std::isnan(z_m) ? 0 : z_m * kMillimetresPerMetre / plan.depth_scale;
      const bool is_beyond = steps >= 65535.5;
      const bool is_there = depth.at<uint16_t>(v, u) != 0;
      const bool is_good =
          steps == 0 || is_beyond ? !is_there : std::abs(depth.at<uint16_t>(v, u) - steps) < 0.51;
      wrong += is_good ? 0 : 1;
    }
  }
  if (wrong == 0) return {};
  return {fmt::format("{} pixels of its depth are not what {} says", wrong, exact_path.front())};
}

// What is wrong with an instance's masks, and with the depth beneath them.
std::vector<std::string> mask_problems(const SetPlan& plan, const Json& body,
                                       const std::string& whole_path, const cv::Mat& whole,
                                       const std::string& seen_path, const cv::Mat& seen,
                                       const std::string& depth_path, const cv::Mat& depth) {
  std::vector<std::string> problems;
  const auto expect = [&](bool is_good, const std::string& problem) {
    if (!is_good) problems.push_back(problem);
  };
  expect(cv::countNonZero(whole) == body.at("amodal_pixels_in_image"),
         whole_path + " has another number of pixels than its truth");
  expect(cv::countNonZero(seen) == body.at("visible_pixels"),
         seen_path + " has another number of pixels than its truth");
  expect(box_json(seen) == body.at("visible_box"), seen_path + " fills another box");
  expect(cv::countNonZero(seen & ~whole) == 0, seen_path + " reaches beyond " + whole_path);
  const size_t object = body.at("obj_id").get<size_t>();
  if (object < 1 || object > plan.objects.size()) {
    problems.push_back("names an obj_id that the set has not");
    return problems;
  }
  expect(cv::countNonZero(seen) == 0 ||
             is_at_its_distance(depth, seen & (depth > 0), plan.depth_scale, body,
                                radius_m(plan.objects[object - 1]->mesh)),
         depth_path + " is not at the distance of its pose");
  return problems;
}

std::vector<std::string> bop_image_problems(const SetPlan& plan, const fs::path& folder,
                                            const Json& truth) {
  const std::vector<std::string> paths = bop_image_paths(plan, truth);
  const Json& camera = truth.at("camera");
  const cv::Size size(camera.at("width_px"), camera.at("height_px"));
  std::vector<cv::Mat> pictures;
  std::vector<std::string> problems;
  for (size_t i = 0; i < paths.size(); ++i) {
    pictures.push_back(read_picture(folder / paths[i]));
    const bool is_colour = is_in_colour(truth) && i + 1 == paths.size();
    const bool is_picture = i == 0 || is_colour || paths[i].ends_with(".tiff");
    const bool is_wide = i == 1 || (is_picture && truth.at("scene").at("sensor").at("bits") > 8);
    const cv::Mat& picture = pictures.back();
    const int type = CV_MAKETYPE(is_wide ? CV_16U : CV_8U, is_colour ? 3 : 1);
    if (picture.size() == size && picture.type() == type) continue;
    problems.push_back(paths[i] + " is torn, or not of the camera's size");
  }
  if (!problems.empty()) return problems;
  const std::vector<Json> bodies = annotated(truth);
  for (size_t gt_id = 0; gt_id < bodies.size(); ++gt_id) {
    const size_t whole = 2 + 2 * gt_id;
    const size_t seen = whole + 1;
    for (std::string& problem : mask_problems(plan, bodies[gt_id], paths[whole], pictures[whole],
                                              paths[seen], pictures[seen], paths[1], pictures[1])) {
      problems.push_back(std::move(problem));
    }
  }
  for (std::string& problem : depth_problems(plan, folder, truth, pictures[1])) {
    problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace

SetFormat bop_format() {
  return {.name = "bop",
          .summary = "Benchmark for 6D Object Pose Estimation, scenewise",
          .lens_note = "BOP has no lens distortion; it stands in dataset_info.md and sightline/",
          .image_files = bop_image_files,
          .image_paths = bop_image_paths,
          .image_problems = bop_image_problems,
          .told_by_files = bop_told_by_files,
          .chunk_files = bop_chunk_files,
          .list_path = bop::kTargetsFile,
          .list_elements = bop_list_elements,
          .set_files = bop_set_files};
}

}  // namespace sightline
