// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The scenewise format of the Benchmark for 6D Object Pose Estimation (Hodan et al., ECCV 2018;
// docs/bop_datasets_format.md of its toolkit): millimetres, pixel centres at integers, depth times
// depth_scale in millimetres. A scene is a chunk of the set. Boxes are [x, y, w, h] with w and h
// the difference of the greatest and the least coordinate, as the toolkit's calc_gt_info has them,
// and -1 of what is not seen at all.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/datasets/pictures.h"
#include "eval/image_sets/formats/formats.h"
#include "eval/image_sets/models.h"
#include "eval/image_sets/truth.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastVisibleTarget = 0.1;  // what is seen less is not asked for (BOP 2019)

std::string scene_folder(const SetPlan& plan, int64_t index) {
  return "test/" + six_digits(plan.chunk_of(index)) + "/";
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

// Millimetres in steps of depth_scale; 0 of the background and of what lies beyond 16 bits.
cv::Mat depth_steps(const cv::Mat& depth_m, double depth_scale) {
  constexpr double kLargest = 65535;
  const double steps_a_m = 1000 / depth_scale;
  cv::Mat steps(depth_m.size(), CV_16U);
  for (int v = 0; v < depth_m.rows; ++v) {
    const double* from = depth_m.ptr<double>(v);
    uint16_t* to = steps.ptr<uint16_t>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      const double step = from[u] * steps_a_m + 0.5;
      to[u] = step < kLargest + 1 ? static_cast<uint16_t>(step) : uint16_t{0};
    }
  }
  return steps;
}

std::vector<std::string> image_paths(const SetPlan& plan, const Json& truth) {
  const int64_t index = truth.at("index");
  const std::string folder = scene_folder(plan, index);
  const std::string number = six_digits(plan.number_in_chunk(index));
  std::vector<std::string> paths = {folder + "gray/" + number + ".png",
                                    folder + "depth/" + number + ".png"};
  for (size_t gt = 0; gt < annotated(truth).size(); ++gt) {
    const std::string name = number + "_" + six_digits(static_cast<int64_t>(gt)) + ".png";
    paths.push_back(folder + "mask/" + name);
    paths.push_back(folder + "mask_visib/" + name);
  }
  return paths;
}

std::vector<SetFile> image_files(const SetPlan& plan, const SetImage& image) {
  const Frame& frame = image.frame;
  const std::string folder = scene_folder(plan, image.index);
  const std::string number = six_digits(plan.number_in_chunk(image.index));
  std::vector<SetFile> files = {
      {folder + "gray/" + number + ".png", png_bytes(frame.image)},
      {folder + "depth/" + number + ".png",
       png_bytes(depth_steps(frame.depth_m, plan.depth_scale))},
  };
  int64_t gt = 0;
  for (size_t i = 0; i < frame.truth.bodies.size(); ++i) {
    if (frame.truth.bodies[i].is_occluder) continue;
    const std::string name = number + "_" + six_digits(gt++) + ".png";
    const cv::Mat& whole = frame.truth.bodies[i].amodal_mask;
    const cv::Mat seen = frame.body_ids == static_cast<int>(i) + 1;
    const std::string whole_png = png_bytes(whole);
    const bool is_all_seen = cv::norm(whole, seen, cv::NORM_INF) == 0;
    files.push_back({folder + "mask/" + name, whole_png});
    files.push_back({folder + "mask_visib/" + name, is_all_seen ? whole_png : png_bytes(seen)});
  }
  return files;
}

Json millimetres(const Json& metres) {
  Json out = Json::array();
  for (const Json& value : metres) out.push_back(1000 * value.get<double>());
  return out;
}

Json bop_box(const Json& box, bool is_seen) {
  if (!is_seen) return {-1, -1, -1, -1};
  return {box[0], box[1], box[2].get<int>() - 1, box[3].get<int>() - 1};
}

Json camera_entry(const SetPlan& plan, const Json& truth) {
  const Json& camera = truth.at("camera");
  return {{"cam_K",
           {camera.at("fx_px"), 0.0, camera.at("cx_px"), 0.0, camera.at("fy_px"),
            camera.at("cy_px"), 0.0, 0.0, 1.0}},
          {"depth_scale", plan.depth_scale}};
}

