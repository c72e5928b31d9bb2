// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A cube by its facets, on images of exact area coverage: no renderer has a part in them.
#include "features/facet_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "scenes/builders/cube.h"
#include "scenes/target/target.h"
#include "tests/features/plate.h"
#include "tests/scenes/prism.h"

namespace sightline {
namespace {

constexpr double kBlurPx = 0.7;
constexpr int kGreys = facet_parameter::kGreys;

Camera camera() {
  return centred_camera(kPlateImagePx, kPlateImagePx, 8000);
}

const Facets& cube() {
  static const Facets facets = facets_of(build_cube().mesh);
  return facets;
}

// Turned by these angles from face on, about the camera's y axis first.
Pose pose_at(double about_y_deg, double about_x_deg, const Eigen::Vector2d& shift_m = {0, 0}) {
  Pose pose;
  pose.rotation = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(about_x_deg * kDegree, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(about_y_deg * kDegree, Eigen::Vector3d::UnitY()))
                      .toRotationMatrix();
  pose.translation = {shift_m.x(), shift_m.y(), 100};
  return pose;
}

// The border of a facet, in order, in the image.
std::vector<Eigen::Vector2d> outline_of(int facet, const Pose& pose) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> sides;
  for (const FacetEdge& edge : cube().edges) {
    if (edge.facet[0] == facet) sides.emplace_back(edge.begin_m, edge.end_m);
    if (edge.facet[1] == facet) sides.emplace_back(edge.end_m, edge.begin_m);
  }
  std::vector<Eigen::Vector2d> outline;
  Eigen::Vector3d at = sides.front().first;
  for (size_t i = 0; i < sides.size(); ++i) {
    outline.push_back(*project(camera(), pose * at));
    at = std::find_if(sides.begin(), sides.end(), [&](const auto& side) {
           return side.first == at;
         })->second;
  }
  return outline;
}

// Facets of 60, 110, 160 ... before a background of 20.
cv::Mat image_of(const Pose& pose, double noise_grey, uint64_t index) {
  const Eigen::Vector3d eye_m = inverse(pose).translation;
  cv::Mat light = cv::Mat::zeros(kPlateImagePx, kPlateImagePx, CV_32F);
  double grey = 40;
  for (size_t f = 0; f < cube().facets.size(); ++f) {
    if (!cube().facets[f].is_towards(eye_m)) continue;
    light += grey / 255 * coverage(outline_of(static_cast<int>(f), pose), kPlateImagePx);
    grey += 50;
  }
  PlateImage how;
  how.inside = 275;
  how.outside = 20;
  how.blur_px = kBlurPx;
  how.noise_grey = noise_grey;
  how.index = index;
  return exposed(light, how);
}

// The vertex of the cube that is nearest to the camera.
Eigen::Vector3d nearest_vertex_m(const Pose& pose) {
  const Mesh mesh = build_cube().mesh;
  return *std::min_element(mesh.vertices.begin(), mesh.vertices.end(),
                           [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                             return (pose * a).z() < (pose * b).z();
                           });
}

Pose displaced(const Pose& pose, const Eigen::Vector3d& point_m, const Eigen::Vector2d& shift_px,
               const Eigen::Vector3d& turn_rad) {
  const Eigen::Vector3d point = pose * point_m;
  Pose out;
  out.rotation = rotation_from_vector(turn_rad) * pose.rotation;
  out.translation = point +
                    point.z() / camera().fx_px * Eigen::Vector3d(shift_px.x(), shift_px.y(), 0) -
                    out.rotation * point_m;
  return out;
}

// The share of a Gaussian about a pixel that falls on a convex outline, by summing over a grid.
double summed_share(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& pixel,
                    double blur_px) {
  constexpr int kHalf = 120;
  constexpr double kReach = 5;
  double inside = 0;
  double all = 0;
  for (int i = -kHalf; i <= kHalf; ++i) {
    for (int k = -kHalf; k <= kHalf; ++k) {
      const Eigen::Vector2d z = kReach / kHalf * Eigen::Vector2d(i, k);
      const double weight = std::exp(-z.squaredNorm() / 2);
      const Eigen::Vector2d p = pixel + blur_px * z;
      bool is_inside = true;
      for (size_t e = 0; e < outline.size(); ++e) {
        const Eigen::Vector2d along = outline[(e + 1) % outline.size()] - outline[e];
        const Eigen::Vector2d off = p - outline[e];
        is_inside = is_inside && along.y() * off.x() - along.x() * off.y() >= 0;
      }
      all += weight;
      if (is_inside) inside += weight;
    }
  }
  return inside / all;
}

TEST(FacetView, SharesAreTheGaussiansPartsOnTheFacets) {
  for (const Pose& pose : {pose_at(35, 25), pose_at(2, 30), pose_at(3, 4)}) {
    const cv::Mat image = image_of(pose, 0, 0);
    const FacetPatch patch{image, cube(), camera(), nearest_vertex_m(pose)};
    const auto view = FacetView::of(patch, pose);
    ASSERT_TRUE(view);
    ASSERT_EQ(view->greys(), 4);
    std::vector<int> seen;
    for (size_t f = 0; f < cube().facets.size(); ++f) {
      if (cube().facets[f].is_towards(inverse(pose).translation)) {
        seen.push_back(static_cast<int>(f));
      }
    }
    FacetVector x = FacetVector::Zero(kGreys + 4);
    x[facet_parameter::kBlur] = 0.9;
    FacetRow row;
    for (const Eigen::Vector2d& off :
         {Eigen::Vector2d(0, 0), {0.4, -0.3}, {-2.1, 1.2}, {3, 3}, {-1, -5}, {9.3, 0.1}}) {
      const Eigen::Vector2d p = view->pixel() + off;
      view->fill_row(p.x(), p.y(), x, row);
      double rest = 1;
      for (int i = 0; i < 3; ++i) {
        const double share = summed_share(outline_of(seen[i], pose), p, 0.9);
        EXPECT_NEAR(row[kGreys + 1 + i], share, 5e-3) << off.transpose();
        rest -= row[kGreys + 1 + i];
      }
      EXPECT_NEAR(row[kGreys], rest, 1e-9);
    }
  }
}

TEST(FacetView, DerivativesAreThoseOfItsShares) {
  const Pose pose = pose_at(8, 30, {0.02, 0.01});
  const cv::Mat image = image_of(pose, 0, 0);
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  const FacetPatch patch{image, cube(), camera(), point_m};
  const auto view = FacetView::of(patch, pose);
  FacetVector x = FacetVector::Zero(kGreys + 4);
  x[facet_parameter::kBlur] = 0.8;
  x.tail(4) << 20, 60, 110, 160;
  const auto grey_at = [&](const FacetView& from, const Eigen::Vector2d& p, const FacetVector& at) {
    FacetRow row;
    from.fill_row(p.x(), p.y(), at, row);
    double grey = 0;
    for (int i = kGreys; i < at.size(); ++i) grey += row[i] * at[i];
    return grey;
  };
  FacetRow row;
  for (const PatchPixel& pixel : view->pixels(patch)) {
    const Eigen::Vector2d p(pixel.u, pixel.v);
    view->fill_row(p.x(), p.y(), x, row);
    for (int i = 0; i < facet_parameter::kMotion; ++i) {
      const double h = i < 2 ? 0.05 : 0.001;
      std::array<double, 2> grey;
      for (const int side : {0, 1}) {
        Eigen::Matrix<double, 5, 1> step = Eigen::Matrix<double, 5, 1>::Zero();
        step[i] = side == 0 ? -h : h;
        const auto there =
            FacetView::of(patch, displaced(pose, point_m, step.head<2>(), step.tail<3>()));
        grey[side] = grey_at(*there, p, x);
      }
      // The tables are good to 1e-4 of a contrast.
      const double tolerance = 0.02 / h + 0.01 * std::abs(row[i]);
      EXPECT_NEAR(row[i], (grey[1] - grey[0]) / (2 * h), tolerance) << i << ' ' << p.transpose();
    }
    FacetVector less = x, more = x;
    less[facet_parameter::kBlur] -= 0.02;
    more[facet_parameter::kBlur] += 0.02;
    EXPECT_NEAR(row[facet_parameter::kBlur],
                (grey_at(*view, p, more) - grey_at(*view, p, less)) / 0.04, 0.5);
  }
}

// Borders through the middles of pixels, where inside and outside are a matter of convention.
TEST(FacetView, PixelsOnABorderAreHalfInside) {
  Pose pose;
  pose.translation = {0, 0, 100.5};  // its front face spans 80 px, from 40 to 120
  const cv::Mat image(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(0));
  const FacetPatch patch{image, cube(), camera(), nearest_vertex_m(pose)};
  const auto view = FacetView::of(patch, pose);
  ASSERT_TRUE(view);
  ASSERT_EQ(view->greys(), 2);
  FacetVector x = FacetVector::Zero(kGreys + 2);
  x[facet_parameter::kBlur] = 0.8;
  FacetRow row;
  const Eigen::Vector2d corner = view->pixel();
  EXPECT_NEAR((corner - Eigen::Vector2d(80, 80)).cwiseAbs().minCoeff(), 40, 1e-9);
  const auto share_at = [&](const Eigen::Vector2d& p) {
    view->fill_row(p.x(), p.y(), x, row);
    return row[kGreys + 1];
  };
  EXPECT_NEAR(share_at(corner), 0.25, 1e-4);
  const Eigen::Vector2d inwards = Eigen::Vector2d(80, 80) - corner;
  for (const double part : {0.25, 0.5}) {
    const Eigen::Vector2d along_u(part * inwards.x(), 0), along_v(0, part * inwards.y());
    EXPECT_NEAR(share_at(corner + along_u), 0.5, 1e-4);
    EXPECT_NEAR(share_at(corner + along_v), 0.5, 1e-4);
    EXPECT_NEAR(share_at(corner + along_u + along_v), 1, 1e-4);
    EXPECT_NEAR(share_at(corner - along_u), 0, 1e-4);
    EXPECT_NEAR(share_at(corner - along_u - along_v), 0, 1e-4);
  }
}

// From outside its angle one arm of an L hides the other's inner side in part.
TEST(FacetView, PixelsWhereAFacetHidesAnotherAreLeftOut) {
  Facets angle = facets_of(prism({{0, 0}, {1, 0}, {1, 0.5}, {0.5, 0.5}, {0.5, 1}, {0, 1}}));
  ASSERT_FALSE(angle.is_convex);
  const Camera cam = camera();
  Pose pose;
  pose.rotation.row(2) = Eigen::Vector3d(-1, 0.5, -0.4).normalized();  // where the camera looks
  pose.rotation.row(0) = Eigen::Vector3d(-0.5, -1, 0).normalized();
  pose.rotation.row(1) = pose.rotation.row(2).cross(pose.rotation.row(0));
  pose.translation = Eigen::Vector3d(0, 0, 100) - pose.rotation * Eigen::Vector3d(0.5, 0.5, 0.5);
  const cv::Mat image(kPlateImagePx, kPlateImagePx, CV_8U, cv::Scalar(0));
  const auto overlapping = [&] {
    const FacetPatch patch{image, angle, cam, {1, 0.5, 1}};
    const auto view = FacetView::of(patch, pose);
    FacetVector x = FacetVector::Zero(kGreys + view->greys());
    x[facet_parameter::kBlur] = 0.8;
    FacetRow row;
    int overlaps = 0;
    const std::vector<PatchPixel> pixels = view->pixels(patch);
    for (const PatchPixel& pixel : pixels) {
      view->fill_row(pixel.u, pixel.v, x, row);
      overlaps += row[kGreys] < -0.01;
    }
    return std::pair(overlaps, pixels.size());
  };
  const auto [left, kept] = overlapping();
  EXPECT_EQ(left, 0);
  EXPECT_GT(kept, 100u);
  angle.is_convex = true;  // which it is not
  const auto [wrong, all] = overlapping();
  EXPECT_GT(wrong, 50);
  EXPECT_GT(all, kept);
}

struct Spread {
  double rms_px = 0, rms_sigmas = 0;
  int found = 0;
};

Spread spread_at(double about_y_deg, double about_x_deg) {
  constexpr int kDraws = 60;
  constexpr double kNoise = 3;
  RandomStream stream(7, "facets", 0);
  Spread spread;
  for (int i = 0; i < kDraws; ++i) {
    const Pose pose = pose_at(about_y_deg, about_x_deg,
                              {stream.uniform(-0.01, 0.01), stream.uniform(-0.01, 0.01)});
    const Eigen::Vector3d point_m = nearest_vertex_m(pose);
    const cv::Mat image = image_of(pose, kNoise, static_cast<uint64_t>(i));
    const Facets& facets = cube();
    const Camera cam = camera();
    const FacetPatch patch{image, facets, cam, point_m, 30, kNoise};
    const Pose start = displaced(pose, point_m, {0.6 * stream.normal(), 0.6 * stream.normal()},
                                 0.01 * Eigen::Vector3d(stream.normal(), stream.normal(), 0));
    const auto fit = fit_facets(patch, start);
    if (!fit || fit->rms_grey > 1.3 * kNoise) continue;
    const Eigen::Vector2d error = fit->pixel - *project(cam, pose * point_m);
    spread.found += 1;
    spread.rms_px += error.squaredNorm() / (2 * kDraws);
    spread.rms_sigmas += error.dot(fit->covariance_px2.inverse() * error) / (2 * kDraws);
  }
  spread.rms_px = std::sqrt(spread.rms_px);
  spread.rms_sigmas = std::sqrt(spread.rms_sigmas);
  return spread;
}

// 60 draws of two numbers: the spread in sigmas is 1 to 0.065, twice that is asked and more.
TEST(FacetFit, SigmasAreHonest) {
  for (const auto& [y_deg, x_deg] : {std::pair{35.0, 25.0}, {20.0, 50.0}, {4.0, 30.0}}) {
    const Spread spread = spread_at(y_deg, x_deg);
    EXPECT_GE(spread.found, 58) << y_deg;
    EXPECT_GT(spread.rms_sigmas, 0.8) << y_deg;
    EXPECT_LT(spread.rms_sigmas, 1.25) << y_deg;
    EXPECT_LT(spread.rms_px, 0.05) << y_deg;
  }
}

// A face 2 px wide, whose two long edges blur into one another.
TEST(FacetFit, TellsApartWhatBlursIntoOne) {
  const Pose pose = pose_at(1.5, 30);
  const cv::Mat image = image_of(pose, 3, 0);
  const Facets& facets = cube();
  const Camera cam = camera();
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  const auto fit = fit_facets({image, facets, cam, point_m}, pose);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->rms_grey, 3.3);
  const Eigen::Vector2d error = fit->pixel - *project(cam, pose * point_m);
  EXPECT_LT(error.dot(fit->covariance_px2.inverse() * error), 16);
  EXPECT_LT(error.norm(), 0.3);
}

