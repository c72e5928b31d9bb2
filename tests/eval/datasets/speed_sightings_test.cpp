// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// SPEED+ and SPEED sets as others write them, read by the documentation of their formats alone.
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "eval/datasets/sightings.h"
#include "scenes/files/input_file.h"
#include "scenes/picture/picture_file.h"
#include "scenes/target/target.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/packed_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kWidthPx = 320, kHeightPx = 240;

class ForeignSpeed : public testing::Test {
 protected:
  ForeignSpeed() {
    fs::create_directories(folder_.path() / "synthetic/images");
    folder_.write("synthetic/images/img1.jpg",
                  jpeg_bytes(cv::Mat(kHeightPx, kWidthPx, CV_8U, cv::Scalar(40))));
    folder_.write("camera.json",
                  R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 2e-5, "fx": 0.009, "fy": 0.0183,
                      "ccx": 160, "ccy": 120, "cameraMatrix": [[900, 0, 160], [0, 915, 120],
                      [0, 0, 1]], "distCoeffs": [-0.1, 0.02, 0.003, 0.004, 0.05]})");
    folder_.write("synthetic/train.json", kList);
  }
  SightingSource source(const std::string& folder, const std::string& split) const {
    SightingSource source;
    source.folder = folder_.path() / folder;
    source.split = split;
    return source;
  }
  const std::string kList =
      R"([{"filename": "img1.jpg", "q_vbs2tango_true": [0.6, 0, 0, 0.8],
           "r_Vo2To_vbs_true": [0.1, -0.2, 10]}])";
  TemporaryFolder folder_;
  std::shared_ptr<const Target> cube_ = load_target("cube");
};

TEST_F(ForeignSpeed, IsReadByItsDocumentation) {
  for (const auto& sightings : {read_sightings(source("synthetic", ""), cube_).sightings,
                                read_sightings(source("", "synthetic/train"), cube_).sightings}) {
    ASSERT_EQ(sightings.size(), 1u);
    const Sighting& sighting = sightings[0];
    EXPECT_EQ(sighting.camera.fy_px, 915);
    EXPECT_EQ(sighting.camera.cx_px, 159.5);  // its pixels begin at 0, ours at -0.5
    EXPECT_EQ(sighting.camera.cy_px, 119.5);
    EXPECT_EQ(std::get<BrownConrady>(sighting.camera.lens).k1, -0.1);
    EXPECT_EQ(std::get<BrownConrady>(sighting.camera.lens).p2, 0.004);
    EXPECT_EQ(std::get<BrownConrady>(sighting.camera.lens).k3, 0.05);
    const Eigen::Matrix3d& r = sighting.cam_from_target.rotation;
    EXPECT_NEAR(r(0, 0), -0.28, 1e-12);  // cos of 2 acos(0.6), about z
    EXPECT_NEAR(r(1, 0), 0.96, 1e-12);
    EXPECT_NEAR(r(2, 2), 1, 1e-12);
    EXPECT_EQ(sighting.cam_from_target.translation, Eigen::Vector3d(0.1, -0.2, 10));
  }
}

TEST_F(ForeignSpeed, OfTheFirstChallengeIsReadToo) {
  fs::create_directories(folder_.path() / "images/train");
  fs::rename(folder_.path() / "synthetic/images/img1.jpg",
             folder_.path() / "images/train/img1.jpg");
  folder_.write("camera.json", R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 2e-5, "fx": 0.009,
                                   "fy": 0.0183})");
  folder_.write("train.json", R"([{"filename": "img1.jpg", "q_vbs2tango": [1, 0, 0, 0],
                                   "r_Vo2To_vbs_true": [0.1, -0.2, 10]}])");
  const auto sightings = read_sightings(source("", ""), cube_).sightings;
  EXPECT_NEAR(sightings[0].camera.fx_px, 900, 1e-9);
  EXPECT_NEAR(sightings[0].camera.fy_px, 915, 1e-9);
  EXPECT_EQ(sightings[0].camera.cx_px, 159.5);
  EXPECT_EQ(sightings[0].image, "images/train/img1.jpg");
}

