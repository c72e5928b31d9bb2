// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/camera/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/lenses/catalogue.h"
#include "scenes/camera/lens_numbers.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kMatrix = R"("camera_matrix": {"type_id": "opencv-matrix", "rows": 3,
  "cols": 3, "dt": "d", "data": [400, 0, 310, 0, 410, 230, 0, 0, 1]},
  "image_width": 640, "image_height": 480)";

std::string opencv_json(const std::string& coefficients, int count, const std::string& more = "") {
  return std::string("{") + kMatrix + more +
         R"(, "distortion_coefficients": {"type_id": "opencv-matrix", "rows": 1, "cols": )" +
         std::to_string(count) + R"(, "dt": "d", "data": [)" + coefficients + "]}}";
}

constexpr const char* kCamchain = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.8e-05]
  distortion_model: radtan
  intrinsics: [458.65, 457.29, 367.21, 248.37]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.999, 0.002, -0.002, -0.11]
  - [-0.002, 0.999, -0.014, 0.0004]
  - [0.002, 0.014, 0.999, -0.0006]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.02, 0.005, -0.003,
    0.0004]
  distortion_model: equidistant
  intrinsics: [190.9, 190.8, 254.9, 256.8]
  resolution: [512, 512]
  rostopic: /cam1/image_raw
)";

constexpr const char* kColmap = R"(# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 4
1 SIMPLE_RADIAL 640 480 500 320 240 -0.1
2 OPENCV_FISHEYE 640 480 400 410 320.5 240 -0.02 0.005 -0.003 0.0004
3 FULL_OPENCV 640 480 500 500 320 240 0.9 0.25 0.001 -0.0005 0.01 1.2 0.5 0.05
4 PINHOLE 640 480 500 510 320 240
)";

class CalibrationFile : public testing::Test {
 protected:
  Camera read(const std::string& name, const std::string& text, const std::string& which = "") {
    return read_calibration_file(folder_.write(name, text).string() + which);
  }
  std::string error(const std::string& name, const std::string& text,
                    const std::string& which = "") {
    const std::string line = error_of([&] { read(name, text, which); });
    EXPECT_THAT(line, AllOf(HasSubstr(name + ": "), testing::Not(HasSubstr("\n"))));
    return line;
  }

  TemporaryFolder folder_;
};

TEST_F(CalibrationFile, OpenCvSaysTheModelByTheNumberOfCoefficients) {
  const Camera none = read("c.json", std::string("{") + kMatrix + "}");
  EXPECT_EQ(none.fy_px, 410);
  EXPECT_EQ(none.cx_px, 310);
  EXPECT_EQ(none.width_px, 640);
  EXPECT_TRUE(is_straight(none));
  EXPECT_EQ(read("c.json", opencv_json("-0.1, 0.01, 0.001, 0.002", 4)).lens,
            Lens(BrownConrady{.k1 = -0.1, .k2 = 0.01, .p1 = 0.001, .p2 = 0.002}));
  const Camera eight = read("c.json", opencv_json("0.9,0.25,0.001,0.002,0.01,1.2,0.5,0.05", 8));
  EXPECT_EQ(std::get<RationalLens>(eight.lens).k6, 0.05);
  const Camera twelve =
      read("c.json", opencv_json("0.1,0,0,0,0,0,0,0,0.001,0.002,0.003,0.004", 12));
  EXPECT_EQ(std::get<RationalLens>(twelve.lens).s4, 0.004);
  EXPECT_THAT(error("c.json", opencv_json("0,0,0,0,0,0,0,0,0,0,0,0,0.1,0", 14)),
              HasSubstr("distortion_coefficients has a tilt of the sensor"));
  EXPECT_THAT(error("c.json", opencv_json("0,0,0,0,0,0", 6)),
              HasSubstr("distortion_coefficients has 6 numbers, must have none, 4 or 5"));
}

TEST_F(CalibrationFile, OpenCvSaysAFisheyeByAKey) {
  const std::string k = "-0.02, 0.005, -0.003, 0.0004";
  const Lens fisheye = KannalaBrandt{.k1 = -0.02, .k2 = 0.005, .k3 = -0.003, .k4 = 0.0004};
  EXPECT_EQ(read("c.json", opencv_json(k, 4, R"(, "fisheye_model": 1)")).lens, fisheye);
  EXPECT_EQ(read("c.json", opencv_json(k, 4, R"(, "distortion_model": "equidistant")")).lens,
            fisheye);
  EXPECT_NE(read("c.json", opencv_json(k, 4, R"(, "fisheye_model": 0)")).lens, fisheye);
  EXPECT_THAT(error("c.json", opencv_json(k + ", 0", 5, R"(, "fisheye_model": 1)")),
              HasSubstr("has 5 numbers, must have 4 numbers (k1, k2, k3, k4) of a fisheye lens"));
  EXPECT_THAT(error("c.json", opencv_json(k, 4, R"(, "distortion_model": "omni")")),
              HasSubstr("distortion_model is \"omni\", must be one of fisheye, equidistant"));
}