Json gt_entry(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    const Json& pose = body.at("cam_from_target");
    entries.push_back({{"cam_R_m2c", pose.at("rotation")},
                       {"cam_t_m2c", millimetres(pose.at("translation_m"))},
                       {"obj_id", body.at("obj_id")}});
  }
  return entries;
}

Json info_entry(const Json& truth) {
  Json entries = Json::array();
  for (const Json& body : annotated(truth)) {
    const bool is_seen = body.at("visible_pixels") > 0;
    entries.push_back({{"bbox_obj", bop_box(body.at("amodal_box"), is_seen)},
                       {"bbox_visib", bop_box(body.at("visible_box"), is_seen)},
                       {"px_count_all", body.at("amodal_pixels")},
                       {"px_count_valid", body.at("amodal_pixels_with_depth")},
                       {"px_count_visib", body.at("visible_pixels")},
                       {"visib_fract", body.at("visible_fraction")}});
  }
  return entries;
}

// An object with an image a line, as the toolkit writes it.
std::string by_image(const SetPlan& plan, std::span<const Json> truths,
                     const std::function<Json(const Json&)>& entry) {
  std::string text = "{";
  for (const Json& truth : truths) {
    text += fmt::format("{}\n  \"{}\": {}", text.size() > 1 ? "," : "",
                        plan.number_in_chunk(truth.at("index")), entry(truth).dump());
  }
  return text + "\n}\n";
}

std::vector<SetFile> chunk_files(const SetPlan& plan, int64_t chunk, std::span<const Json> truths) {
  const std::string folder = "test/" + six_digits(chunk) + "/";
  return {
      {folder + "scene_camera.json",
       by_image(plan, truths, [&plan](const Json& truth) { return camera_entry(plan, truth); })},
      {folder + "scene_gt.json", by_image(plan, truths, gt_entry)},
      {folder + "scene_gt_info.json", by_image(plan, truths, info_entry)}};
}

std::vector<Json> list_elements(const SetPlan& plan, const Json& truth) {
  std::map<int, int> instances;
  for (const Json& body : annotated(truth)) {
    if (body.at("visible_fraction").get<double>() < kLeastVisibleTarget) continue;
    ++instances[body.at("obj_id").get<int>()];
  }
  const int64_t index = truth.at("index");
  std::vector<Json> targets;
  for (const auto& [object, count] : instances) {
    targets.push_back({{"im_id", plan.number_in_chunk(index)},
                       {"inst_count", count},
                       {"obj_id", object},
                       {"scene_id", plan.chunk_of(index)}});
  }
  return targets;
}

std::string dataset_info(const SetPlan& plan) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  const EncodingText encoding = encoding_text(plan);
  std::string objects;
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    objects += fmt::format("- obj_{:06}: {}\n", i + 1, plan.objects[i]->name);
  }
  return fmt::format(
      R"(# {name}

{count} images rendered by Sightline {version} from scene.toml with seed {seed}, in the scenewise
format of BOP (https://bop.felk.cvut.cz), up to {chunk} images a scene.

{objects}
- gray/: {grey}, {bits} bits; white is {white}. {encoding}
- depth/: 16 bits; times depth_scale = {depth_scale} mm it is z of what the pixel's centre sees.
  0 is background. sightline/ has the exact depth (truth: {truth}).
- mask/: the whole object as if nothing hid it; mask_visib/: what of it is seen. By ids, pixel by
  pixel, without any tolerance of depth.
- Pixel centres are at integers: (0, 0) is the centre of the top-left pixel. Camera: x right,
  y down, z forward. Millimetres here, metres in sightline/.
- Lens distortion has no place in this format: k1, k2, p1, p2, k3 = {k1}, {k2}, {p1}, {p2}, {k3}
  (Brown and Conrady, OpenCV's signs), also in sightline/.
- models_eval/ equals models/: the meshes as they were rendered.
)",
      fmt::arg("name", plan.study.name), fmt::arg("count", plan.count),
      fmt::arg("version", SIGHTLINE_VERSION), fmt::arg("seed", plan.study.seed),
      fmt::arg("chunk", plan.chunk), fmt::arg("objects", objects), fmt::arg("grey", encoding.grey),
      fmt::arg("encoding", encoding.sentence),
      fmt::arg("bits", plan.images().setups.front().scene.sensor.bits),
      fmt::arg("white", (1 << plan.images().setups.front().scene.sensor.bits) - 1),
      fmt::arg("depth_scale", plan.depth_scale),
      fmt::arg("truth", plan.has_full_truth ? "full" : "minimal: it has not"),
      fmt::arg("k1", camera.distortion.k1), fmt::arg("k2", camera.distortion.k2),
      fmt::arg("p1", camera.distortion.p1), fmt::arg("p2", camera.distortion.p2),
      fmt::arg("k3", camera.distortion.k3));
}