// Its principal point is not the picture's middle; some write focal lengths in pixels, matrices in
// one row and other numbers of coefficients.
TEST_F(ForeignSpeed, HasItsCameraInManyWays) {
  const auto camera = [this](const std::string& text) {
    folder_.write("camera.json", text);
    return read_sightings(source("synthetic", ""), cube_).sightings.front().camera;
  };
  const Camera stated = camera(
      R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 2e-5, "fx": 0.009, "fy": 0.0183, "ccx": 150,
          "ccy": 130, "distCoeffs": [0.1, 0.2, 0.3, 0.4]})");
  EXPECT_EQ(stated.cx_px, 149.5);
  EXPECT_EQ(stated.cy_px, 129.5);
  EXPECT_EQ(std::get<BrownConrady>(stated.lens).p2, 0.4);
  EXPECT_EQ(std::get<BrownConrady>(stated.lens).k3, 0);
  const Camera in_pixels = camera(R"({"Nu": 320, "Nv": 240, "ppx": 1e-5, "ppy": 1e-5, "fx": 900,
                                      "fy": 915, "distCoeffs": [[1, 2, 3, 4, 5, 0, 0, 0]]})");
  EXPECT_EQ(in_pixels.fx_px, 900);
  const Camera in_pixels_and_mm =
      camera(R"({"Nu": 320, "Nv": 240, "ppx": 0.00586, "ppy": 0.00586, "fx": 2988.58, "fy": 400})");
  EXPECT_EQ(in_pixels_and_mm.fx_px, 2988.58);
  EXPECT_EQ(in_pixels_and_mm.fy_px, 400);
  const Camera in_mm =
      camera(R"({"Nu": 320, "Nv": 240, "ppx": 0.01, "ppy": 0.02, "fx": 17.6, "fy": 9})");
  EXPECT_DOUBLE_EQ(in_mm.fx_px, 1760);
  EXPECT_DOUBLE_EQ(in_mm.fy_px, 450);
  EXPECT_EQ(std::get<BrownConrady>(in_pixels.lens).k3, 5);
  EXPECT_EQ(camera(R"({"cameraMatrix": [900, 0, 160, 0, 915, 120, 0, 0, 1]})").fy_px, 915);
  const std::string matrix = R"({"cameraMatrix": [900, 2, 160, 0, 915, 120, 0, 0, 1],)";
  const Camera rational = camera(matrix + R"("distCoeffs": [1, 2, 3, 4, 5, 6, 0, 0]})");
  EXPECT_EQ(std::get<RationalLens>(rational.lens).k4, 6);
  EXPECT_EQ(rational.skew_px, 2);
  const Camera fisheye = camera(matrix + R"("fisheye_model": 1, "distCoeffs": [1, 2, 3, 4]})");
  EXPECT_EQ(std::get<KannalaBrandt>(fisheye.lens).k4, 4);
  EXPECT_THAT(error_of([&] { camera(matrix + R"("distCoeffs": [1, 2, 3, 4, 5, 6]})"); }),
              HasSubstr("camera.json: distCoeffs has 6 numbers, must have none, 4 or 5"));
}

TEST_F(ForeignSpeed, HasOneFailureAPictureOrPoseThatIsMissing) {
  folder_.write("synthetic/train.json",
                R"([{"filename": "img1.jpg", "q_vbs2tango_true": [0.6, 0, 0, 0.8],
                     "r_Vo2To_vbs": [0.1, -0.2, 10]},
                    {"filename": "img2.jpg", "q_vbs2tango_true": [0.6, 0, 0, 0.8],
                     "r_Vo2To_vbs": [0.1, -0.2, 10]},
                    {"filename": "img1.jpg", "q_vbs2tango_true": [0.6, 0, 0, NaN],
                     "r_Vo2To_vbs": [0.1, -0.2, 10]}])");
  const auto sightings = read_sightings(source("synthetic", ""), cube_).sightings;
  ASSERT_EQ(sightings.size(), 3u);
  EXPECT_FALSE(sightings[0].problem);
  EXPECT_EQ(sightings[1].problem, EstimateOutcome::kPictureUnreadable);
  EXPECT_EQ(sightings[2].problem, EstimateOutcome::kNoTruth);
}

// As SHIRT has them, by orbit.
TEST_F(ForeignSpeed, HasListsOfAnyNameWhichAreOffered) {
  fs::remove(folder_.path() / "synthetic/train.json");
  for (const std::string orbit : {"roe1", "roe2"}) {
    folder_.write("synthetic/" + orbit + ".json", kList);
  }
  EXPECT_THAT(error_of([&] { read_sightings(source("synthetic", ""), cube_); }),
              HasSubstr("has roe1.json and roe2.json; say --split which one is meant"));
  EXPECT_EQ(read_sightings(source("synthetic", "roe2"), cube_).sightings.size(), 1u);
  EXPECT_THAT(error_of([&] { read_sightings(source("", ""), cube_); }),
              HasSubstr("has synthetic/roe1.json and synthetic/roe2.json; say --split"));
}

