// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files of observations that are made by hand, about pictures whose truth is known.
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/doors/observation_file.h"
#include "scenes/random/random.h"
#include "scenes/target/target.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// Pictures 0 and 3 of scene 0 show the cube once, picture 7 twice; picture 5 is there and shows
// none.
class Observations : public testing::Test {
 protected:
  Observations() : cube_(load_target("cube")), pictures_(*cube_, shown(), has_five) {}

  static bool has_five(PictureName picture) { return picture.scene_id == 0 && picture.im_id == 5; }
  static ShownTarget at(int im_id, int gt_id, double x_m) {
    ShownTarget shown{{0, im_id}, gt_id, fmt::format("test/000000/gray/{:06}.png", im_id), {}, {}};
    shown.camera.width_px = 640;
    shown.camera.height_px = 480;
    shown.camera.fx_px = shown.camera.fy_px = 800;
    shown.camera.cx_px = 319.5;
    shown.camera.cy_px = 239.5;
    shown.cam_from_target.translation = {x_m, 0, 12};
    return shown;
  }
  static std::vector<ShownTarget> shown() {
    return {at(7, 1, 2), at(3, 0, 0.5), at(0, 0, 0), at(7, 0, -2)};
  }
  std::string name(size_t feature) const { return cube_->features[feature].name; }
  Eigen::Vector2d truth(const ShownTarget& shown, size_t feature) const {
    return true_pixel(shown, cube_->features[feature]).value();
  }
  GivenObservations read(const std::string& file, const std::string& text,
                         PixelOrigin pixels = PixelOrigin::kCentres,
                         const std::string& images = "") const {
    ObservationSource source;
    source.name = "net";
    source.file = folder_.write(file, text);
    source.pixels = pixels;
    source.images = images;
    return read_observations(source, pictures_);
  }
  std::string complaint(const std::string& file, const std::string& text) const {
    return error_of([&] { read(file, text); });
  }
  // A detection of the cube, each of its keypoints moved by so much.
  json detection(const ShownTarget& shown, double score, double shift_px = 0) const {
    json keypoints = json::array();
    for (size_t i = 0; i < cube_->features.size(); ++i) {
      const Eigen::Vector2d pixel = truth(shown, i);
      for (const double number : {pixel.x() + shift_px, pixel.y() + shift_px, 0.9}) {
        keypoints.push_back(number);
      }
    }
    return {{"image_id", shown.picture.im_id},
            {"category_id", 1},
            {"keypoints", keypoints},
            {"score", score}};
  }

  TemporaryFolder folder_;
  std::shared_ptr<const Target> cube_;
  ShownPictures pictures_;
};

TEST_F(Observations, OfACsvFileHaveTheirPixelsAndCovariances) {
  const auto given = read("a.csv",
                          "scene_id,im_id,feature,u,v,sigma,confidence\n"
                          "0,3," +
                              name(0) +
                              ",10.5,20.25,0.5,1\n"
                              "0,3," +
                              name(2) +
                              ",1e1,-2,,1\n"
                              "0,5," +
                              name(2) +
                              ",1,2,1,1\n"
                              "0,0," +
                              name(1) + ",nan,nan,1,1\n");
  ASSERT_EQ(given.size(), 1u) << "picture 5 shows no cube, and of picture 0 nothing was found";
  const GivenFeatures& features = given.at({0, 3, 0});
  ASSERT_EQ(features.size(), 2u);
  EXPECT_EQ(features.at(0).pixel, Eigen::Vector2d(10.5, 20.25));
  EXPECT_EQ(features.at(0).covariance_px2.value(),
            Eigen::Matrix2d(0.25 * Eigen::Matrix2d::Identity()));
  EXPECT_EQ(features.at(2).pixel, Eigen::Vector2d(10, -2));
  EXPECT_FALSE(features.at(2).covariance_px2);
}

TEST_F(Observations, MayStateWholeCovariancesAndInstances) {
  const auto given = read("a.csv",
                          "\xEF\xBB\xBFscene_id, im_id ,gt_id,feature,u,v,var_uu,var_uv,var_vv\r\n"
                          "0,7,1,\"" +
                              name(0) + "\",1,2,4,1,9\r\n");
  Eigen::Matrix2d covariance;
  covariance << 4, 1, 1, 9;
  EXPECT_EQ(given.at({0, 7, 1}).at(0).covariance_px2.value(), covariance);
}

