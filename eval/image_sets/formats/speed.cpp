// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The format of SPEED+ (Park et al., IEEE Aerospace Conference 2022): one target, x_cam = R(q) x +
// r with q_vbs2tango_true scalar first and r_Vo2To_vbs_true in metres. Its cameras have their
// principal point at half the image's size, so pixel (0, 0) begins at the image's corner: half a
// pixel is added to ours.
#include <fmt/format.h>

#include "eval/datasets/pictures.h"
#include "eval/image_sets/formats/formats.h"
#include "eval/image_sets/models.h"
#include "eval/image_sets/truth.h"

namespace sightline {
namespace {

constexpr double kHalfPixel = 0.5;
constexpr double kPixelPitch_m = 1e-5;  // the format wants one; ours has no size in metres

std::string file_name(int64_t index) {
  return "img" + six_digits(index) + ".png";
}

std::vector<std::string> image_paths(const SetPlan&, const Json& truth) {
  return {"images/" + file_name(truth.at("index"))};
}

std::vector<SetFile> image_files(const SetPlan&, const SetImage& image) {
  return {{"images/" + file_name(image.index), png_bytes(image.frame.image)}};
}

std::vector<std::string> image_problems(const SetPlan& plan, const std::filesystem::path& folder,
                                        const Json& truth) {
  const std::string path = image_paths(plan, truth).front();
  const cv::Mat picture = read_picture(folder / path);
  const Json& camera = truth.at("camera");
  const int type = truth.at("scene").at("sensor").at("bits") > 8 ? CV_16U : CV_8U;
  if (picture.cols == camera.at("width_px") && picture.rows == camera.at("height_px") &&
      picture.type() == type) {
    return {};
  }
  return {path + " is torn, or not of the camera's size"};
}

std::vector<SetFile> chunk_files(const SetPlan&, int64_t, std::span<const Json>) {
  return {};
}

std::vector<Json> list_elements(const SetPlan&, const Json& truth) {
  const Json& pose = truth.at("bodies").at(0).at("cam_from_target");
  std::vector<Json> elements;
  elements.push_back({{"filename", file_name(truth.at("index"))},
                      {"q_vbs2tango_true", pose.at("q_wxyz")},
                      {"r_Vo2To_vbs_true", pose.at("translation_m")}});
  return elements;
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
      1e6 * kPixelPitch_m);
}

std::vector<SetFile> set_files(const SetPlan& plan) {
  const Camera& camera = plan.images().setups.front().scene.camera;
  const BrownConrady& lens = camera.distortion;
  const double cx = camera.cx_px + kHalfPixel;
  const double cy = camera.cy_px + kHalfPixel;
  const Json json = {
      {"Nu", camera.width_px},
      {"Nv", camera.height_px},
      {"ppx", kPixelPitch_m},
      {"ppy", kPixelPitch_m},
      {"fx", camera.fx_px * kPixelPitch_m},
      {"fy", camera.fy_px * kPixelPitch_m},
      {"ccx", cx},
      {"ccy", cy},
      {"cameraMatrix", {{camera.fx_px, 0.0, cx}, {0.0, camera.fy_px, cy}, {0.0, 0.0, 1.0}}},
      {"distCoeffs", {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}}};
  return {{"camera.json", json.dump(2) + "\n"},
          {"conventions.md", conventions(plan)},
          {"model/target.ply", ply_bytes(plan.images().target->mesh)}};
}

}  // namespace

SetFormat speed_format() {
  return {.name = "speed",
          .summary = "SPEED+, of one target",
          .image_files = image_files,
          .image_paths = image_paths,
          .image_problems = image_problems,
          .chunk_files = chunk_files,
          .list_path = "train.json",
          .list_elements = list_elements,
          .set_files = set_files};
}

}  // namespace sightline