TEST(FacetFit, DoesNotExplainWhatIsNotFacets) {
  const Pose pose = pose_at(35, 25);
  cv::Mat image = image_of(pose, 3, 0);
  const Facets& facets = cube();
  const Camera cam = camera();
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  const auto fit = fit_facets({image, facets, cam, point_m}, pose);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->rms_grey, 3.3);
  for (int v = 0; v < image.rows; v += 4) image.row(v) /= 2;
  const auto striped = fit_facets({image, facets, cam, point_m}, pose);
  EXPECT_TRUE(!striped || striped->rms_grey > 10);
}

// A smudge that is no part of the target: the lines find the vertex, the facets do not.
TEST(ModelEdges, WhatFacetsDoNotExplainIsLeftToTheLines) {
  const auto target = load_target("cube");
  const Pose pose = pose_at(35, 25);
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  const Eigen::Vector2d vertex = *project(camera(), pose * point_m);
  const auto feature = std::find_if(
      target->features.begin(), target->features.end(),
      [&](const TargetFeature& one) { return (one.position_m - point_m).norm() < 1e-6; });
  ASSERT_NE(feature, target->features.end());
  const int index = static_cast<int>(feature - target->features.begin());
  const PosePrior prior = prior_of(pose, camera(), {});
  const FeatureExtractor* const extractor = find_feature_extractor("model_edges");
  const auto error_px = [&](const cv::Mat& image) {
    const PredictedView view = predict_features(*target, std::array{index}, camera(), prior);
    const auto seen = extract_features(image, 255, view, {extractor, extractor, extractor}, {});
    EXPECT_EQ(seen[0].status, ObservationStatus::kFound);
    return (seen[0].pixel - vertex).norm();
  };
  cv::Mat image = image_of(pose, 3, 0);
  EXPECT_LT(error_px(image), 0.1);
  cv::circle(image, {static_cast<int>(vertex.x()) + 4, static_cast<int>(vertex.y()) + 3}, 6,
             cv::Scalar(120), cv::FILLED);
  const Facets& facets = cube();
  const Camera cam = camera();
  const auto fit = fit_facets({image, facets, cam, point_m}, pose);
  ASSERT_TRUE(fit);
  EXPECT_GT((fit->pixel - vertex).norm(), 1);
  EXPECT_LT(error_px(image), 0.3);
}

