// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/lens.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pose/camera.h"
#include "pose/lenses/catalogue.h"
#include "tests/pose/lenses/lenses_for_tests.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kPixelRounding = 1e-9;  // a few times the last digit of 1000 px, by the inverse

// A ray that the test cameras see, up to 60 degrees from the axis.
Eigen::Vector2d ray(Draw& draw) {
  const double radius = 1.7 * std::sqrt(draw.uniform(0, 1));
  const double direction = draw.uniform(0, 2 * std::numbers::pi);
  return radius * Eigen::Vector2d(std::cos(direction), std::sin(direction));
}

TEST(Lens, DerivativesAreThoseOfDifferences) {
  constexpr double kStep = 1e-6;
  constexpr double kDifference = 2e-9;  // rounding over the step, and the step's square
  Draw draw(1);
  for (const auto& [name, camera] : cameras_with_lenses()) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d x = i == 0 ? Eigen::Vector2d(0, 0) : ray(draw);
      Eigen::Matrix2d of_lens, of_pixel;
      for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d h = kStep * Eigen::Vector2d::Unit(k);
        of_lens.col(k) =
            (distorted(camera.lens, x + h) - distorted(camera.lens, x - h)) / (2 * kStep);
        of_pixel.col(k) =
            (pixel_from_normalised(camera, x + h) - pixel_from_normalised(camera, x - h)) /
            (2 * kStep * (k == 0 ? camera.fx_px : camera.fy_px));
      }
      EXPECT_TRUE(is_matrix_near(distortion_jacobian(camera.lens, x), of_lens, kDifference))
          << name;
      EXPECT_TRUE(is_matrix_near(lens_jacobian(camera, x), of_pixel, 1e-7)) << name;
    }
  }
}

TEST(Lens, WhatACameraSeesIsUndone) {
  Draw draw(2);
  for (const auto& [name, camera] : cameras_with_lenses()) {
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d pixel(draw.uniform(-0.5, camera.width_px - 0.5),
                                  draw.uniform(-0.5, camera.height_px - 0.5));
      const auto seen = normalised_from_pixel(camera, pixel);
      if (!seen) {
        // Of these cameras only a fisheye that is far off its axis sees no ray before it.
        const Eigen::Vector2d image((pixel.x() - camera.cx_px) / camera.fx_px,
                                    (pixel.y() - camera.cy_px) / camera.fy_px);
        EXPECT_TRUE(std::holds_alternative<KannalaBrandt>(camera.lens)) << name;
        EXPECT_GT(image.norm(), 1.4) << name;
        continue;
      }
      const Eigen::Vector3d x_in_cam = 7 * Eigen::Vector3d(seen->x(), seen->y(), 1);
      EXPECT_TRUE(is_matrix_near(project(camera, x_in_cam).value(), pixel, kPixelRounding)) << name;
    }
  }
}

TEST(Lens, ASkewMovesTheRows) {
  Camera camera = centred_camera(640, 480, 500);
  camera.skew_px = 10;
  EXPECT_FALSE(is_straight(camera));
  const Eigen::Vector2d pixel = project(camera, {0.2, 0.3, 1}).value();
  EXPECT_TRUE(is_matrix_near(pixel, Eigen::Vector2d(319.5 + 100 + 3, 239.5 + 150), 1e-12));
  camera.skew_px = 0;
  EXPECT_TRUE(is_straight(camera));
}

TEST(Lens, AnEquidistantLensShowsAngles) {
  const Lens lens = KannalaBrandt{};
  const double angle = 1.2;
  const Eigen::Vector2d seen = distorted(lens, {0, std::tan(angle)});
  EXPECT_TRUE(is_matrix_near(seen, Eigen::Vector2d(0, angle), 1e-15));
  EXPECT_FALSE(is_pinhole(lens));
  EXPECT_TRUE(is_pinhole(Lens()));
}

