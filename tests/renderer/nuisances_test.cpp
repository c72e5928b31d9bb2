// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Shadow, highlight, livery, motion, lens, aperture, shutter and colours' sizes against closed
// forms.
#include <array>
#include <cmath>
#include <fstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <unistd.h>

#include "renderer/renderer.h"
#include "scenes/builders/cube.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

// A small plate before a large one; the light comes from the left and above, so that the shadow
// falls to the right of the small plate.
Scene plate_over_plate() {
  Scene scene = coverage_scene(plate(2), at(0, 0, 60));
  scene.others.push_back({target_of(plate(0.3)), at(-0.3, -0.2, 59.5, {0, 0, 0.3}), true});
  scene.light = {.to_light_in_cam = Eigen::Vector3d(-1, -0.6, -1).normalized(),
                 .ambient = 0.2,
                 .directional = 0.5,
                 .casts_shadow = true};
  scene.samples_per_pixel = 64;
  return scene;
}

TEST(Shadow, OfAPlateOnAPlateIsThatOfTheLightsRays) {
  Scene scene = plate_over_plate();
  Renderer renderer;
  const cv::Mat shaded = renderer.render_linear(scene);
  const double lit = 0.2 + 0.5 * -scene.light.to_light_in_cam.z();
  // Shade, as a share of the pixel; the plates themselves are equally bright.
  const cv::Mat shade = (lit - shaded(cv::Rect(90, 90, 332, 332))) / (lit - 0.2);
  const cv::Moments moments = cv::moments(shade);
  // Corners slide along the light to the large plate, z = 60.
  std::vector<cv::Point2f> corners;
  for (const Eigen::Vector3d& vertex : scene.others[0].target->mesh.vertices) {
    const Eigen::Vector3d x = scene.others[0].cam_from_target * vertex;
    const Eigen::Vector3d& l = scene.light.to_light_in_cam;
    const Eigen::Vector2d pixel = *project(scene.camera, x + l * ((60 - x.z()) / l.z()));
    corners.emplace_back(pixel.x() - 90, pixel.y() - 90);
  }
  const double area = cv::contourArea(corners);
  const cv::Moments expected = cv::moments(corners);
  // Texels are a tenth of a pixel: an edge 50 px long averages their rounding (0.03 px rms).
  EXPECT_GT(area, 2000);
  EXPECT_NEAR(moments.m00, area, 0.02 * 4 * std::sqrt(area));
  EXPECT_NEAR(moments.m10 / moments.m00, expected.m10 / expected.m00, 0.03);
  EXPECT_NEAR(moments.m01 / moments.m00, expected.m01 / expected.m00, 0.03);
}

TEST(Shadow, FallsOnlyWhenAskedFor) {
  Scene scene = plate_over_plate();
  scene.light.casts_shadow = false;
  const cv::Mat image = Renderer().render_linear(scene);
  double low = 0, high = 0;
  cv::minMaxLoc(image(cv::Rect(100, 100, 300, 300)), &low, &high);
  EXPECT_EQ(low, high);
}

TEST(Shadow, NoConvexBodyShadesItself) {
  Renderer renderer;
  RandomStream stream(1, "cubes", 0);
  for (int i = 0; i < 10; ++i) {
    Scene scene = coverage_scene(build_cube().mesh, at(0.2, 0.1, 60));
    scene.cam_from_target.rotation = stream.rotation();
    scene.light = {.to_light_in_cam = stream.rotation().col(0)};
    scene.samples_per_pixel = 4;
    const cv::Mat open = renderer.render_linear(scene);
    scene.light.casts_shadow = true;
    scene.light.specular = 1e-12;  // both are shaded at every sample
    const cv::Mat shaded = renderer.render_linear(scene);
    EXPECT_LT(cv::norm(open, shaded, cv::NORM_INF), 1e-6) << i;
  }
}

