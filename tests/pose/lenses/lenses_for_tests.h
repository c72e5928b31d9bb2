// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pose/camera.h"

namespace sightline {

struct NamedCamera {
  std::string name;
  Camera camera;
};

/// A wide camera through each model, with a skew, and with its principal point off the image. The
/// coefficients are of the size that calibrations give; the images have no fold.
inline std::vector<NamedCamera> cameras_with_lenses() {
  Camera wide = centred_camera(640, 480, 400);
  wide.fy_px = 410;
  wide.cx_px = 300.25;
  std::vector<NamedCamera> cameras;
  const auto add = [&](const char* name, const Lens& lens) {
    cameras.push_back({name, wide});
    cameras.back().camera.lens = lens;
  };
  add("brown_conrady", BrownConrady{.k1 = -0.28, .k2 = 0.09, .p1 = 1e-3, .p2 = -5e-4, .k3 = -0.01});
  add("rational", RationalLens{.k1 = 0.9,
                               .k2 = 0.25,
                               .p1 = 1e-3,
                               .p2 = -5e-4,
                               .k3 = 0.01,
                               .k4 = 1.2,
                               .k5 = 0.5,
                               .k6 = 0.05});
  add("rational with a thin prism", RationalLens{.k1 = -0.3,
                                                 .k2 = 0.1,
                                                 .p1 = 1e-3,
                                                 .p2 = 2e-3,
                                                 .k3 = -0.01,
                                                 .k4 = 0.02,
                                                 .k5 = 0.01,
                                                 .k6 = 0.001,
                                                 .s1 = 2e-3,
                                                 .s2 = -1e-3,
                                                 .s3 = 1e-3,
                                                 .s4 = 5e-4});
  add("fisheye", KannalaBrandt{.k1 = -0.02, .k2 = 0.005, .k3 = -0.003, .k4 = 0.0004});
  add("equidistant", KannalaBrandt{});
  cameras.push_back({"skew alone", wide});
  cameras.back().camera.skew_px = 12;
  cameras.push_back({"skewed fisheye off the image", cameras[3].camera});
  Camera& off = cameras.back().camera;
  off.skew_px = -7;
  off.cx_px = -80;
  off.cy_px = 520;
  return cameras;
}

}  // namespace sightline