TEST(Lens, AFisheyeSeesUpToNinetyDegrees) {
  const KannalaBrandt lens{.k1 = 0.05, .k2 = -0.01};
  const auto image_at = [&](double degrees) {
    const double a = degrees * std::numbers::pi / 180;
    return Eigen::Vector2d(a * (1 + 0.05 * a * a - 0.01 * a * a * a * a), 0);
  };
  const auto near = undistorted(lens, image_at(89.9));
  ASSERT_TRUE(near);
  EXPECT_NEAR(std::atan(near->x()), 89.9 * std::numbers::pi / 180, 1e-12);
  EXPECT_FALSE(undistorted(lens, image_at(90)));
  EXPECT_FALSE(undistorted(lens, image_at(95)));
}

TEST(Lens, AFisheyeIsUndoneUntilItFolds) {
  // a (1 - 0.2 a2) grows until a2 = 1 / 0.6 and ends there at 2/3 of a.
  const KannalaBrandt lens{.k1 = -0.2};
  const double fold = std::sqrt(1 / 0.6);
  EXPECT_NEAR(fold_angle(lens), fold, std::numbers::pi / 2 / 2000);
  EXPECT_NEAR(fold_radius(lens, 1e9), std::tan(fold), 0.02);
  EXPECT_EQ(fold_radius(lens, 0.5), 0.5);
  const double end = fold * 2 / 3;
  EXPECT_TRUE(undistorted(lens, {0.999 * end, 0}));
  EXPECT_FALSE(undistorted(lens, {1.001 * end, 0}));
  EXPECT_NEAR(fold_angle({}), std::numbers::pi / 2, 1e-5);
  // Beyond its fold, at a2 = 4/3 and 0.6466, this one grows again; what is seen only there is not.
  const KannalaBrandt twice{.k1 = -0.45, .k2 = 0.09};
  const double a = 1.5;
  const double again = a * (1 - 0.45 * a * a + 0.09 * a * a * a * a);
  EXPECT_GT(1 - 1.35 * a * a + 0.45 * a * a * a * a, 0) << "it grows there";
  EXPECT_GT(again, 0.65);
  EXPECT_FALSE(undistorted(twice, {again, 0}));
  EXPECT_TRUE(undistorted(twice, {0.64, 0}));
}

TEST(Lens, ARationalLensIsUndoneUntilItFolds) {
  // x (1 - 0.3 x2) never exceeds 0.703, as a Brown-Conrady lens.
  const RationalLens barrel{.k1 = -0.3};
  EXPECT_TRUE(undistorted(barrel, {0.69, 0}));
  EXPECT_FALSE(undistorted(barrel, {0.71, 0}));
  EXPECT_NEAR(fold_radius(barrel, 4), std::sqrt(1 / 0.9), 4.0 / 2000);
  EXPECT_NEAR(fold_radius(BrownConrady{.k1 = -0.3}, 4), std::sqrt(1 / 0.9), 4.0 / 2000);
  // The denominator 1 - 0.25 r2 is 0 at r = 2, before which the image grows without end.
  const RationalLens pole{.k4 = -0.25};
  EXPECT_NEAR(fold_radius(pole, 4), 2, 4.0 / 2000);
  EXPECT_TRUE(distortion_jacobian(pole, {2.5, 0}).isZero());
  EXPECT_EQ(fold_radius(RationalLens{}, 4), 4);
}

TEST(Lens, TheCatalogueNamesWhatTheModelsHave) {
  ASSERT_EQ(lens_models().size(), std::variant_size_v<Lens>);
  for (const LensModel& model : lens_models()) {
    EXPECT_EQ(find_lens_model(model.name), &model);
    std::vector<double> given;
    for (std::size_t i = 0; i < model.coefficients.size(); ++i) given.push_back(0.01 * (i + 1));
    const auto lens = make_lens(model, given);
    ASSERT_TRUE(lens) << model.name;
    EXPECT_EQ(&model_of(*lens), &model);
    EXPECT_EQ(coefficients_of(*lens), given);
    given.push_back(0);
    EXPECT_FALSE(make_lens(model, given)) << model.name;
  }
  EXPECT_EQ(find_lens_model("omni"), nullptr);
  const std::vector<double> four = {1, 2, 3, 4};
  EXPECT_EQ(make_lens(*find_lens_model("brown_conrady"), four),
            Lens(BrownConrady{.k1 = 1, .k2 = 2, .p1 = 3, .p2 = 4}));
  EXPECT_FALSE(make_lens(*find_lens_model("rational"), four));
}

}  // namespace
}  // namespace sightline
