// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/bop_truth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/bop/write.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/pictures.h"
#include "eval/image_sets/truth.h"
#include "pose/lenses/catalogue.h"
#include "scenes/picture/picture_file.h"

namespace sightline::bop {
namespace {

namespace fs = std::filesystem;

cv::Rect rect_of(const Json& box) {
  return {box.at(0).get<int>(), box.at(1).get<int>(), box.at(2).get<int>(), box.at(3).get<int>()};
}

std::string colour_line(const SetPlan& plan, const LayoutText& layout) {
  if (!shows_colours(plan)) return "";
  return fmt::format(
      "- {}: the same in red, green and blue of Rec. 709, which {} is made of as OpenCV does it\n"
      "  (0.299, 0.587, 0.114 of the stored numbers).\n",
      layout.colour, layout.grey);
}

std::string dataset_info(const SetPlan& plan, const LayoutText& layout) {
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

{count} images rendered by Sightline {version} from scene.toml with seed {seed}, in the {layout}
format of BOP (https://bop.felk.cvut.cz), up to {chunk} images a scene.

{objects}
- {gray_path}: {grey}, {bits} bits; white is {white}. {encoding}
{rgb}- {depth_path}: 16 bits; times depth_scale = {depth_scale} mm it is z of what the pixel's centre sees.
  0 is background. sightline/*/*_depth.tiff has the exact depth (truth: {truth}): z less the z0_m
  of the image's .json, metres in 32-bit floats, NaN of background.
- {mask_path}: the whole object as if nothing hid it; {seen_path}: what of it is seen. By ids, pixel by
  pixel, without any tolerance of depth.
- Pixel centres are at integers: (0, 0) is the centre of the top-left pixel. Camera: x right,
  y down, z forward. Millimetres here, metres in sightline/.
- Lens distortion has no place in this format: {names} = {coefficients}
  ({model}, OpenCV's signs), also in sightline/.
{extras}- models_eval/ has the meshes as they were rendered; models/ the same, of a set in colour with
  normals and colours.
)",
      fmt::arg("layout", layout.name), fmt::arg("gray_path", layout.grey),
      fmt::arg("depth_path", layout.depth), fmt::arg("mask_path", layout.masks),
      fmt::arg("seen_path", layout.visible_masks), fmt::arg("name", plan.study.name),
      fmt::arg("count", plan.count), fmt::arg("version", SIGHTLINE_VERSION),
      fmt::arg("seed", plan.study.seed), fmt::arg("chunk", plan.chunk),
      fmt::arg("objects", objects), fmt::arg("grey", encoding.grey),
      fmt::arg("encoding", encoding.sentence), fmt::arg("extras", extras_text(plan.extras)),
      fmt::arg("rgb", colour_line(plan, layout)),
      fmt::arg("bits", plan.images().setups.front().scene.sensor.bits),
      fmt::arg("white", (1 << plan.images().setups.front().scene.sensor.bits) - 1),
      fmt::arg("depth_scale", plan.depth_scale),
      fmt::arg("truth", plan.has_full_truth ? "full" : "minimal: it has not"),
      fmt::arg("names", fmt::join(lens.coefficients, ", ")),
      fmt::arg("coefficients", fmt::join(coefficients_of(camera.lens), ", ")),
      fmt::arg("model", lens.title));
}

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
std::vector<std::string> instance_problems(const SetPlan& plan, const Json& body,
                                           const ReadPicture& whole, const ReadPicture& seen,
                                           const ReadPicture& depth) {
  std::vector<std::string> problems;
  const auto expect = [&](bool is_good, const std::string& problem) {
    if (!is_good) problems.push_back(problem);
  };
  expect(cv::countNonZero(whole.pixels) == body.at("amodal_pixels_in_image"),
         whole.path + " has another number of pixels than its truth");
  expect(cv::countNonZero(seen.pixels) == body.at("visible_pixels"),
         seen.path + " has another number of pixels than its truth");
  expect(box_json(seen.pixels) == body.at("visible_box"), seen.path + " fills another box");
  expect(cv::countNonZero(seen.pixels & ~whole.pixels) == 0,
         seen.path + " reaches beyond " + whole.path);
  const size_t object = body.at("obj_id").get<size_t>();
  if (object < 1 || object > plan.objects.size()) {
    problems.push_back("names an obj_id that the set has not");
    return problems;
  }
  expect(cv::countNonZero(seen.pixels) == 0 ||
             is_at_its_distance(depth.pixels, seen.pixels & (depth.pixels > 0), plan.depth_scale,
                                body, radius_m(plan.objects[object - 1]->mesh)),
         depth.path + " is not at the distance of its pose");
  return problems;
}

}  // namespace

std::vector<Json> annotated(const Json& truth) {
  std::vector<Json> bodies;
  if (!truth.contains("bodies")) return bodies;
  for (const Json& body : truth["bodies"]) {
    if (!body.at("is_occluder").get<bool>()) bodies.push_back(body);
  }
  return bodies;
}

std::string_view colour_ending(const SetPlan& plan, const Frame& frame) {
  if (frame.colour.empty()) return plan.extras.has_rgb_of_grey ? ".png" : "";
  return frame.colour_jpeg.empty() ? ".png" : ".jpg";
}

std::string_view colour_ending(const SetPlan& plan, const Json& truth) {
  if (!is_in_colour(truth)) return plan.extras.has_rgb_of_grey ? ".png" : "";
  return truth.at("scene").at("sensor").contains("jpeg_quality") ? ".jpg" : ".png";
}

std::string colour_bytes(const Frame& frame) {
  if (!frame.colour_jpeg.empty()) return frame.colour_jpeg;
  if (!frame.colour.empty()) return png_bytes(frame.colour);
  cv::Mat alike;
  cv::cvtColor(frame.image, alike, cv::COLOR_GRAY2BGR);
  return png_bytes(alike);
}

std::vector<InstanceMasks> masks_of(const Frame& frame) {
  std::vector<InstanceMasks> masks;
  for (size_t i = 0; i < frame.truth.bodies.size(); ++i) {
    if (frame.truth.bodies[i].is_occluder) continue;
    masks.push_back({frame.truth.bodies[i].amodal_mask, frame.body_ids == static_cast<int>(i) + 1});
  }
  return masks;
}

Json image_camera(const SetPlan& plan, const Json& truth) {
  const Json& stated = truth.at("camera");
  Camera camera;
  camera.fx_px = stated.at("fx_px");
  camera.fy_px = stated.at("fy_px");
  camera.cx_px = stated.at("cx_px");
  camera.cy_px = stated.at("cy_px");
  camera.skew_px = stated.value("skew_px", 0.0);
  return camera_entry(camera, plan.depth_scale);
}

Json image_poses(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    entries.push_back(truth_entry(body.at("obj_id"), pose_in(body)));
  }
  return entries;
}

Json image_visibilities(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    entries.push_back(info_entry({.whole_box = rect_of(body.at("amodal_box")),
                                  .visible_box = rect_of(body.at("visible_box")),
                                  .whole_pixels = body.at("amodal_pixels"),
                                  .pixels_with_depth = body.at("amodal_pixels_with_depth"),
                                  .visible_pixels = body.at("visible_pixels"),
                                  .visible_fraction = body.at("visible_fraction")}));
  }
  return entries;
}

std::vector<Json> image_targets(const SetPlan& plan, const Json& truth) {
  std::vector<std::pair<int, double>> instances;
  for (const Json& body : annotated(truth)) {
    instances.emplace_back(body.at("obj_id").get<int>(), body.at("visible_fraction").get<double>());
  }
  const int64_t index = truth.at("index");
  return target_elements(plan.chunk_of(index), plan.number_in_chunk(index), instances);
}

AnnotatedImage annotated_image(const SetPlan& plan, const Json& truth, std::string file_name) {
  const Json& camera = truth.at("camera");
  const Json& told = truth.at(kToldByFiles);  // null where a file is missing
  const auto of_bodies = [&told](const char* key) {
    return told.contains(key) ? told.at(key) : Json();
  };
  return {.id = plan.number_in_chunk(truth.at("index")),
          .file_name = std::move(file_name),
          .width_px = camera.at("width_px"),
          .height_px = camera.at("height_px"),
          .bodies = annotated(truth),
          .segmentations = of_bodies("segmentations"),
          .whole_boxes = of_bodies("whole_boxes")};
}

std::vector<SetFile> set_files(const SetPlan& plan, const LayoutText& layout) {
  std::vector<SetFile> files = {
      {std::string(kCameraFile),
       camera_file(plan.images().setups.front().scene.camera, plan.depth_scale)},
      {"dataset_info.md", dataset_info(plan, layout)}};
  std::vector<const Mesh*> meshes;
  for (const auto& object : plan.objects) meshes.push_back(&object->mesh);
  for (SetFile& file : model_files(meshes, shows_colours(plan))) files.push_back(std::move(file));
  return files;
}

std::vector<std::string> instances_problems(const SetPlan& plan, const fs::path& folder,
                                            const Json& truth, const ReadImage& image) {
  const std::vector<Json> bodies = annotated(truth);
  std::vector<std::string> problems;
  const auto add = [&problems](std::vector<std::string> more) {
    for (std::string& problem : more) problems.push_back(std::move(problem));
  };
  for (size_t i = 0; i < bodies.size(); ++i) {
    add(instance_problems(plan, bodies[i], image.masks[i], image.visible_masks[i], image.depth));
  }
  add(depth_problems(plan, folder, truth, image.depth.pixels));
  return problems;
}

}  // namespace sightline::bop
