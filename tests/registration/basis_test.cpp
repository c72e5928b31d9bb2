// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/basis.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "registration/model_view.h"
#include "tests/registration/scenes_for_registration.h"

namespace sightline {
namespace {

// Of 1: the images are of single precision.
constexpr double kRounding = 1e-6;

// The greatest difference between the renderer's picture of a scene and the sum of basis images.
double difference_from_renderer(const Scene& scene, const Light& light) {
  Renderer renderer;
  const cv::Mat rendered = renderer.render_linear(scene);
  BasisDrawer drawer(scene.target->mesh, scene.camera);
  BasisOptions options;
  options.samples_per_pixel = scene.samples_per_pixel;
  options.to_light_in_cam = light.to_light_in_cam;
  const auto basis = drawer.draw(scene.cam_from_target, options);
  EXPECT_TRUE(basis);
  cv::Mat sum = light.ambient * basis->albedo + scene.background.level * (1 - basis->coverage);
  for (int k = 0; k < 3; ++k) {
    sum +=
        light.directional * light.to_light_in_cam[k] * basis->albedo_normal[static_cast<size_t>(k)];
  }
  return cv::norm(sum, rendered(basis->box), cv::NORM_INF);
}

BasisOptions with_margin(int margin) {
  BasisOptions options;
  options.margin_px = margin;
  return options;
}

TEST(Basis, SumsToTheRenderersPicture) {
  const Scene scene = brick_scene();
  EXPECT_LT(difference_from_renderer(scene, scene.light), kRounding);
  Light other = scene.light;
  other.to_light_in_cam = Eigen::Vector3d(-0.3, -0.4, -0.8).normalized();
  EXPECT_GT(difference_from_renderer(scene, other), 0.01) << "of another light";
}

TEST(Basis, SumsToTheRenderersPictureThroughALens) {
  Scene scene = brick_scene();
  std::get<BrownConrady>(scene.camera.lens).k1 = -0.3;
  EXPECT_LT(difference_from_renderer(scene, scene.light), kRounding);
}

TEST(Basis, SeesNoBacksOfWhatHasOneSide) {
  for (const bool has_back : {false, true}) {
    Scene scene = brick_scene();
    Mesh sheet = plate(1);
    sheet.parts[0].material.emplace().is_two_sided = has_back;
    scene.target = target_of(std::move(sheet));
    scene.cam_from_target = at(0, 0, 10, {0, 3, 0});
    BasisDrawer drawer(scene.target->mesh, scene.camera);
    EXPECT_EQ(drawer.draw(scene.cam_from_target, with_margin(2)).has_value(), has_back);
  }
}

TEST(Basis, SaysWhereTheNearestSurfaceIs) {
  Scene scene = brick_scene();
  scene.target = target_of(plate(1));
  scene.cam_from_target = at(0, 0, 10);
  BasisDrawer drawer(scene.target->mesh, scene.camera);
  const auto basis = drawer.draw(scene.cam_from_target, with_margin(2));
  ASSERT_TRUE(basis);
  // 1 m at 10 m: 130 px, from -65 to 65 px about the middle, 127.5.
  EXPECT_NEAR(cv::sum(basis->coverage)[0], 130 * 130, 1e-3 * 130 * 130);
  const cv::Vec3f middle = basis->front_m.at<cv::Vec3f>(127 - basis->box.y, 127 - basis->box.x);
  EXPECT_NEAR(middle[2], 10, 1e-5);
  EXPECT_NEAR(middle[0], -0.5 / 130, 0.5 / 130);
  EXPECT_EQ(basis->front_m.at<cv::Vec3f>(0, 0)[2], 0) << "beside the plate";
}

TEST(Basis, HasNothingToShowOfWhatIsNotInTheImage) {
  const Scene scene = brick_scene();
  BasisDrawer drawer(scene.target->mesh, scene.camera);
  EXPECT_FALSE(drawer.draw(at(0, 0, -10), {}));
  EXPECT_FALSE(drawer.draw(at(50, 0, 10), {}));
  EXPECT_TRUE(drawer.draw(at(0, 0, 10), {}));
}

// The model's derivatives are those of its own pictures.
TEST(ModelView, BlurIsWhatTheLaplacianSays) {
  const Scene scene = brick_scene();
  BasisDrawer drawer(scene.target->mesh, scene.camera);
  const auto basis = drawer.draw(scene.cam_from_target, with_margin(margin_px(1)));
  ASSERT_TRUE(basis);
  const LightVector light(80, 20, -30, -90, 38);
  constexpr double kStep = 0.02;       // px^2 of variance
  constexpr double kTolerance = 0.05;  // of differences of sixth order at a blur of 1 px
  const auto picture = [&](double variance) {
    return model_picture(model_view(*basis, std::sqrt(variance), RegistrationRegion::kImage),
                         light);
  };
  const cv::Mat by_difference = (picture(1 + kStep).grey - picture(1 - kStep).grey) / (2 * kStep);
  const cv::Mat by_law = picture(1).half_laplacian;
  const double size = cv::norm(by_difference, cv::NORM_L2);
  EXPECT_GT(size, 10);
  EXPECT_LT(cv::norm(by_difference, by_law, cv::NORM_L2), kTolerance * size);
}

}  // namespace
}  // namespace sightline