TEST_F(Observations, AreCountedFromWhereTheFileSays) {
  const std::string text = "scene_id,im_id,feature,u,v\n0,0," + name(0) + ",0.5,0.25\n";
  const auto pixel = [&](PixelOrigin origin) {
    return read("a.csv", text, origin).at({0, 0, 0}).at(0).pixel;
  };
  EXPECT_EQ(pixel(PixelOrigin::kCentres), Eigen::Vector2d(0.5, 0.25));
  EXPECT_EQ(pixel(PixelOrigin::kCorners), Eigen::Vector2d(0, -0.25));
  EXPECT_EQ(pixel(PixelOrigin::kNormalised), Eigen::Vector2d(319.5, 119.5));
}

TEST_F(Observations, ThatAreWrongAreRefusedWithTheirLine) {
  const std::string head = "scene_id,im_id,feature,u,v\n";
  EXPECT_THAT(
      complaint("a.csv", head + "0,0,vertex_99,1,2\n"),
      AllOf(HasSubstr("a.csv: line 2 has a feature 'vertex_99'"), HasSubstr("did you mean")));
  EXPECT_THAT(complaint("a.csv", head + "0,4," + name(0) + ",1,2\n"),
              HasSubstr("line 2 is about image 4 of scene 0, which the set does not have"));
  EXPECT_THAT(complaint("a.csv", head + "2,0," + name(0) + ",1,2\n"),
              HasSubstr("line 2 is about scene 2, must be about scene 0"));
  EXPECT_THAT(complaint("a.csv", head + "0,0," + name(0) + ",1,2\n0,0," + name(0) + ",1,3\n"),
              HasSubstr("line 3 has '" + name(0) + "' of image 0 of scene 0 a second time"));
  EXPECT_THAT(complaint("a.csv", head + "0,7," + name(0) + ",1,2\n"), HasSubstr("gt_id must say"));
  EXPECT_THAT(complaint("a.csv", head + "0,0," + name(0) + ",1\n"), HasSubstr("has 4 fields"));
  EXPECT_THAT(complaint("a.csv", head + "0,0," + name(0) + ",here,1\n"), HasSubstr("a number"));
  EXPECT_THAT(complaint("a.csv", "scene_id,im_id,feature,u\n"), HasSubstr("names no column 'v'"));
  EXPECT_THAT(complaint("a.csv", "scene_id,im_id,feature,u,v,sigmas\n"),
              HasSubstr("has a column 'sigmas' (did you mean 'sigma'?)"));
  EXPECT_THAT(complaint("a.csv", "scene_id,im_id,feature,u,v,sigma\n0,0," + name(0) + ",1,2,0\n"),
              HasSubstr("has 0 for sigma, must be from"));
  EXPECT_THAT(complaint("a.csv", "scene_id,im_id,feature,u,v,var_uu,var_uv,var_vv\n0,0," + name(0) +
                                     ",1,2,1,2,1\n"),
              HasSubstr("are no covariance"));
  EXPECT_THAT(complaint("a.csv", head + "0,0,\"" + name(0) + ",1,2\n"),
              HasSubstr("has a quote that does not end"));
}

TEST_F(Observations, OfCocoAreTheSurestDetectionOfAPicture) {
  const ShownTarget shown = pictures_.in({0, 3}).front();
  json results = {detection(shown, 0.2, 30), detection(shown, 0.8, 1), detection(shown, 0.5, 9)};
  results[1]["keypoints"][5] = 0;  // the second keypoint was not found
  const GivenFeatures features = read("r.json", results.dump()).at({0, 3, 0});
  EXPECT_EQ(features.size(), cube_->features.size() - 1);
  EXPECT_FALSE(features.contains(1));
  EXPECT_TRUE(features.at(0).pixel.isApprox(truth(shown, 0) + Eigen::Vector2d::Ones(), 1e-12));
}

