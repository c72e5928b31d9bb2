// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/image_sets/truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/pictures.h"
#include "scenes/files/checksum.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Json array_of(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

Json array_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json array_of(const cv::Rect& box) {
  return {box.x, box.y, box.width, box.height};
}

Json row_wise(const Eigen::Matrix3d& m) {
  Json out = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) out.push_back(m(row, column));
  }
  return out;
}

// What the tables of the keys (scenes/scene/keys.h) state of a part of the scene.
Json object_of(const std::vector<Fact>& facts) {
  Json out = Json::object();
  for (const Fact& fact : facts) {
    std::visit([&](const auto& value) { out[fact.name] = value; }, fact.value);
  }
  return out;
}

Json scene_json(const Scene& scene) {
  Json out = {{"light", object_of(facts_of(scene.light))},
              {"background", object_of(facts_of(scene.background))},
              {"livery", object_of(facts_of(scene.livery))},
              {"motion", object_of(facts_of(scene.motion))},
              {"sensor", object_of(facts_of(scene.sensor))},
              {"samples_per_pixel", scene.samples_per_pixel}};
  const std::vector<Fact> colouring = facts_of(scene.colouring);
  if (!colouring.empty()) out["colouring"] = object_of(colouring);
  const std::vector<Fact> optics = facts_of(scene.optics);
  if (!optics.empty()) out["optics"] = object_of(optics);
  for (const Lamp& lamp : scene.lamps) out["lamps"].push_back(object_of(facts_of(lamp)));
  for (const DrawnMaterial& drawn : scene.materials) {
    out["materials"].push_back(object_of(facts_of(drawn)));
  }
  if (scene.environment.is_there()) out["environment"] = object_of(facts_of(scene.environment));
  return out;
}

Json feature_json(const TargetFeature& feature, const FeatureTruth& truth) {
  Json edges = Json::array();
  for (const EdgeTruth& edge : truth.edges) {
    edges.push_back({array_of(edge.begin), array_of(edge.end)});
  }
  return {{"name", feature.name},
          {"pixel", array_of(truth.pixel)},
          {"is_visible", truth.is_visible},
          {"is_in_image", truth.is_in_image},
          {"is_hidden_by_other", truth.is_hidden_by_other},
          {"edges", edges}};
}

Json pose_json(const Pose& cam_from_target) {
  const Eigen::Vector4d q = quaternion_wxyz(cam_from_target.rotation);
  return {{"q_wxyz", {q[0], q[1], q[2], q[3]}},
          {"rotation", row_wise(cam_from_target.rotation)},
          {"translation_m", array_of(cam_from_target.translation)}};
}

const Target& target_of(const Scene& scene, size_t body) {
  return body == 0 ? *scene.target : *scene.others[body - 1].target;
}

Json body_json(const SetPlan& plan, const SetImage& image, size_t i) {
  const Target& target = target_of(image.drawn.scene, i);
  const BodyTruth& body = image.frame.truth.bodies[i];
  Json features = Json::array();
  for (size_t k = 0; k < body.features.size(); ++k) {
    features.push_back(feature_json(target.features[k], body.features[k]));
  }
  const cv::Mat seen_or_hidden = body.amodal_mask & (image.frame.depth_m > 0);
  return {{"target", target.name},
          {"obj_id", body.is_occluder ? 0 : object_id(plan, target)},
          {"is_occluder", body.is_occluder},
          {"cam_from_target", pose_json(body.cam_from_target)},
          {"visible_box", array_of(body.visible_box)},
          {"visible_pixels", body.visible_pixels},
          {"amodal_box", array_of(body.amodal_box)},
          {"amodal_pixels", body.amodal_pixels},
          {"amodal_pixels_in_image", cv::countNonZero(body.amodal_mask)},
          {"amodal_pixels_with_depth", cv::countNonZero(seen_or_hidden)},
          {"visible_fraction", body.visible_fraction()},
          {"features", features}};
}

double z0_of(const SetImage& image) {
  return image.drawn.scene.cam_from_target.translation.z();
}