TEST_F(CalibrationFile, KalibrHasItsCamerasByName) {
  const Camera first = read("camchain.yaml", kCamchain, "#cam0");
  EXPECT_EQ(first.fx_px, 458.65);
  EXPECT_EQ(first.cy_px, 248.37);
  EXPECT_EQ(first.width_px, 752);
  EXPECT_EQ(first.lens, Lens(BrownConrady{.k1 = -0.28, .k2 = 0.07, .p1 = 0.0002, .p2 = 1.8e-05}));
  const Camera second = read("camchain.yaml", kCamchain, "#cam1");
  EXPECT_EQ(second.height_px, 512);
  EXPECT_EQ(std::get<KannalaBrandt>(second.lens).k3, -0.003);
  EXPECT_THAT(error("camchain.yaml", kCamchain),
              HasSubstr("has the cameras cam0, cam1: say which by FILE#cam0"));
  EXPECT_THAT(error("camchain.yaml", kCamchain, "#cam3"), HasSubstr("has no camera cam3"));
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = kCamchain;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(error("camchain.yaml", changed("radtan", "fov"), "#cam0"),
              HasSubstr("cam0: distortion_model is fov, must be radtan, equidistant or none"));
  EXPECT_THAT(error("camchain.yaml", changed("pinhole", "omni"), "#cam0"),
              HasSubstr("cam0: camera_model is omni, must be pinhole"));
  EXPECT_THAT(error("camchain.yaml", changed("[-0.28, ", "["), "#cam0"),
              HasSubstr("cam0: distortion_coeffs has 3 numbers, must have 4"));
}

TEST_F(CalibrationFile, KalibrMayWriteItsListsAsYamlAllows) {
  const std::string text =
      "cam0:\n  T_cam_imu:\n  - [0.1, 0.99, 0.0, 0.06]\n  - [0.0, 0.0, 0.0, 1.0]\n"
      "  camera_model: pinhole\n  distortion_model: 'equidistant'  # a comment\n"
      "  distortion_coeffs: [-0.01, 0.02,\n    0.003, -0.004]\n"
      "  intrinsics:\n  - 461.6\n  - 460.2\n  - 362.6\n  - 246.2\n"
      "  resolution: [752, 480]\n  rostopic: /cam0/image_raw\n";
  const Camera camera = read("chain.yaml", text);
  EXPECT_EQ(camera.cy_px, 246.2);
  EXPECT_EQ(std::get<KannalaBrandt>(camera.lens).k4, -0.004);
  EXPECT_EQ(read("chain.yaml", "%YAML:1.0\n---\n" + text).cy_px, 246.2);
  const auto changed = [&text](const std::string& from, const std::string& to) {
    return std::string(text).replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(error("chain.yaml", changed("461.6", ".inf")),
              HasSubstr("cam0: intrinsics must be [fx, fy, cx, cy]"));
  EXPECT_THAT(error("chain.yaml", changed("'equidistant'", "[1]")),
              HasSubstr("cam0: distortion_model is , must be radtan, equidistant or none"));
}

TEST_F(CalibrationFile, ColmapHasItsCamerasByNumberAndItsPixelsAtHalves) {
  const Camera radial = read("cameras.txt", kColmap, "#1");
  EXPECT_EQ(radial.cx_px, 319.5);
  EXPECT_EQ(radial.fy_px, 500);
  EXPECT_EQ(radial.lens, Lens(BrownConrady{.k1 = -0.1}));
  EXPECT_EQ(std::get<KannalaBrandt>(read("cameras.txt", kColmap, "#2").lens).k4, 0.0004);
  EXPECT_EQ(std::get<RationalLens>(read("cameras.txt", kColmap, "#3").lens).k4, 1.2);
  EXPECT_TRUE(is_straight(read("cameras.txt", kColmap, "#4")));
  EXPECT_EQ(read("cameras.txt", "7 PINHOLE 64 48 500 510 32 24\n").fy_px, 510);
  EXPECT_THAT(error("cameras.txt", kColmap), HasSubstr("has the cameras 1, 2, 3, 4: say which"));
  EXPECT_THAT(error("cameras.txt", "1 FOV 640 480 500 500 320 240 0.9\n"),
              HasSubstr("line 1: MODEL is FOV, must be one of SIMPLE_PINHOLE, PINHOLE"));
  EXPECT_THAT(error("cameras.txt", "1 OPENCV 640 480 500 500 320 240\n"),
              HasSubstr("line 1: OPENCV has 4 parameters, must have 8 (fx, fy, cx, cy, k1"));
  EXPECT_THAT(error("cameras.txt", "# nothing\n1 PINHOLE 640 480 x\n"), HasSubstr("line 2 is"));
  EXPECT_THAT(error("cameras.txt", "# nothing\n"), HasSubstr("has no camera"));
}

TEST_F(CalibrationFile, ALensThatFoldsTheImageIsRefused) {
  EXPECT_THAT(error("c.json", opencv_json("-0.9, 0, 0, 0, 0", 5)),
              HasSubstr("distortion_coefficients cannot be undone at pixel (-0.5, -0.5): the lens "
                        "may fold only outside the image of 640 x 480 px"));
  EXPECT_THAT(error("cameras.txt", "1 OPENCV_FISHEYE 640 480 300 300 320 240 -0.3 0 0 0\n"),
              HasSubstr("line 1: OPENCV_FISHEYE cannot be undone at pixel"));
  // Without fold the corners of a fisheye may see more than 90 degrees: nothing is seen there.
  const Camera wide = read("cameras.txt", "1 OPENCV_FISHEYE 640 480 150 150 320 240 0 0 0 0\n");
  EXPECT_FALSE(normalised_from_pixel(wide, {0, 0}));
  EXPECT_EQ(why_folded(wide), "");
}

TEST_F(CalibrationFile, WhatIsNoneIsSaidSo) {
  EXPECT_THAT(error("c.yaml", "a: [1, 2"), HasSubstr("is no calibration file of OpenCV or Kalibr"));
  EXPECT_THAT(error("c.json", "{\"a\": 1}"), HasSubstr("camera_matrix is missing"));
  EXPECT_THAT(error_of([] { read_calibration_file("none.yaml"); }),
              HasSubstr("none.yaml: is missing or cannot be read"));
}

}  // namespace
}  // namespace sightline