TEST(Highlight, IsBlinnsAtThePlatesMiddle) {
  Scene scene = coverage_scene(plate(1), at(0, 0, 60));
  const Eigen::Vector3d to_light = Eigen::Vector3d(0.5, 0, -1).normalized();
  scene.light = {.to_light_in_cam = to_light,
                 .ambient = 0.1,
                 .directional = 0.2,
                 .specular = 0.4,
                 .shininess = 8};
  Renderer renderer;
  const auto ray = *normalised_from_pixel(scene.camera, {300, 200});
  const Eigen::Vector3d to_eye = -Eigen::Vector3d(ray.x(), ray.y(), 1).normalized();
  const double cosine = -(to_eye + to_light).normalized().z();
  const double expected = 0.1 + 0.2 * -to_light.z() + 0.4 * std::pow(cosine, 8);
  EXPECT_NEAR(renderer.render_linear(scene).at<float>(200, 300), expected, 1e-5);
  scene.light.specular = 5;  // a sample cannot exceed white
  EXPECT_EQ(renderer.render_linear(scene).at<float>(200, 300), 1);
}

TEST(Livery, DarkensEveryOtherStripeOfTheMainTarget) {
  Scene scene = coverage_scene(plate(1), at(0, 0, 60));
  scene.livery = {.contrast = 0.25, .stripe_m = 0.1};
  scene.others.push_back({target_of(plate(0.2)), at(0, 0.7, 60), false});
  const cv::Mat image = Renderer().render_linear(scene);
  const auto value = [&](double x_m, double y_m) {
    const Eigen::Vector2d pixel = *project(scene.camera, {x_m, y_m, 60});
    return image.at<float>(static_cast<int>(std::lround(pixel.y())),
                           static_cast<int>(std::lround(pixel.x())));
  };
  EXPECT_EQ(value(0.05, 0), 1);
  EXPECT_EQ(value(0.15, 0), 0.75f);
  EXPECT_EQ(value(-0.05, 0), 0.75f);
  EXPECT_EQ(value(-0.15, 0), 1);
  EXPECT_EQ(value(0.05, 0.7), 1);
  EXPECT_EQ(value(-0.05, 0.7), 1);  // others are plain
  // A stripe's border is shaded at every sample: its place is known to a fraction of a pixel.
  const Eigen::Vector2d border = *project(scene.camera, {0.1, 0, 60});
  double bright = 0;
  for (int u = 270; u < 280; ++u) bright += (image.at<float>(256, u) - 0.75) / 0.25;
  EXPECT_NEAR(269.5 + bright, border.x(), 0.05);
}

TEST(Motion, IsTheMeanOfThePosesOnTheWay) {
  Renderer renderer;
  Scene scene = coverage_scene(plate(1), at(0, 0, 60, {0.1, 0.2, 0.3}));
  scene.motion = {.rotation_rad = {0, 0, 0.08}, .translation_m = {0.04, 0, 0}, .samples = 2};
  const cv::Mat moved = renderer.render_linear(scene);
  Scene still = scene;
  still.motion = {};
  cv::Mat mean = cv::Mat::zeros(512, 512, CV_32F);
  for (const double time : {-0.25, 0.25}) {
    still.cam_from_target.rotation =
        rotation_from_vector({0, 0, 0.08 * time}) * scene.cam_from_target.rotation;
    still.cam_from_target.translation = scene.cam_from_target.translation;
    still.cam_from_target.translation.x() += 0.04 * time;
    mean += renderer.render_linear(still) / 2;
  }
  EXPECT_LT(cv::norm(moved, mean, cv::NORM_INF), 1e-6);
  still.cam_from_target = scene.cam_from_target;
  EXPECT_GT(cv::norm(moved, renderer.render_linear(still), cv::NORM_INF), 0.3);
  // The truth is that of mid-exposure.
  const Frame frame = renderer.render(scene, RandomStream(1, "sensor", 0));
  const Frame frozen = renderer.render(still, RandomStream(1, "sensor", 0));
  EXPECT_EQ(frame.truth.target().cam_from_target.translation, scene.cam_from_target.translation);
  EXPECT_EQ(cv::norm(frame.part_ids, frozen.part_ids, cv::NORM_INF), 0);
}