cv::Mat relative_depth(const SetImage& image) {
  const cv::Mat& depth_m = image.frame.depth_m;
  const double z0 = z0_of(image);
  cv::Mat relative(depth_m.size(), CV_32F);
  for (int v = 0; v < depth_m.rows; ++v) {
    const double* from = depth_m.ptr<double>(v);
    float* to = relative.ptr<float>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      to[u] =
          from[u] > 0 ? static_cast<float>(from[u] - z0) : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return relative;
}

std::string stem_of(const SetPlan& plan, int64_t index) {
  return fmt::format("sightline/{}/{}", six_digits(plan.chunk_of(index)),
                     six_digits(plan.number_in_chunk(index)));
}

std::vector<std::string> exact_file_paths(const SetPlan& plan, int64_t index) {
  if (!plan.has_full_truth) return {};
  const std::string stem = stem_of(plan, index);
  return {stem + "_depth.tiff", stem + "_parts.png"};
}

std::vector<SetFile> truth_files(const SetPlan& plan, const SetImage& image) {
  std::vector<SetFile> files;
  const std::vector<std::string> exact = exact_file_paths(plan, image.index);
  if (!exact.empty()) {
    files = {{exact[0], tiff_bytes(relative_depth(image), TiffPacking::kDeflate)},
             {exact[1], png_bytes(image.frame.part_ids)}};
  }
  for (SetFile& file : extra_files(plan.extras, image, stem_of(plan, image.index))) {
    files.push_back(std::move(file));
  }
  return files;
}

// ---- checks

// Redrawing rounds alike on one machine; libraries of other machines may differ in the last digit.
constexpr double kRounding = 1e-9;

bool is_close(double a, double b) {
  return std::abs(a - b) <= kRounding * (1 + std::abs(b));
}

bool is_close(const Pose& a, const Pose& b) {
  const double scale = 1 + b.translation.norm();
  return (a.rotation - b.rotation).norm() <= kRounding &&
         (a.translation - b.translation).norm() <= kRounding * scale;
}

// Numbers may differ by rounding, all else must be the same.
bool is_close(const Json& a, const Json& b) {
  if (a.is_number() && b.is_number()) return is_close(a.get<double>(), b.get<double>());
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.is_object()) {
    for (const auto& [key, value] : b.items()) {
      if (!a.contains(key) || !is_close(a[key], value)) return false;
    }
    return true;
  }
  if (!a.is_array()) return a == b;
  for (size_t i = 0; i < b.size(); ++i) {
    if (!is_close(a[i], b[i])) return false;
  }
  return true;
}

std::vector<std::string> body_problems(const Json& body, const Target& target, const Camera& camera,
                                       const Pose& drawn) {
  std::vector<std::string> problems;
  const auto expect = [&](bool is_good, const std::string& problem) {
    if (!is_good) problems.push_back(problem);
  };
  const Pose pose = pose_in(body);
  expect(body.at("target") == target.name, "names another target than the scene has there");
  expect(is_valid(pose) && is_close(pose, drawn), "its pose is not the one that was drawn");
  expect(is_close(body.at("cam_from_target"), pose_json(drawn)),
         "its quaternion and its rotation are of two poses");
  expect(body.at("features").size() == target.features.size(), "features are missing");
  for (size_t k = 0; k < std::min(body.at("features").size(), target.features.size()); ++k) {
    const Json& feature = body.at("features")[k];
    const auto pixel = project(camera, pose * target.features[k].position_m);
    expect(feature.at("name") == target.features[k].name &&
               (!pixel || is_close(feature.at("pixel"), array_of(*pixel))),
           fmt::format("feature {} is not where its pose puts it", target.features[k].name));
  }
  const int all = body.at("amodal_pixels");
  const int visible = body.at("visible_pixels");
  expect(visible >= 0 && visible <= all, "more pixels are visible than there are");
  const double fraction = all > 0 ? static_cast<double>(visible) / all : 0;
  expect(is_close(body.at("visible_fraction").get<double>(), fraction),
         "the visible fraction is not that of its pixels");
  return problems;
}

std::vector<std::string> part_problems(const fs::path& folder, const SetPlan& plan,
                                       const Json& truth, int64_t index) {
  std::vector<std::string> problems;
  const std::vector<std::string> paths = exact_file_paths(plan, index);
  if (paths.empty()) return problems;
  const Json& camera = truth.at("camera");
  const cv::Size size(camera.at("width_px"), camera.at("height_px"));
  const cv::Mat depth = read_picture(folder / paths[0]);
  const cv::Mat parts = read_picture(folder / paths[1]);
  if (depth.type() != CV_32F || depth.size() != size) problems.push_back(paths[0] + " is torn");
  if (parts.type() != CV_16U || parts.size() != size) problems.push_back(paths[1] + " is torn");
  if (!problems.empty()) return problems;
  int visible = 0;
  for (const Json& body : truth.at("bodies")) visible += body.at("visible_pixels").get<int>();
  if (cv::countNonZero(parts) != visible) {
    problems.push_back(paths[1] + " has other pixels than the bodies are said to have");
  }
  if (cv::countNonZero((depth == depth) != (parts > 0)) != 0) {
    problems.push_back(paths[0] + " and " + paths[1] + " are not of one outline");
  }
  return problems;
}

}  // namespace

std::string truth_path(const SetPlan& plan, int64_t index) {
  return stem_of(plan, index) + ".json";
}

Json truth_of(const SetPlan& plan, const SetImage& image) {
  const Scene& scene = image.drawn.scene;
  Json truth = {{"index", image.index},
                {"seed", plan.study.seed},
                {"condition", plan.study.conditions[plan.study.condition_of(image.index)].label},
                {"redraws", image.drawn.redraws}};
  if (!image.drawn.is_imageable) {
    truth["failure"] = why_not_imageable(scene);
    return truth;
  }
  truth["image"] = plan.format->image_paths(plan, truth).front();
  truth["camera"] = object_of(facts_of(image.frame.truth.camera));
  truth["z0_m"] = z0_of(image);
  truth["scene"] = scene_json(scene);
  truth["bodies"] = Json::array();
  for (size_t i = 0; i < image.frame.truth.bodies.size(); ++i) {
    truth["bodies"].push_back(body_json(plan, image, i));
  }
  return truth;
}

