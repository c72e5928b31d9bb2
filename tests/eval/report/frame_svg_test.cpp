// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/frame_svg.h"

#include <limits>
#include <set>
#include <string>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "eval/report/outline.h"
#include "pose/attitude.h"
#include "tests/eval/report/small_report.h"

namespace sightline {
namespace {

using namespace small_report;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(FrameSvg, PutsPixelCentresAtIntegers) {
  EXPECT_EQ(view_box({0, 0, 64, 32}), "-0.5 -0.5 64 32");
  EXPECT_TRUE(has(SmallReport().page(), "x=\"-0.5\" y=\"-0.5\" width=\"64\" height=\"64\""));
}

TEST(FrameSvg, CutsLinesAtTheirWindow) {
  Observation observation = observed(0, {10, 20, 11, 11});
  observation.lines[0].point = {15, 25};
  observation.lines[0].direction = Eigen::Vector2d::UnitX();
  const ObservationRecord record = missing("a", ObservationStatus::kParallelLines);
  EXPECT_THAT(feature_marks(observation, record, {}), HasSubstr("d=\"M9.5 25L20.5 25\""));
  observation.lines[0].point = {15, 40};  // passes by the window
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-lines")));
}

TEST(FrameSvg, DrawsTheEdgePixelsThatAnOutlineWasLaidOn) {
  Observation observation;
  observation.window = {10, 20, 11, 11};
  const ObservationRecord record = missing("a", ObservationStatus::kTooFewEdgePixels);
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-edges")));
  observation.contour = {{12.25, 22}, {13, 22.5}};
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("<path class=\"layer-edges edges\" d=\"M12.25 22h0M13 22.5h0\"/>"));
}

TEST(FrameSvg, DrawsALaidOutlineFromNeighbourToNeighbour) {
  Observation observation;
  observation.window = {10, 20, 11, 11};
  const ObservationRecord record = missing("a", ObservationStatus::kParallelLines);
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-lines")));
  observation.laid_outline = {{12, 22}, {10, 22}, {13, 23}, {11, 22}, {13, 24}};
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("<path class=\"layer-lines lines\" d=\"M10 22L12 22L13 23L13 24\"/>"));
  observation.laid_outline = {{12, 22}, {11, 22}, {20, 22}, {21, 22}, {30, 40}};  // one alone
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("d=\"M20 22L21 22M12 22L11 22\"/>"));
}

TEST(FrameSvg, DrawsOutlinesAsClosedPaths) {
  EXPECT_EQ(outline_path({{{0, 0.25}, {1.5, 0}, {1, 2}}}), "M0 0.25L1.5 0L1 2Z");
  EXPECT_EQ(outline_path({}), "");
}