// A plate filling much of a wide lens's image.
Scene plate_through_a_lens() {
  Scene scene = coverage_scene(plate(1), at(0.05, -0.03, 0.9, {0.3, -0.4, 0.2}), 300);
  scene.camera.lens = BrownConrady{.k1 = -0.25, .k2 = 0.08, .p1 = 2e-3, .p2 = -1e-3, .k3 = 0};
  scene.samples_per_pixel = 64;
  return scene;
}

// The share of a pixel whose rays meet the plate.
double coverage(const Scene& scene, int x, int y) {
  constexpr int kSide = 16;
  const Pose target_from_cam = inverse(scene.cam_from_target);
  int hits = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Eigen::Vector2d pixel(x - 0.5 + (i % kSide + 0.5) / kSide,
                                y - 0.5 + (i / kSide + 0.5) / kSide);
    const Eigen::Vector2d ray = *normalised_from_pixel(scene.camera, pixel);
    const Eigen::Vector3d d = target_from_cam.rotation * Eigen::Vector3d(ray.x(), ray.y(), 1);
    const Eigen::Vector3d& eye = target_from_cam.translation;
    const Eigen::Vector3d hit = eye - d * (eye.z() / d.z());
    hits += hit.head<2>().cwiseAbs().maxCoeff() <= 0.5;
  }
  return static_cast<double>(hits) / (kSide * kSide);
}

double mean_border_error(const Scene& scene, const cv::Mat& image) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (image.at<float>(y, x) == 0 || image.at<float>(y, x) == 1) continue;
      sum += image.at<float>(y, x) - coverage(scene, x, y);
      ++count;
    }
  }
  EXPECT_GT(count, 800);
  return sum / count;
}

TEST(Lens, BendsEdgesTruly) {
  const Scene scene = plate_through_a_lens();
  const cv::Mat image = Renderer().render_linear(scene);
  // Both sides sample a border pixel to some 0.02; their mean over 800 pixels and more is known to
  // 1e-3, and chords would cut the outline by their own error at most.
  EXPECT_LT(std::abs(mean_border_error(scene, image)), 2e-3);
}

TEST(Lens, AHundredthOfItsStrengthOffWouldBeSeen) {
  Scene scene = plate_through_a_lens();
  const cv::Mat image = Renderer().render_linear(scene);
  std::get<BrownConrady>(scene.camera.lens).k1 *= 1.01;
  EXPECT_GT(std::abs(mean_border_error(scene, image)), 2e-2);
}

