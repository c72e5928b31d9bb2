// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/speed/write.h"

#include "eval/datasets/pictures.h"
#include "eval/datasets/speed/layout.h"
#include "pose/lenses/catalogue.h"

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
  const double cx = camera.cx_px + kHalfPixel;
  const double cy = camera.cy_px + kHalfPixel;
  Json json = {{"Nu", camera.width_px},
               {"Nv", camera.height_px},
               {"ppx", kPixelPitchM},
               {"ppy", kPixelPitchM},
               {"fx", camera.fx_px * kPixelPitchM},
               {"fy", camera.fy_px * kPixelPitchM},
               {"ccx", cx},
               {"ccy", cy},
               {"cameraMatrix",
                {{camera.fx_px, camera.skew_px, cx}, {0.0, camera.fy_px, cy}, {0.0, 0.0, 1.0}}},
               {"distCoeffs", coefficients_of(camera.lens)}};
  if (std::holds_alternative<KannalaBrandt>(camera.lens)) json[kFisheye] = 1;
  return json.dump(2) + "\n";
}

}  // namespace sightline::speed
