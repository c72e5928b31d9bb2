// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Image sets in SPEED+'s format (datasets/speed/layout.h).
#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "eval/datasets/model_file.h"
#include "eval/datasets/pictures.h"
#include "eval/datasets/speed/layout.h"
#include "eval/datasets/speed/write.h"
#include "eval/image_sets/set_format.h"
#include "eval/image_sets/truth.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

std::string picture_path(int64_t index) {
  return fmt::format("{}/{}", speed::kImagesFolder, speed::picture_name(index));
}

std::vector<std::string> speed_image_paths(const SetPlan&, const Json& truth) {
  return {picture_path(truth.at("index"))};
}

std::vector<SetFile> speed_image_files(const SetPlan&, const SetImage& image) {
  const Frame& frame = image.frame;
  return {
      {picture_path(image.index), png_bytes(frame.colour.empty() ? frame.image : frame.colour)}};
}

std::vector<std::string> speed_image_problems(const SetPlan& plan,
                                              const std::filesystem::path& folder,
                                              const Json& truth) {
  const std::string path = speed_image_paths(plan, truth).front();
  const cv::Mat picture = read_picture(folder / path);
  const Json& camera = truth.at("camera");
  const int depth = truth.at("scene").at("sensor").at("bits") > 8 ? CV_16U : CV_8U;
  const int type = CV_MAKETYPE(depth, is_in_colour(truth) ? 3 : 1);
  if (picture.cols == camera.at("width_px") && picture.rows == camera.at("height_px") &&
      picture.type() == type) {
    return {};
  }
  return {path + " is torn, or not of the camera's size"};
}

std::vector<SetFile> speed_chunk_files(const SetPlan&, int64_t, std::span<const Json>) {
  return {};
}

std::vector<Json> speed_list_elements(const SetPlan&, const Json& truth) {
  const Json& pose = truth.at("bodies").at(0).at("cam_from_target");
  const std::vector<double> q = numbers_in(pose, "q_wxyz", 4);
  const std::vector<double> t = numbers_in(pose, "translation_m", 3);
  return {speed::list_element(speed::picture_name(truth.at("index")), Eigen::Vector4d(q.data()),
                              Eigen::Vector3d(t.data()))};
}

std::string conventions(const SetPlan& plan) {
  const EncodingText encoding = encoding_text(plan);
  return fmt::format(
      R"(# {}

{} images rendered by Sightline {} from scene.toml with seed {}, in the format of SPEED+.

- images/: {}; white is {}. {}
- train.json: x_cam = R(q) x_target + r, q = q_vbs2tango_true scalar first, r = r_Vo2To_vbs_true in
  metres. Camera: x right, y down, z forward.
- camera.json: as SPEED+ has it, the image's top-left corner is (0, 0), so that the centre of the
  first pixel is (0.5, 0.5). In sightline/ that centre is (0, 0): principal points differ by 0.5.
  fx, fy are in metres of a nominal pixel pitch of {} um.
- model/target.ply: the target, millimetres.
)",
      plan.study.name, plan.count, SIGHTLINE_VERSION, plan.study.seed, encoding.grey,
      (1 << plan.images().setups.front().scene.sensor.bits) - 1, encoding.sentence,
      1e6 * speed::kPixelPitchM);
}

std::vector<SetFile> speed_set_files(const SetPlan& plan) {
  return {{std::string(speed::kCameraFile),
           speed::camera_file(plan.images().setups.front().scene.camera)},
          {"conventions.md", conventions(plan)},
          {std::string(speed::kModelFile), ply_bytes(plan.images().target->mesh)}};
}

}  // namespace

SetFormat speed_format() {
  static const std::string kList = fmt::format("{}.json", speed::kLists.front());
  return {.name = "speed",
          .summary = "SPEED+, of one target",
          .lens_note = "",
          .image_files = speed_image_files,
          .image_paths = speed_image_paths,
          .image_problems = speed_image_problems,
          .told_by_files = nullptr,
          .chunk_files = speed_chunk_files,
          .list_path = kList,
          .list_elements = speed_list_elements,
          .set_files = speed_set_files};
}

}  // namespace sightline
