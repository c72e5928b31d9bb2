// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The extractors on images in closed form: a plate drawn by exact area coverage.
#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "features/outline.h"
#include "tests/features/plate.h"

namespace sightline {
namespace {

struct Accuracy {
  int asked = 0;
  int found = 0;
  int outliers = 0;  // over 1 px
  double squares_px2 = 0;
  double normalised = 0;
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();

  double rms_px() const { return std::sqrt(squares_px2 / (2.0 * (found - outliers))); }
  double normalised_sd() const { return std::sqrt(normalised / (2.0 * (found - outliers))); }
};

PosePrior erring_prior(const Pose& truth, RandomStream& stream) {
  PriorError error;
  error.attitude_deg = 1;
  error.lateral_px = 2;
  return prior_of(draw_prior(truth, plate_camera(), error, stream), plate_camera(), error);
}

// Over sub-pixel positions, turns and priors.
Accuracy accuracy_of(const char* extractor, int draws = 40) {
  const Target target = plate_target();
  Accuracy sums;
  for (int i = 0; i < draws; ++i) {
    RandomStream stream(7, "plate", i);
    const Pose truth =
        plate_pose(stream.uniform(0, 360), {stream.uniform(-0.3, 0.3), stream.uniform(-0.3, 0.3)});
    const cv::Mat image = exposed(plate_coverage(truth), {.index = static_cast<uint64_t>(i)});
    for (const Observation& seen :
         extract_plate(extractor, image, target, erring_prior(truth, stream))) {
      ++sums.asked;
      if (seen.status != ObservationStatus::kFound) continue;
      ++sums.found;
      const Eigen::Vector2d pixel =
          *project(plate_camera(), truth * target.features[seen.feature].position_m);
      const Eigen::Vector2d error = seen.pixel - pixel;
      if (!(error.norm() < 1)) {
        ++sums.outliers;
        continue;
      }
      sums.squares_px2 += error.squaredNorm();
      sums.mean_px += error;
      sums.normalised += error.dot(seen.covariance_px2.llt().solve(error));
    }
  }
  sums.mean_px /= sums.found - sums.outliers;
  return sums;
}

struct Promise {
  const char* extractor;
  double rms_px;          // of a coordinate, noise of 3 grey levels, blur of 0.7 px
  double normalised_min;  // floors of sigma are those of airliners: a plate's error may be less
};

void PrintTo(const Promise& promise, std::ostream* stream) {
  *stream << promise.extractor;
}

class OnAPlate : public testing::TestWithParam<Promise> {};

TEST_P(OnAPlate, CornersAreFoundAsWellAsPromised) {
  const Accuracy accuracy = accuracy_of(GetParam().extractor);
  EXPECT_GE(accuracy.found, 0.98 * accuracy.asked);
  EXPECT_LE(accuracy.outliers, 0.02 * accuracy.asked);
  EXPECT_LE(accuracy.rms_px(), GetParam().rms_px);
  EXPECT_LE(accuracy.normalised_sd(), 1.25);
  EXPECT_GE(accuracy.normalised_sd(), GetParam().normalised_min);
}

TEST_P(OnAPlate, AQuarterTurnTurnsTheResult) {
  const Target target = plate_target();
  const Pose truth = plate_pose(20, {0.13, -0.21});
  const PosePrior prior = prior_of(plate_pose(21, {0.2, -0.1}), plate_camera(), {});
  const Pose quarter = plate_pose(90);
  PosePrior turned = prior_of({quarter.rotation * prior.cam_from_target.rotation,
                               quarter.rotation * prior.cam_from_target.translation},
                              plate_camera(), {});
  const cv::Mat image = exposed(plate_coverage(truth), {});
  cv::Mat turned_image;
  cv::rotate(image, turned_image, cv::ROTATE_90_CLOCKWISE);
  const auto seen = extract_plate(GetParam().extractor, image, target, prior);
  const auto seen_turned = extract_plate(GetParam().extractor, turned_image, target, turned);
  const bool is_lsd = std::string(GetParam().extractor) == "lsd_intersection";
  for (size_t i = 0; i < seen.size(); ++i) {
    ASSERT_EQ(seen[i].status, ObservationStatus::kFound);
    ASSERT_EQ(seen_turned[i].status, ObservationStatus::kFound);
    const Eigen::Vector2d expected(kPlateImagePx - 1 - seen[i].pixel.y(), seen[i].pixel.x());
    // LSD grows its regions in the order of the pixels.
    EXPECT_LT((seen_turned[i].pixel - expected).norm(), is_lsd ? 0.5 : 0.12);
  }
}

TEST_P(OnAPlate, ADarkPlateIsFoundAsABrightOne) {
  const Target target = plate_target();
  const Pose truth = plate_pose(33, {0.1, 0.2});
  const PosePrior prior = prior_of(plate_pose(34), plate_camera(), {});
  const cv::Mat bright = exposed(plate_coverage(truth), {});
  const cv::Mat dark = 255 - bright;
  const auto seen = extract_plate(GetParam().extractor, bright, target, prior);
  const auto seen_dark = extract_plate(GetParam().extractor, dark, target, prior);
  for (size_t i = 0; i < seen.size(); ++i) {
    ASSERT_EQ(seen_dark[i].status, ObservationStatus::kFound);
    EXPECT_LT((seen[i].pixel - seen_dark[i].pixel).norm(), 0.3);
  }
}

TEST_P(OnAPlate, AnImageWithoutThePlateHasNoCorners) {
  const Target target = plate_target();
  const PosePrior prior = prior_of(plate_pose(20), plate_camera(), {});
  const cv::Mat noise = exposed(cv::Mat::zeros(kPlateImagePx, kPlateImagePx, CV_32F), {});
  const cv::Mat white(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(255));
  const cv::Mat grey(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(90));
  for (const auto& seen : extract_plate(GetParam().extractor, noise, target, prior)) {
    EXPECT_NE(seen.status, ObservationStatus::kFound);
  }
  for (const auto& seen : extract_plate(GetParam().extractor, white, target, prior)) {
    EXPECT_EQ(seen.status, ObservationStatus::kSaturated);
  }
  for (const auto& seen : extract_plate(GetParam().extractor, grey, target, prior)) {
    EXPECT_EQ(seen.status, ObservationStatus::kEmptyWindow);
  }
  ExtractorOptions options;
  options.window_half_px = 0;
  for (const auto& seen : extract_plate(GetParam().extractor, noise, target, prior, options)) {
    EXPECT_EQ(seen.status, ObservationStatus::kWindowTooSmall);
  }
}

TEST_P(OnAPlate, WhatLiesOutsideAGateIsNotFound) {
  const Target target = plate_target();
  const cv::Mat image = exposed(plate_coverage(plate_pose(20)), {});
  // 9 px off, but said to be good to a fraction of a pixel.
  PosePrior prior{plate_pose(20, {0.9, 0}), Matrix6d::Zero()};
  ExtractorOptions options;
  options.is_gated = true;
  for (const auto& seen : extract_plate(GetParam().extractor, image, target, prior, options)) {
    EXPECT_NE(seen.status, ObservationStatus::kFound);
  }
  prior.cam_from_target = plate_pose(20, {0.1, 0});
  for (const auto& seen : extract_plate(GetParam().extractor, image, target, prior, options)) {
    EXPECT_EQ(seen.status, ObservationStatus::kFound);
  }
}

INSTANTIATE_TEST_SUITE_P(All, OnAPlate,
                         testing::Values(Promise{"hough_subpixel", 0.10, 0.4},
                                         Promise{"lsd_intersection", 0.30, 0.2},
                                         Promise{"model_edges", 0.12, 0.4},
                                         Promise{"contour", 0.15, 0.05},
                                         Promise{"edges_else_contour", 0.12, 0.4},
                                         Promise{"harris_subpixel", 0.40, 0.1}),
                         [](const auto& one) { return std::string(one.param.extractor); });

TEST(Lsd, ItsShiftIsCorrected) {
  // OpenCV's own is 0.12 px in either coordinate.
  const Accuracy accuracy = accuracy_of("lsd_intersection", 80);
  EXPECT_LT(accuracy.mean_px.cwiseAbs().maxCoeff(), 0.05);
}

// A bright band beside the plate: its near edge is the stronger, but of the wrong polarity.
TEST(ModelEdges, AStrongerEdgeOfTheWrongPolarityIsPassedOver) {
  const Target target = plate_target();
  const Pose truth = plate_pose(0);
  cv::Mat light = 0.4 * plate_coverage(truth);
  const Eigen::Vector2d corner = *project(plate_camera(), truth * target.features[0].position_m);
  const int band_end = static_cast<int>(corner.x()) - 7;  // the corner is at the upper left
  light(cv::Rect(0, 0, band_end, kPlateImagePx)) = 1;
  const cv::Mat image = exposed(light, {});
  PriorError wide;
  wide.lateral_px = 6;
  const PosePrior prior = prior_of(plate_pose(0, {-0.4, 0}), plate_camera(), wide);
  // The level of the background is that of most of the image around the target.
  const auto seen = extract_plate("model_edges", image, target, prior);
  ASSERT_EQ(seen[0].status, ObservationStatus::kFound);
  EXPECT_LT((seen[0].pixel - corner).norm(), 0.5);
}

// All combinations of their lines would never end.
TEST(ModelEdges, OfManyEdgesTheLongestServe) {
  Target target = plate_target();
  for (TargetFeature& feature : target.features) {
    const std::vector<Edge> two = feature.edges;
    for (int i = 0; i < 11; ++i) {
      feature.edges.insert(feature.edges.end(), two.begin(), two.end());
    }
  }
  target.shapes = feature_shapes(target.mesh, target.features);
  const Pose truth = plate_pose(20);
  const cv::Mat image = exposed(plate_coverage(truth), {});
  const PosePrior prior = prior_of(truth, plate_camera(), {});
  for (const Observation& seen : extract_plate("model_edges", image, target, prior)) {
    ASSERT_EQ(seen.status, ObservationStatus::kFound);
    EXPECT_LE(seen.lines.size(), 5u);
    const Eigen::Vector2d corner =
        *project(plate_camera(), truth * target.features[seen.feature].position_m);
    EXPECT_LT((seen.pixel - corner).norm(), 0.3);
  }
}

TEST(ModelEdges, WithoutAMeshThereIsNoOutline) {
  const cv::Mat image = exposed(plate_coverage(plate_pose(20)), {});
  const Target target = plate_target();
  for (const char* extractor : {"model_edges", "contour"}) {
    PredictedView view = predict_features(target, std::array{0}, plate_camera(),
                                          prior_of(plate_pose(20), plate_camera(), {}));
    view.target = nullptr;
    const FeatureExtractor* found = find_feature_extractor(extractor);
    const auto seen = extract_features(image, 255, view, {found, found, found}, {});
    EXPECT_EQ(seen[0].status, ObservationStatus::kNoOutline) << extractor;
  }
}

// Of a pixel from the border of the plate's image, which faces the camera.
double from_border_px(const Pose& pose, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d centre = *project(plate_camera(), pose * Eigen::Vector3d(0, 0, 0));
  const Eigen::Vector2d in_plate =
      pose.rotation.topLeftCorner<2, 2>().transpose() * (pixel - centre);
  return std::abs(in_plate.cwiseAbs().maxCoeff() - 50);
}

TEST(Contour, SaysWhereTheOutlineCameToLie) {
  const Target target = plate_target();
  const Pose truth = plate_pose(20, {0.1, 0.2});
  const Pose expected = plate_pose(22, {0.4, -0.1});  // 4 px off, and turned
  const PosePrior prior = prior_of(expected, plate_camera(), {});
  const cv::Mat image = exposed(plate_coverage(truth), {});
  for (const Observation& seen : extract_plate("contour", image, target, prior)) {
    ASSERT_EQ(seen.status, ObservationStatus::kFound);
    ASSERT_GE(seen.laid_outline.size(), seen.contour.size());
    double on_truth_px = 0, on_expected_px = 0;
    for (const Eigen::Vector2d& sample : seen.laid_outline) {
      on_truth_px = std::max(on_truth_px, from_border_px(truth, sample));
      on_expected_px = std::max(on_expected_px, from_border_px(expected, sample));
    }
    EXPECT_LT(on_truth_px, 0.6);
    EXPECT_GT(on_expected_px, 2);
  }
  const cv::Mat noise = exposed(cv::Mat::zeros(kPlateImagePx, kPlateImagePx, CV_32F), {});
  for (const Observation& seen : extract_plate("contour", noise, target, prior)) {
    EXPECT_TRUE(seen.laid_outline.empty());
  }
}

TEST(Outline, OfAPlateIsItsFourEdges) {
  const Target target = plate_target();
  const Pose pose = plate_pose(20, {0.3, 0.1});
  const PredictedView view =
      predict_features(target, std::array{0}, plate_camera(), PosePrior{pose});
  const Eigen::Vector2d centre = *project(plate_camera(), pose * Eigen::Vector3d(0, 0, 0));
  const auto samples = predict_outline(view, view.features[0], 30);
  EXPECT_NEAR(static_cast<double>(samples.size()), 60, 2);  // 30 px of either edge
  for (const OutlineSample& sample : samples) {
    const Eigen::Vector2d from_centre = sample.pixel - centre;
    EXPECT_NEAR(sample.normal.dot(from_centre), 50, 1e-9);
    EXPECT_FALSE(sample.borders_target);
  }
  for (int i = 0; i < 2; ++i) {
    const PredictedEdge edge =
        predict_edge(view, view.features[0], i, {.gap_px = 2.5, .reach_px = 36});
    EXPECT_EQ(edge.samples.size(), 34u);
    EXPECT_GT(edge.normal.dot(edge.begin - centre), 0);
    EXPECT_FALSE(edge.is_soft);
    for (const auto& sample : edge.samples) EXPECT_NEAR(sample.offset_px, 0, 1e-9);
    // Its sibling, which begins where it does; the two across only where they come near.
    const auto beside = edges_beside(view, view.features[0], i, 50);
    ASSERT_EQ(beside.size(), 1u);
    const Eigen::Vector2d off_begin = beside[0].begin - edge.begin;
    const Eigen::Vector2d off_end = beside[0].end - edge.begin;
    EXPECT_LT(std::min(off_begin.norm(), off_end.norm()), 1e-9);
    EXPECT_NEAR((beside[0].end - beside[0].begin).dot(edge.direction), 0, 1e-6);
    EXPECT_EQ(edges_beside(view, view.features[0], i, 150).size(), 3u);
  }
}

// A part behind the plate that juts out by 2 px, past which there is background again.
TEST(Outline, BordersTheTargetWhereALittleOfItJutsOut) {
  for (const bool is_behind : {false, true}) {
    Target target = plate_target();
    if (is_behind) {
      const int first = static_cast<int>(target.mesh.vertices.size());
      for (const auto& [x, y] : {std::pair{-4.0, -4.0}, {5.2, -4.0}, {5.2, 4.0}, {-4.0, 4.0}}) {
        target.mesh.vertices.emplace_back(x, y, 0.1);
      }
      target.mesh.parts.push_back({"behind", 0.8});
      for (Triangle triangle : {target.mesh.triangles[0], target.mesh.triangles[1]}) {
        for (int& vertex : triangle.vertex) vertex += first;
        triangle.part = 1;
        target.mesh.triangles.push_back(triangle);
      }
      target.occluder = Occluder(target.mesh);
      target.shapes = feature_shapes(target.mesh, target.features);
    }
    // From the corner (5, -5) along x = 5 and along y = -5.
    const PredictedView view =
        predict_features(target, std::array{1}, plate_camera(), PosePrior{plate_pose(0)});
    for (int i = 0; i < 2; ++i) {
      const PredictedEdge edge =
          predict_edge(view, view.features[0], i, {.gap_px = 12, .reach_px = 36});
      ASSERT_EQ(edge.samples.size(), 25u);
      const bool juts_out = is_behind && std::abs(edge.direction.y()) > 0.5;
      for (const auto& sample : edge.samples) EXPECT_EQ(sample.borders_target, juts_out) << i;
    }
  }
}

TEST(Prediction, CovarianceIsThatOfDrawnPriors) {
  const Pose pose = {rotation_from_vector({0.4, -0.3, 0.2}), {1, -2, 100}};
  const Camera camera = plate_camera();
  const PriorError error{.attitude_deg = 1, .range_fraction = 0.02, .lateral_px = 1.5};
  const Eigen::Vector3d point(4, 3, -2);
  const Eigen::Vector2d mean = *project(camera, pose * point);
  Eigen::Matrix2d sampled = Eigen::Matrix2d::Zero();
  constexpr int kDraws = 20000;
  RandomStream stream(3, "prior", 0);
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector2d d =
        *project(camera, draw_prior(pose, camera, error, stream) * point) - mean;
    sampled += d * d.transpose() / kDraws;
  }
  const Eigen::Matrix2d predicted =
      predicted_covariance_px2(camera, prior_of(pose, camera, error), point);
  // 1 / sqrt(20000) is 0.7 %, the curvature that first order leaves out below 1 %.
  EXPECT_LT((sampled - predicted).norm(), 0.04 * predicted.norm());
}

}  // namespace
}  // namespace sightline