TEST(FrameSvg, ShowsAllButSmallImagesByTheirPartAboutTheTarget) {
  const cv::Mat image(3000, 4000, CV_8U, cv::Scalar(40));
  const FramePicture part = picture_of(image, 8, {1000, 500, 800, 700});
  EXPECT_EQ(part.pixels, cv::Rect(919, 419, 962, 862));  // a margin of a tenth, and a pixel
  EXPECT_EQ(part.reduction, 1);
  const FramePicture whole = picture_of(image, 8, {0, 0, 4000, 3000});
  EXPECT_EQ(whole.reduction, 4);
  EXPECT_EQ(whole.pixels, cv::Rect(0, 0, 4000, 3000));
  EXPECT_LT(whole.png_url.size(), 100'000u);
  const FramePicture small = picture_of(image({0, 0, 256, 200}), 8, {100, 100, 20, 20});
  EXPECT_EQ(small.pixels, cv::Rect(0, 0, 256, 200));
  EXPECT_TRUE(picture_of({}, 8, {}).png_url.empty());
}

TEST(Outline, FinerCamerasSeeTheSame) {
  const Camera coarse = centred_camera(512, 512, 10000);
  const Camera fine = finer(coarse, 4);
  const Eigen::Vector3d x(3, -7, 1300);
  const Eigen::Vector2d in_coarse = *project(coarse, x);
  const Eigen::Vector2d in_fine = *project(fine, x);
  const Eigen::Vector2d half(0.5, 0.5);
  EXPECT_LT(((in_fine + half) / 4 - half - in_coarse).norm(), 1e-9);
}

// Half a subdivided pixel inside the silhouette, and half a one of the raster.
constexpr double kOutlineTolerancePx = 0.3;

Scene cube_scene() {
  Scene scene;
  scene.target = load_target("cube");
  scene.camera = centred_camera(256, 256, 2000);
  scene.cam_from_target.rotation = rotation_from_attitude({0.4, -0.3, 0.2});
  scene.cam_from_target.translation = {0.3, -0.2, 20};
  return scene;
}

TEST(Outline, SpansWhatTheMeshProjectsTo) {
  Renderer renderer;
  const Scene scene = cube_scene();
  const Outline outline = target_outline(renderer, scene, scene.cam_from_target);
  ASSERT_EQ(outline.size(), 1u);
  Eigen::AlignedBox2d drawn;
  for (const Eigen::Vector2d& pixel : outline[0]) drawn.extend(pixel);
  Eigen::AlignedBox2d projected;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    projected.extend(*project(scene.camera, scene.cam_from_target * vertex));
  }
  EXPECT_LT((drawn.min() - projected.min()).cwiseAbs().maxCoeff(), kOutlineTolerancePx);
  EXPECT_LT((drawn.max() - projected.max()).cwiseAbs().maxCoeff(), kOutlineTolerancePx);
}

TEST(Outline, OfWhatCannotBeImagedIsEmpty) {
  Renderer renderer;
  const Scene scene = cube_scene();
  Pose behind = scene.cam_from_target;
  behind.translation.z() = -20;
  EXPECT_TRUE(target_outline(renderer, scene, behind).empty());
}

TEST(ObservedLine, IsDrawnAlongItsEdgePixelsAndStruckOutWhereRemoved) {
  EdgeLine found;
  found.line.point = {400, 20};  // where it errs independently of a feature, far off
  for (const double u : {10.0, 20.0, 30.0}) found.line.edge_pixels.emplace_back(u, 20);
  LineRecord record;
  record.feature = "fin_tip";
  record.edge = 1;
  record.offset_px = -0.25;
  record.error_sigmas = 1.5;
  const std::string kept = observed_line_mark(found, record, {});
  EXPECT_THAT(kept, testing::HasSubstr("M10 20L30 20"));
  EXPECT_THAT(kept, testing::HasSubstr("fin_tip, edge 1: right line, 0.25 px and 1.5"));
  EXPECT_THAT(kept, testing::Not(testing::HasSubstr("layer-removed")));
  const std::string removed = observed_line_mark(found, record, {"consensus"});
  EXPECT_THAT(removed, testing::HasSubstr("layer-removed"));
  EXPECT_THAT(removed, testing::HasSubstr("fin_tip, edge 1: removed by consensus"));
}

TEST(ResidualPicture, TellsDarkerFromBrighterAndNeitherFromWhatIsNotCompared) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto picture_of_residual = [](float sds) {
    const cv::Mat grey(4, 4, CV_32F, cv::Scalar(100));
    return residual_picture("registration_image",
                            {cv::Rect(3, 5, 4, 4), grey, cv::Mat(4, 4, CV_32F, cv::Scalar(sds))});
  };
  const ResidualPicture none = picture_of_residual(0);
  EXPECT_EQ(none.pixels, cv::Rect(3, 5, 4, 4));
  // Within a quarter of a standard deviation it is the same colour; beyond five too.
  EXPECT_EQ(none.residual_url, picture_of_residual(0.2F).residual_url);
  EXPECT_EQ(picture_of_residual(5).residual_url, picture_of_residual(50).residual_url);
  const std::set<std::string> different = {
      none.residual_url, picture_of_residual(1).residual_url, picture_of_residual(-1).residual_url,
      picture_of_residual(5).residual_url, picture_of_residual(nan).residual_url};
  EXPECT_EQ(different.size(), 5U);
}

}  // namespace
}  // namespace sightline