std::vector<SetFile> set_files(const SetPlan& plan) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  const Json camera_json = {
      {"cx", camera.cx_px},      {"cy", camera.cy_px}, {"depth_scale", plan.depth_scale},
      {"fx", camera.fx_px},      {"fy", camera.fy_px}, {"height", camera.height_px},
      {"width", camera.width_px}};
  std::vector<SetFile> files = {{"camera.json", camera_json.dump(2) + "\n"},
                                {"dataset_info.md", dataset_info(plan)}};
  Json infos = Json::object();
  for (size_t i = 0; i < plan.objects.size(); ++i) {
    const Mesh& mesh = plan.objects[i]->mesh;
    infos[fmt::to_string(i + 1)] = model_info(mesh);
    for (const char* folder : {"models", "models_eval"}) {
      files.push_back({fmt::format("{}/obj_{:06}.ply", folder, i + 1), ply_bytes(mesh)});
    }
  }
  for (const char* folder : {"models", "models_eval"}) {
    files.push_back({fmt::format("{}/models_info.json", folder), infos.dump(2) + "\n"});
  }
  return files;
}

// ---- checks

Json box_json(const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  return {box.x, box.y, box.width, box.height};
}

// Depths outside the sphere about a body's origin cannot be its.
bool fits(const cv::Mat& depth, const cv::Mat& mask, double depth_scale, const Json& body,
          double radius_m) {
  double least = 0;
  double greatest = 0;
  cv::minMaxLoc(depth, &least, &greatest, nullptr, nullptr, mask);
  const double z_m = body.at("cam_from_target").at("translation_m")[2];
  const double step_m = depth_scale / 1000;
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
      const double steps = std::isnan(z_m) ? 0 : z_m * 1000 / plan.depth_scale;
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

std::vector<std::string> image_problems(const SetPlan& plan, const fs::path& folder,
                                        const Json& truth) {
  const std::vector<std::string> paths = image_paths(plan, truth);
  const Json& camera = truth.at("camera");
  const cv::Size size(camera.at("width_px"), camera.at("height_px"));
  std::vector<cv::Mat> pictures;
  std::vector<std::string> problems;
  for (size_t i = 0; i < paths.size(); ++i) {
    pictures.push_back(read_picture(folder / paths[i]));
    const bool is_wide = i == 1 || (i == 0 && truth.at("scene").at("sensor").at("bits") > 8);
    const cv::Mat& picture = pictures.back();
    if (picture.size() == size && picture.type() == (is_wide ? CV_16U : CV_8U)) continue;
    problems.push_back(paths[i] + " is torn, or not of the camera's size");
  }
  if (!problems.empty()) return problems;
  const std::vector<Json> bodies = annotated(truth);
  for (size_t gt = 0; gt < bodies.size(); ++gt) {
    const Json& body = bodies[gt];
    const std::string& whole_path = paths[2 + 2 * gt];
    const std::string& seen_path = paths[3 + 2 * gt];
    const cv::Mat& whole = pictures[2 + 2 * gt];
    const cv::Mat& seen = pictures[3 + 2 * gt];
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
      continue;
    }
    expect(
        cv::countNonZero(seen) == 0 || fits(pictures[1], seen & (pictures[1] > 0), plan.depth_scale,
                                            body, radius_m(plan.objects[object - 1]->mesh)),
        paths[1] + " is not at the distance of its pose");
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
          .image_files = image_files,
          .image_paths = image_paths,
          .image_problems = image_problems,
          .chunk_files = chunk_files,
          .list_path = "test_targets_bop19.json",
          .list_elements = list_elements,
          .set_files = set_files};
}

}  // namespace sightline