TEST(FacetFit, NeedsFacetsInFrontOfTheCamera) {
  const Pose pose = pose_at(35, 25);
  const cv::Mat image = image_of(pose, 3, 0);
  const Facets none;
  const Facets& facets = cube();
  const Camera cam = camera();
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  EXPECT_TRUE(fit_facets({image, facets, cam, point_m}, pose));
  EXPECT_FALSE(fit_facets({image, none, cam, point_m}, pose));
  Pose behind = pose;
  behind.translation.z() = -100;
  EXPECT_FALSE(fit_facets({image, facets, cam, point_m}, behind));
  Pose outside = pose;
  outside.translation.x() = 50;
  EXPECT_FALSE(fit_facets({image, facets, cam, point_m}, outside));
}

TEST(MostAlike, PutsTheTruthFirst) {
  const Pose pose = pose_at(35, 25);
  const cv::Mat image = image_of(pose, 3, 0);
  const Facets& facets = cube();
  const Camera cam = camera();
  const Eigen::Vector3d point_m = nearest_vertex_m(pose);
  std::vector<Pose> poses;
  // At the first there is nothing but background, which any facets explain to the noise.
  for (const double shift_px : {60.0, -5.0, 0.0, 1.0}) {
    poses.push_back(displaced(pose, point_m, {shift_px, shift_px}, {0, 0, 0}));
  }
  const auto alike = most_alike({image, facets, cam, point_m}, poses, 2);
  ASSERT_EQ(alike.size(), 2u);
  EXPECT_EQ(alike[0].translation, poses[2].translation);
  EXPECT_EQ(alike[1].translation, poses[3].translation);
}

}  // namespace
}  // namespace sightline