std::string truth_text(const Json& truth) {
  return truth.dump() + "\n";
}

std::vector<SetFile> files_of(const SetPlan& plan, const SetImage& image) {
  Json truth = truth_of(plan, image);
  std::vector<SetFile> files;
  if (image.drawn.is_imageable) {
    files = plan.format->image_files(plan, image);
    for (SetFile& file : truth_files(plan, image)) files.push_back(std::move(file));
    for (const SetFile& file : files) truth[kChecksums][file.path] = crc32_text(file.bytes);
  }
  files.push_back({truth_path(plan, image.index), truth_text(truth)});
  return files;
}

std::vector<std::string> truth_file_paths(const SetPlan& plan, int64_t index) {
  const std::string stem = stem_of(plan, index);
  std::vector<std::string> paths = exact_file_paths(plan, index);
  for (std::string& path : extra_paths(plan.extras, stem)) paths.push_back(std::move(path));
  return paths;
}

std::optional<Json> read_truth(const fs::path& folder, const SetPlan& plan, int64_t index) {
  const fs::path file = folder / truth_path(plan, index);
  try {
    const std::optional<std::string> text = bytes_of_file(file, kMostInputBytes);
    if (!text) return std::nullopt;
    Json truth = parse_json(*text, file.string());
    if (!truth.is_object() || truth_text(truth) != *text) return std::nullopt;
    return truth;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool has_all_files(const fs::path& folder, const SetPlan& plan, int64_t index) {
  const std::optional<Json> truth = read_truth(folder, plan, index);
  if (!truth || truth->contains("failure")) return true;
  try {
    std::vector<std::string> paths = plan.format->image_paths(plan, *truth);
    for (std::string& path : truth_file_paths(plan, index)) paths.push_back(std::move(path));
    return std::ranges::all_of(paths, [&folder](const std::string& path) {
      std::error_code none;
      return fs::exists(folder / path, none);
    });
  } catch (const Json::exception&) {
    return true;
  }
}

std::vector<std::string> truth_problems(const fs::path& folder, const SetPlan& plan,
                                        const Json& truth, int64_t index) {
  const DrawnScene drawn = draw_scene(plan, index);
  const Scene& scene = drawn.scene;
  std::vector<std::string> problems;
  const auto expect = [&](const char* key, const Json& value) {
    if (!is_close(truth.at(key), value)) problems.push_back(fmt::format("{} is wrong", key));
  };
  expect("index", index);
  expect("seed", plan.study.seed);
  expect("condition", plan.study.conditions[plan.study.condition_of(index)].label);
  expect("redraws", drawn.redraws);
  if (!drawn.is_imageable) {
    expect("failure", why_not_imageable(scene));
    return problems;
  }
  expect("image", plan.format->image_paths(plan, truth).front());
  expect("camera", object_of(facts_of(scene.camera)));
  expect("z0_m", scene.cam_from_target.translation.z());
  expect("scene", scene_json(scene));
  const Json& bodies = truth.at("bodies");
  if (bodies.empty() || bodies.size() > 1 + scene.others.size()) {
    problems.push_back("has other bodies than its scene");
    return problems;
  }
  for (size_t i = 0; i < bodies.size(); ++i) {
    const Pose& pose = i == 0 ? scene.cam_from_target : scene.others[i - 1].cam_from_target;
    for (const std::string& problem :
         body_problems(bodies[i], target_of(scene, i), scene.camera, pose)) {
      problems.push_back(fmt::format("body {}: {}", i, problem));
    }
  }
  for (std::string& problem : part_problems(folder, plan, truth, index)) {
    problems.push_back(std::move(problem));
  }
  return problems;
}

std::vector<std::string> checksum_problems(const fs::path& folder, const Json& truth,
                                           std::span<const std::string> paths) {
  std::vector<std::string> problems;
  if (!truth.contains(kChecksums)) return problems;
  const Json& checksums = truth.at(kChecksums);
  for (const std::string& path : paths) {
    const std::optional<std::string> bytes = bytes_of_file(folder / path, kMaxPictureBytes);
    if (!bytes || checksums.value(path, "") != crc32_text(*bytes)) {
      problems.push_back(path + " is not the file that was written with its truth");
    }
  }
  return problems;
}

bool is_in_colour(const Json& truth) {
  if (!truth.contains("scene")) return false;  // one that is being made
  const Json& scene = truth.at("scene");
  return scene.contains("colouring") && scene.at("colouring").at("colour") != "grey";
}

Pose pose_in(const Json& body) {
  const Json& stated = body.at("cam_from_target");
  Pose pose;
  for (int i = 0; i < 9; ++i) {
    pose.rotation(i / 3, i % 3) = stated.at("rotation").at(static_cast<size_t>(i));
  }
  for (int i = 0; i < 3; ++i) {
    pose.translation[i] = stated.at("translation_m").at(static_cast<size_t>(i));
  }
  return pose;
}

}  // namespace sightline
