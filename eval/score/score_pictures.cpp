// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/score_pictures.h"

#include <array>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>
#include <opencv2/core.hpp>

#include "eval/datasets/pictures.h"
#include "eval/output/numbers.h"
#include "eval/report/frame_svg.h"
#include "eval/report/outline.h"
#include "eval/report/page_text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

Camera camera_of(const BopImage& image, const cv::Size& size) {
  return {.width_px = size.width,
          .height_px = size.height,
          .fx_px = image.k(0, 0),
          .fy_px = image.k(1, 1),
          .cx_px = image.k(0, 2),
          .cy_px = image.k(1, 2),
          .lens = {}};
}

cv::Rect box_of(const std::array<Outline, 2>& outlines) {
  cv::Rect box;
  for (const Outline& outline : outlines) {
    for (const auto& polygon : outline) {
      for (const Eigen::Vector2d& p : polygon) {
        box |= cv::Rect(cvFloor(p.x()), cvFloor(p.y()), 2, 2);
      }
    }
  }
  return box;
}

mustache::data picture_data(const BopDataset& dataset, const BopTarget& target,
                            const BopEstimate& estimate, const cv::Mat& grey) {
  constexpr int kBits = 16;  // of a picture of more than 8
  const BopImage& image = dataset.images[target.image];
  const Mesh& mesh = dataset.models.at(target.obj_id).mesh_mm;
  const Camera camera = camera_of(image, grey.size());
  const std::array<Outline, 2> outlines = {
      mesh_outline(mesh, camera, image.instances[target.instance].cam_from_model),
      mesh_outline(mesh, camera, estimate.cam_from_model)};
  const FramePicture picture = picture_of(grey, kBits, box_of(outlines));
  mustache::data paths(mustache::data::type::list);
  for (size_t i = 0; i < outlines.size(); ++i) {
    paths << mustache::object{{"style", fmt::to_string(i)}, {"path", outline_path(outlines[i])}};
  }
  return mustache::object{
      {"caption", fmt::format("Scene {}, image {}, object {}, instance {}: MSSD {} mm",
                              image.scene_id, image.im_id, target.obj_id, target.instance,
                              measure(target.pairs[*target.chosen].mssd_mm))},
      {"view", view_box(picture.pixels)},
      {"x", fmt::format("{}", picture.pixels.x - 0.5)},
      {"y", fmt::format("{}", picture.pixels.y - 0.5)},
      {"width", fmt::to_string(picture.pixels.width)},
      {"height", fmt::to_string(picture.pixels.height)},
      {"png", picture.png_url},
      {"outlines", paths}};
}

}  // namespace

std::string score_pictures(const BopDataset& dataset, std::span<const BopTarget* const> targets,
                           std::span<const BopEstimate> estimates) {
  mustache::data pictures(mustache::data::type::list);
  for (const BopTarget* target : targets) {
    const auto file = bop_picture(dataset.images[target->image]);
    const cv::Mat grey = file.empty() ? cv::Mat() : read_grey_picture(file);
    if (grey.empty() || !target->chosen) continue;
    const size_t estimate = target->pairs[*target->chosen].estimate;
    mustache::data picture = picture_data(dataset, *target, estimates[estimate], grey);
    picture.set("number", fmt::to_string(pictures.list_value().size() + 1));
    pictures << picture;
  }
  if (pictures.list_value().empty()) return "";
  return mustache::mustache(page_text("score_pictures.mustache"))
      .render(mustache::object{{"pictures", pictures}});
}

}  // namespace sightline