TEST_F(Observations, OfCocoGoToTheNearestOfSeveralInstances) {
  const auto shown = pictures_.in({0, 7});
  const json results = {detection(shown[1], 0.9, 2), detection(shown[0], 0.3, -2)};
  const auto given = read("r.json", results.dump());
  EXPECT_TRUE(given.at({0, 7, 1}).at(0).pixel.isApprox(
      truth(shown[1], 0) + Eigen::Vector2d::Constant(2), 1e-12));
  EXPECT_TRUE(given.at({0, 7, 0}).at(0).pixel.isApprox(
      truth(shown[0], 0) - Eigen::Vector2d::Constant(2), 1e-12));
}

TEST_F(Observations, OfCocoMayNameTheirPicturesAndKeypoints) {
  const json images = {{"images", {{{"id", 900}, {"file_name", "000000/gray/000003.png"}}}},
                       {"categories", {{{"id", 1}, {"keypoints", {name(2), "else", name(0)}}}}}};
  const auto file = folder_.write("images.json", images.dump());
  const json results = {{{"image_id", 900},
                         {"category_id", 1},
                         {"score", 1},
                         {"keypoints", {1, 2, 1, 3, 4, 1, 5, 6, 1}}}};
  const GivenFeatures features =
      read("r.json", results.dump(), PixelOrigin::kCentres, file.string()).at({0, 3, 0});
  ASSERT_EQ(features.size(), 2u);
  EXPECT_EQ(features.at(2).pixel, Eigen::Vector2d(1, 2));
  EXPECT_EQ(features.at(0).pixel, Eigen::Vector2d(5, 6));
}

TEST_F(Observations, OfCocoThatAreWrongAreRefusedWithTheirPlace) {
  const ShownTarget shown = pictures_.in({0, 3}).front();
  const json good = detection(shown, 1);
  const auto with = [&](const char* key, const json& value) {
    json other = good;
    other[key] = value;
    return json({good, other}).dump();
  };
  EXPECT_THAT(complaint("r.json", with("keypoints", {1, 2, 3})),
              HasSubstr("r.json: detection 2 has 3 values of keypoints, must have"));
  EXPECT_THAT(complaint("r.json", with("image_id", 4)), HasSubstr("detection 2 is about image 4"));
  EXPECT_THAT(complaint("r.json", with("image_id", "3")), HasSubstr("detection 2 has no image_id"));
  EXPECT_THAT(complaint("r.json", with("category_id", 2)), HasSubstr("is of category 2"));
  EXPECT_THAT(complaint("r.json", "{}"), HasSubstr("must be an array of detections"));
}

TEST_F(Observations, WithoutSigmasHaveTheNoiseOfTheirOwnInliers) {
  constexpr double kSigmaPx = 0.7;
  constexpr int kCount = 100'000;
  RandomStream stream(1, "noise", 0);
  std::vector<double> squares;
  for (int i = 0; i < kCount; ++i) {
    const double u = kSigmaPx * stream.normal();
    const double v = kSigmaPx * stream.normal();
    const bool is_outlier = i % 4 == 0;
    squares.push_back(is_outlier ? 400 + i : u * u + v * v);
  }
  // A sigma of n Gaussian coordinates errs by 1 / sqrt(2 n) of itself; what is cut off beyond three
  // sigmas would make it 2 % too small.
  const double error = 1 / std::sqrt(2.0 * 2 * 0.75 * kCount);
  EXPECT_NEAR(inlier_sigma_px(squares) / kSigmaPx, 1, 4 * error);
  EXPECT_EQ(inlier_sigma_px({}), 0);
  EXPECT_EQ(inlier_sigma_px({0, 0, 0}), 0);
}

TEST_F(Observations, OfAnExtractorSayWhereTheyComeFrom) {
  ObservationSource source;
  source.name = "net";
  std::string text = "scene_id,im_id,feature,u,v\n";
  for (size_t i = 0; i < cube_->features.size(); ++i) {
    const Eigen::Vector2d pixel = truth(pictures_.in({0, 0}).front(), i);
    text += fmt::format("0,0,{},{},{}\n", name(i), pixel.x() + (i % 2 ? 1 : -1), pixel.y());
  }
  source.file = folder_.write("net.csv", text);
  EXPECT_THAT(recorded_extractor(source, pictures_).summary,
              AllOf(HasSubstr("observations from net.csv"), HasSubstr("estimated from its own")));
}

}  // namespace
}  // namespace sightline
