// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/bop/write.h"

#include <limits>
#include <map>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/layout.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/model_file.h"
#include "scenes/mesh/diameter.h"

namespace sightline::bop {
namespace {

Json box_entry(const cv::Rect& box, bool is_seen) {
  if (!is_seen) return {-1, -1, -1, -1};
  return {box.x, box.y, box.width - 1, box.height - 1};
}

}  // namespace

Json camera_entry(const Camera& camera, double depth_scale) {
  return {{"cam_K",
           {camera.fx_px, camera.skew_px, camera.cx_px, 0.0, camera.fy_px, camera.cy_px, 0.0, 0.0,
            1.0}},
          {"depth_scale", depth_scale}};
}

Json truth_entry(int64_t obj_id, const Pose& cam_from_model) {
  const Eigen::Vector3d t_mm = kMillimetresPerMetre * cam_from_model.translation;
  return {{"cam_R_m2c", rows_of(cam_from_model.rotation)},
          {"cam_t_m2c", {t_mm.x(), t_mm.y(), t_mm.z()}},
          {"obj_id", obj_id}};
}

Json info_entry(const Visibility& seen) {
  const bool is_seen = seen.visible_pixels > 0;
  return {{"bbox_obj", box_entry(seen.whole_box, is_seen)},
          {"bbox_visib", box_entry(seen.visible_box, is_seen)},
          {"px_count_all", seen.whole_pixels},
          {"px_count_valid", seen.pixels_with_depth},
          {"px_count_visib", seen.visible_pixels},
          {"visib_fract", seen.visible_fraction}};
}

std::string scene_file(std::span<const ImageEntry> images) {
  std::string text = "{";
  for (const ImageEntry& image : images) {
    text += fmt::format("{}\n  \"{}\": {}", text.size() > 1 ? "," : "", image.im_id,
                        image.entry.dump());
  }
  return text + "\n}\n";
}

std::vector<Json> target_elements(int64_t scene_id, int64_t im_id,
                                  std::span<const std::pair<int, double>> instances) {
  std::map<int, int> counts;
  for (const auto& [obj_id, visible_fraction] : instances) {
    if (visible_fraction >= kLeastVisibleFraction) ++counts[obj_id];
  }
  std::vector<Json> elements;
  for (const auto& [obj_id, count] : counts) {
    elements.push_back(
        {{"im_id", im_id}, {"inst_count", count}, {"obj_id", obj_id}, {"scene_id", scene_id}});
  }
  return elements;
}

std::string camera_file(const Camera& camera, double depth_scale) {
  const Json json = {{"cx", camera.cx_px},      {"cy", camera.cy_px}, {"depth_scale", depth_scale},
                     {"fx", camera.fx_px},      {"fy", camera.fy_px}, {"height", camera.height_px},
                     {"width", camera.width_px}};
  return json.dump(2) + "\n";
}

Json model_info(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    points.emplace_back(ply_vertex_mm(vertex).cast<double>());
    box.extend(points.back());
  }
  const Eigen::Vector3d size = box.sizes();
  return {{"diameter", diameter(std::move(points))},
          {"min_x", box.min().x()},
          {"min_y", box.min().y()},
          {"min_z", box.min().z()},
          {"size_x", size.x()},
          {"size_y", size.y()},
          {"size_z", size.z()}};
}

std::vector<SetFile> model_files(std::span<const Mesh* const> meshes, bool is_in_colour) {
  std::vector<SetFile> files;
  Json infos = Json::object();
  for (size_t i = 0; i < meshes.size(); ++i) {
    const auto obj_id = static_cast<int64_t>(i) + 1;
    infos[fmt::to_string(obj_id)] = model_info(*meshes[i]);
    const std::string bytes = ply_bytes(*meshes[i]);
    const std::string shown = is_in_colour ? coloured_ply_bytes(*meshes[i]) : bytes;
    files.push_back({fmt::format("{}/{}", kModelsFolder, model_file(obj_id)), shown});
    files.push_back({fmt::format("{}/{}", kEvaluatedModelsFolder, model_file(obj_id)), bytes});
  }
  for (const std::string_view folder : {kModelsFolder, kEvaluatedModelsFolder}) {
    files.push_back({fmt::format("{}/{}", folder, kModelsInfoFile), infos.dump(2) + "\n"});
  }
  return files;
}

cv::Mat depth_steps(const cv::Mat& depth_m, double depth_scale) {
  constexpr double kLargest = std::numeric_limits<uint16_t>::max();
  const double steps_a_m = kMillimetresPerMetre / depth_scale;
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

}  // namespace sightline::bop