TEST_F(ForeignSpeed, IsReadWhereGzipPackedIt) {
  fs::create_directories(folder_.path() / "synthetic/images/train");
  fs::rename(folder_.path() / "synthetic/images/img1.jpg",
             folder_.path() / "synthetic/images/train/img1.jpg");
  for (const char* name : {"camera.json", "synthetic/train.json"}) {
    const fs::path file = folder_.path() / name;
    write_packed(file.string() + ".gz", read_input_file(file, kMostInputBytes));
    fs::remove(file);
  }
  for (const char* split : {"", "train"}) {
    const auto sightings = read_sightings(source("synthetic", split), cube_).sightings;
    ASSERT_EQ(sightings.size(), 1u);
    EXPECT_EQ(sightings[0].camera.fy_px, 915);
    EXPECT_EQ(sightings[0].image, "images/train/img1.jpg");
    EXPECT_EQ(sightings[0].cam_from_target.translation.z(), 10);
  }
  // A list of any name is found by how it begins; what only looks packed is none.
  fs::rename(folder_.path() / "synthetic/train.json.gz", folder_.path() / "synthetic/mine.json.gz");
  fs::rename(folder_.path() / "synthetic/images/train", folder_.path() / "synthetic/images/mine");
  EXPECT_EQ(read_sightings(source("synthetic", ""), cube_).sightings.size(), 1u);
  EXPECT_EQ(read_sightings(source("", "synthetic/mine"), cube_).sightings.size(), 1u);
  folder_.write("synthetic/torn.json.gz", "\x1f\x8b q_vbs2tango");
  EXPECT_EQ(read_sightings(source("synthetic", ""), cube_).sightings.size(), 1u);
}

// Scalar last, most of these turn the camera's view away: of three poses one stays in the image.
TEST_F(ForeignSpeed, GetsAHintWhereMostPosesAreOutOfTheImage) {
  const auto notes = [this](const std::string& aside) {
    folder_.write("synthetic/train.json",
                  "[" + kList.substr(1, kList.size() - 2) + "," +
                      R"({"filename": "img1.jpg", "q_vbs2tango": [1, 0, 0, 0],
                          "r_Vo2To_vbs": [)" +
                      aside + R"(, 0, 10]},
                         {"filename": "img1.jpg", "q_vbs2tango": [1, 0, 0, 0],
                          "r_Vo2To_vbs": [)" +
                      aside + ", 1, 10]}]");
    return read_sightings(source("synthetic", ""), cube_).notes;
  };
  EXPECT_THAT(notes("0"), testing::IsEmpty());
  EXPECT_THAT(notes("90"), testing::ElementsAre(testing::AllOf(
                               HasSubstr("2 of 3 poses do not put 'cube' into its image"),
                               HasSubstr("quaternions are read scalar first"))));
}

// The same camera and pose in all ways at random (SPEED, SPEED+, SHIRT, and who writes them anew).
TEST_F(ForeignSpeed, InRandomWaysIsReadToTheSameNumbers) {
  const auto digest = [](const Sighting& s) {
    const Camera& c = s.camera;
    return std::vector<double>{c.fx_px,
                               c.fy_px,
                               c.cx_px,
                               c.cy_px,
                               std::get<BrownConrady>(c.lens).k1,
                               std::get<BrownConrady>(c.lens).p2,
                               s.cam_from_target.rotation(1, 0),
                               s.cam_from_target.translation.z(),
                               static_cast<double>(c.width_px)};
  };
  const std::vector<double> plain{900, 915, 159.5, 119.5, -0.1, 0.004, 0.96, 10, kWidthPx};
  std::mt19937 engine(1);
  const auto one_of = [&engine](const std::vector<std::string>& ways) {
    return ways[engine() % ways.size()];
  };
  for (int round = 0; round < 40; ++round) {
    const std::string camera =
        one_of({"", "\xEF\xBB\xBF"}) + R"({"Nu": 320, "Nv": 240, )" +
        one_of({R"("fx": 0.009, "fy": 0.0183, "ppx": 1e-5, "ppy": 2e-5, "ccx": 160, "ccy": 120, )",
                R"("fx": 0.009, "fy": 0.0183, "ppx": 1e-5, "ppy": 2e-5, )",
                R"("fx": 900, "fy": 915, "ppx": 1e-5, "ppy": 2e-5, "ccx": 160, )",
                R"("fx": 900, "fy": 915, )",
                R"("cameraMatrix": [900, 0, 160, 0, 915, 120, 0, 0, 1], )",
                R"("cameraMatrix": [[900, 0, 160], [0, 915, 120], [0, 0, 1]], )"}) +
        R"("distCoeffs": )" +
        one_of({"[-0.1, 0.02, 0.003, 0.004]", "[-0.1, 0.02, 0.003, 0.004, 0]",
                "[[-0.1, 0.02, 0.003, 0.004, 0]]", "[[-0.1], [0.02], [0.003], [0.004], [0]]",
                "[-0.1, 0.02, 0.003, 0.004, 0, 0, 0, 0]"}) +
        "}";
    const std::string list =
        R"([{"filename": "img1.jpg", ")" + one_of({"q_vbs2tango_true", "q_vbs2tango"}) + R"(": )" +
        one_of({"[0.6, 0, 0, 0.8]", "[-0.6, 0, 0, -0.8]", "[[0.6, 0, 0, 0.8]]"}) + ", \"" +
        one_of({"r_Vo2To_vbs_true", "r_Vo2To_vbs"}) + R"(": )" +
        one_of({"[0.1, -0.2, 10]", "[[0.1], [-0.2], [10]]"}) + "}]";
    const std::string split = one_of({"train", "test", "roe1"});
    fs::remove(folder_.path() / "synthetic/train.json");
    folder_.write("camera.json", camera);
    folder_.write("synthetic/" + split + ".json", list);
    const auto read =
        digest(read_sightings(source("synthetic", one_of({"", split})), cube_).sightings.front());
    EXPECT_THAT(read, testing::Pointwise(testing::DoubleNear(1e-9), plain)) << camera << list;
    fs::remove(folder_.path() / ("synthetic/" + split + ".json"));
  }
}

