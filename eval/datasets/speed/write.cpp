// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/speed/write.h"

#include "eval/datasets/pictures.h"
#include "eval/datasets/speed/layout.h"

namespace sightline::speed {

std::string picture_name(int64_t index) {
  return "img" + six_digits(index) + ".png";
}

Json list_element(const std::string& picture, const Eigen::Vector4d& q_wxyz,
                  const Eigen::Vector3d& translation_m) {
  const Eigen::Vector4d& q = q_wxyz;
  const Eigen::Vector3d& r = translation_m;
  return {{kPicture, picture},
          {kAttitude, {q[0], q[1], q[2], q[3]}},
          {kPosition, {r.x(), r.y(), r.z()}}};
}

std::string camera_file(const Camera& camera) {
  const BrownConrady& lens = camera.distortion;
  const double cx = camera.cx_px + kHalfPixel;
  const double cy = camera.cy_px + kHalfPixel;
  const Json json = {
      {"Nu", camera.width_px},
      {"Nv", camera.height_px},
      {"ppx", kPixelPitchM},
      {"ppy", kPixelPitchM},
      {"fx", camera.fx_px * kPixelPitchM},
      {"fy", camera.fy_px * kPixelPitchM},
      {"ccx", cx},
      {"ccy", cy},
      {"cameraMatrix", {{camera.fx_px, 0.0, cx}, {0.0, camera.fy_px, cy}, {0.0, 0.0, 1.0}}},
      {"distCoeffs", {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3}}};
  return json.dump(2) + "\n";
}

}  // namespace sightline::speed