TEST(Lens, DrawsNothingBeyondItsFold) {
  // x (1 - r2) turns back at r = 0.58: beyond, a plate would appear a second time.
  Scene scene = coverage_scene(plate(0.2), at(0, 0, 1), 300);
  std::get<BrownConrady>(scene.camera.lens).k1 = -1;
  scene.others.push_back({target_of(plate(0.2)), at(0.95, 0, 1), false});
  const Frame frame = Renderer().render(scene, RandomStream(1, "sensor", 0));
  EXPECT_GT(frame.truth.bodies[0].visible_pixels, 0);
  EXPECT_EQ(frame.truth.bodies[1].visible_pixels, 0);
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// The right edge of a bright plate in a row of an image: where it lies, and the variance of what it
// is spread by, the pixel's own extent (1/12) and that of the difference of two (1/12) with it.
struct SpreadEdge {
  double place_px = 0;
  double variance_px2 = 0;
};

SpreadEdge right_edge(const cv::Mat& image, int row) {
  double sum = 0, first = 0, second = 0;
  for (int x = image.cols / 2; x + 1 < image.cols; ++x) {
    const double fall = image.at<float>(row, x) - image.at<float>(row, x + 1);
    sum += fall;
    first += fall * (x + 0.5);
    second += fall * (x + 0.5) * (x + 0.5);
  }
  const double place = first / sum;
  return {place, second / sum - place * place};
}

// At 60 m a pixel is 6 mm; the plate's right edge lies at 255.5 + 2 / 2 / 0.006 px.
constexpr double kPlateEdgePx = 255.5 + 1 / 0.006;

Scene plate_at_60_m() {
  return coverage_scene(plate(2), at(0, 0, 60));
}

TEST(Aperture, BlursWhatIsOutOfFocusByTheDiscOfGeometry) {
  Renderer renderer;
  Scene scene = plate_at_60_m();
  scene.optics = {.aperture_mm = 100, .focus_m = 50, .aperture_samples = 64};
  // A point at 60 m is a disc of diameter f A |1/50 - 1/60|, whose variance along a line is D^2/16.
  const double disc_px = 10000 * 0.1 * (1.0 / 50 - 1.0 / 60);
  const SpreadEdge edge = right_edge(renderer.render_linear(scene), 256);
  EXPECT_NEAR(edge.place_px, kPlateEdgePx, 0.02);
  EXPECT_NEAR(edge.variance_px2, disc_px * disc_px / 16 + 1.0 / 6, 0.02);
  // And in the other direction.
  const cv::Mat turned = renderer.render_linear(scene).t();
  EXPECT_NEAR(right_edge(turned, 256).variance_px2, edge.variance_px2, 0.02);
  // As much too far as it was too near: the same disc.
  scene.optics.focus_m = 75;
  EXPECT_NEAR(right_edge(renderer.render_linear(scene), 256).variance_px2, edge.variance_px2, 0.02);
}

TEST(Aperture, LeavesWhatIsInFocusSharp) {
  Renderer renderer;
  Scene scene = plate_at_60_m();
  const cv::Mat plain = renderer.render_linear(scene);
  scene.optics = {.aperture_mm = 100, .focus_m = 60, .aperture_samples = 16};
  EXPECT_LT(cv::norm(renderer.render_linear(scene), plain, cv::NORM_INF), 0.02);
}

TEST(Aperture, SeesBodiesBesideTheTargetFromItsPlaces) {
  Renderer renderer;
  // The main target is out of focus, a body beside it is not.
  Scene scene = coverage_scene(plate(0.3), at(-1, 0, 50));
  scene.others.push_back({target_of(plate(1)), at(0, 0, 60), false});
  const SpreadEdge plain = right_edge(renderer.render_linear(scene), 256);
  scene.optics = {.aperture_mm = 100, .focus_m = 60, .aperture_samples = 64};
  const SpreadEdge focused = right_edge(renderer.render_linear(scene), 256);
  EXPECT_NEAR(focused.variance_px2, plain.variance_px2, 0.02);
  EXPECT_NEAR(focused.place_px, plain.place_px, 0.01);
}

// A spot on a plate in focus lies where it lies, though the camera moves by a quarter of a metre.
TEST(Aperture, LeavesLampsWhereTheyAre) {
  Renderer renderer;
  Scene scene = coverage_scene(plate(2), at(0, 0, 10), 1000);
  scene.light.ambient = 0;
  scene.lamps.push_back({.distance_m = 10, .cone_deg = 5});
  cv::Mat plain = renderer.render_linear(scene);
  scene.optics = {.aperture_mm = 500, .focus_m = 10, .aperture_samples = 16};
  cv::Mat focused = renderer.render_linear(scene);
  if (plain.channels() == 3) {
    cv::extractChannel(plain, plain, 1);
    cv::extractChannel(focused, focused, 1);
  }
  EXPECT_GT(cv::norm(plain, cv::NORM_INF), 0.5);
  EXPECT_LT(cv::norm(plain, focused, cv::NORM_L1), 0.02 * cv::norm(plain, cv::NORM_L1));
}

TEST(RollingShutter, ExposesRowsOneAfterTheOther) {
  Renderer renderer;
  Scene scene = plate_at_60_m();
  scene.motion.translation_m = {8 * 0.006, 0, 0};  // 8 px an exposure
  scene.motion.samples = 16;
  scene.motion.readout = 2;
  const cv::Mat image = renderer.render_linear(scene);
  for (const int row : {100, 256, 410}) {
    const SpreadEdge edge = right_edge(image, row);
    EXPECT_NEAR(edge.place_px, kPlateEdgePx + 8 * 2 * (row / 511.0 - 0.5), 0.03) << row;
    EXPECT_NEAR(edge.variance_px2, 8 * 8 / 12.0 + 1.0 / 6, 0.1) << row;
  }
  EXPECT_NEAR(image.at<float>(256, 256), 1, 1e-5) << "each row is exposed once";
  scene.motion.readout = 0;
  EXPECT_NEAR(right_edge(renderer.render_linear(scene), 410).place_px, kPlateEdgePx, 0.03);
}

TEST(RollingShutter, OfAnOpenedLensHasItsPlacesInEachRow) {
  Renderer renderer;
  Scene scene = plate_at_60_m();
  scene.motion.translation_m = {2 * 0.006, 0, 0};
  scene.motion.readout = 1;
  scene.optics = {.aperture_mm = 100, .focus_m = 50, .aperture_samples = 64};
  const double disc_px = 10000 * 0.1 * (1.0 / 50 - 1.0 / 60);
  const cv::Mat image = renderer.render_linear(scene);
  for (const int row : {100, 256, 410}) {
    const SpreadEdge edge = right_edge(image, row);
    EXPECT_NEAR(edge.place_px, kPlateEdgePx + 2 * (row / 511.0 - 0.5), 0.1) << row;
    EXPECT_NEAR(edge.variance_px2, 2 * 2 / 12.0 + disc_px * disc_px / 16 + 1.0 / 6, 0.1) << row;
  }
}

TEST(ChromaticShift, EnlargesTheImagesOfRedAndBlue) {
  Renderer renderer;
  Scene scene = plate_at_60_m();
  scene.samples_per_pixel = 64;  // in steps of which a coordinate of an upright edge is seen
  scene.optics.red_scale = 0.01;
  scene.optics.blue_scale = -0.005;
  scene.colouring.mode = ColourMode::kRgb;
  std::array<cv::Mat, 3> blue_green_red;
  cv::split(renderer.render_linear(scene), blue_green_red.data());
  const double half_px = kPlateEdgePx - 255.5;
  for (const auto& [channel, scale] : {std::pair{0, -0.005}, {1, 0.0}, {2, 0.01}}) {
    const SpreadEdge edge = right_edge(blue_green_red[static_cast<size_t>(channel)], 256);
    EXPECT_NEAR(edge.place_px, 255.5 + (1 + scale) * half_px, 0.02) << channel;
  }
  scene.colouring.mode = ColourMode::kGrey;
  EXPECT_NEAR(right_edge(renderer.render_linear(scene), 256).place_px,
              kPlateEdgePx + (0.2126 * 0.01 - 0.0722 * 0.005) * half_px, 0.02);
}

TEST(Renderer, MemoryStaysFlat) {
#ifdef SIGHTLINE_SANITIZED
  GTEST_SKIP() << "the sanitizer keeps what is freed";
#endif
  Renderer renderer;
  Scene scene = coverage_scene(build_cube().mesh, at(0, 0, 60), 1000);
  scene.camera = centred_camera(64, 64, 1000);
  scene.samples_per_pixel = 4;
  RandomStream stream(1, "poses", 0);
  double before_mb = 0;
  for (int i = 0; i < 1000; ++i) {
    if (i == 200) before_mb = resident_mb();
    scene.cam_from_target.rotation = stream.rotation();
    renderer.render(scene, RandomStream(1, "sensor", i));
  }
  EXPECT_LT(resident_mb() - before_mb, 2);
}

}  // namespace
}  // namespace sightline