TEST_F(ForeignSpeed, IsRefusedInOneLineThatNamesTheFile) {
  const auto error = [this] {
    return error_of([this] { read_sightings(source("synthetic", ""), cube_); });
  };
  EXPECT_EQ(error(), "");
  folder_.write("synthetic/validation.json", "[]");
  EXPECT_THAT(error(), HasSubstr("has train.json and validation.json; say --split"));
  fs::remove(folder_.path() / "synthetic/validation.json");
  folder_.write("synthetic/train.json", R"([{"filename": "img1.jpg"}])");
  EXPECT_THAT(error(),
              HasSubstr("train.json: is not as its format has it: has no 'q_vbs2tango_true'"));
  folder_.write("secret.png", "");
  for (const std::string name : {"../../secret.png", "/etc/passwd", "a/../../../secret.png"}) {
    folder_.write("synthetic/train.json", "[{\"filename\": \"" + name + "\"}]");
    EXPECT_THAT(error(),
                HasSubstr("train.json: names " + name + ", which must lie within the set"));
  }
  folder_.write("synthetic/train.json", "[]");
  EXPECT_THAT(error(), HasSubstr("train.json: lists no image"));
  folder_.write("synthetic/train.json", R"([{"filename": "img1.jpg",
      "q_vbs2tango_true": [2, 0, 0, 0], "r_Vo2To_vbs_true": [0, 0, 10]}])");
  EXPECT_THAT(error(), HasSubstr("none of its 1 true poses is one"));
  folder_.write("synthetic/train.json", R"([{"filename": "img1.jpg",
      "q_vbs2tango_true": [1, 0, 0, 0], "r_Vo2To_vbs_true": [0, 0, -10]}])");
  EXPECT_THAT(error(), HasSubstr("none of its 1 poses puts 'cube' into its image"));
  // In millimetres a cube of a metre is 0.2 px; in kilometres the camera stands within it.
  for (const auto& [z, reason] : {std::pair("10000", "it is smaller than 2 px"),
                                  std::pair("0.01", "the camera stands within its box")}) {
    folder_.write("synthetic/train.json",
                  std::string(R"([{"filename": "img1.jpg", "q_vbs2tango_true": [1, 0, 0, 0],
                                   "r_Vo2To_vbs_true": [0, 0, )") +
                      z + "]}]");
    EXPECT_THAT(error(), testing::AllOf(HasSubstr(reason), HasSubstr("in m in SPEED+")));
  }
  folder_.write("synthetic/train.json", kList);
  SightingSource of_sensor = source("synthetic", "");
  of_sensor.sensor = "left";
  EXPECT_THAT(error_of([&] { read_sightings(of_sensor, cube_); }),
              HasSubstr("no --sensor can be chosen"));
  fs::remove(folder_.path() / "camera.json");
  EXPECT_THAT(error(), HasSubstr("camera.json: is missing"));
}

}  // namespace
}  // namespace sightline
