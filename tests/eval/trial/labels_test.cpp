// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/labels.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "scenes/scene/scene_law.h"

namespace sightline {
namespace {

// The 707 in plan view: its port wing tip's leading-edge corner is seen, the fin's tip too.
class Labels : public testing::Test {
 protected:
  void SetUp() override {
    scene_.target = load_target("boeing707");
    scene_.camera = centred_camera(512, 512, 10000);
    scene_.cam_from_target = pose_from({0, 0, 0}, {0, 0, 1300});
    frame_ = Renderer().render(scene_, RandomStream(1, "sensor", 0));
    for (size_t i = 0; i < scene_.target->features.size(); ++i) {
      if (scene_.target->features[i].name == "wing_tip_le_port") corner_ = static_cast<int>(i);
      if (scene_.target->features[i].name == "nose") nose_ = static_cast<int>(i);
    }
  }

  const Eigen::Vector2d& truth(int feature) const {
    return frame_.truth.target().features[feature].pixel;
  }

  Eigen::Vector2d pixel_of(const Eigen::Vector3d& x) const {
    return *project(scene_.camera, scene_.cam_from_target * x);
  }

  // The image of an edge from its beginning on, displaced.
  ImageLine line_along(const Edge& edge, const Eigen::Vector2d& shift) const {
    const Eigen::Vector2d begin = pixel_of(edge.begin_m), end = pixel_of(edge.end_m);
    ImageLine line;
    line.direction = (end - begin).normalized();
    for (int i = 0; i < 12; ++i) line.edge_pixels.push_back(begin + i * line.direction + shift);
    line.point = begin + shift;
    return line;
  }

  Observation seen(int feature, const Eigen::Vector2d& error) const {
    Observation observation;
    observation.feature = feature;
    observation.status = ObservationStatus::kFound;
    observation.pixel = truth(feature) + error;
    return observation;
  }

  Observation corner_with_lines(const Eigen::Vector2d& error, const Eigen::Vector2d& first_shift,
                                const Eigen::Vector2d& second_shift) const {
    Observation observation = seen(corner_, error);
    const auto& edges = scene_.target->features[corner_].edges;
    observation.lines = {line_along(edges[0], first_shift), line_along(edges[1], second_shift)};
    return observation;
  }

  ObservationLabel of(const Observation& observation, const LabelLimits& limits = {}) const {
    return label(observation, scene_, frame_, limits).label;
  }

  Scene scene_;
  Frame frame_;
  int corner_ = -1;
  int nose_ = -1;
};

TEST_F(Labels, WhatIsNearTheTruthIsAnInlier) {
  const LabelledObservation near = label(seen(corner_, {3, 0}), scene_, frame_, {});
  EXPECT_EQ(near.label, ObservationLabel::kInlier);
  EXPECT_FALSE(near.is_outlier);
  EXPECT_NEAR(near.error_px, 3, 1e-12);
  EXPECT_NEAR(near.error_sigmas, 3, 1e-12);
  EXPECT_NE(of(seen(corner_, {6, 0})), ObservationLabel::kInlier);
}

// White paint of 0.8 under 0.3 + 0.75 cos on a background of 0.15 of white.
TEST_F(Labels, ContrastIsThatOfTheFeaturesOwnEdges) {
  const double wing_grey = contrast_grey(corner_, scene_, frame_);
  EXPECT_GT(wing_grey, 100);
  EXPECT_LT(wing_grey, 200);
  Scene grey = scene_;
  grey.background.level = 0.75;
  const Frame faint = Renderer().render(grey, RandomStream(1, "sensor", 0));
  EXPECT_LT(contrast_grey(corner_, grey, faint), wing_grey / 2);
  // The fin is seen along its plane: none of its edges shows.
  for (size_t i = 0; i < scene_.target->features.size(); ++i) {
    if (scene_.target->features[i].name != "fin_tip_te") continue;
    EXPECT_EQ(contrast_grey(static_cast<int>(i), scene_, frame_), 0);
  }
}

TEST_F(Labels, ContrastHasTheUnitOfEightBitsWhateverTheSensors) {
  Scene deep = scene_;
  deep.sensor.bits = 12;
  const Frame frame = Renderer().render(deep, RandomStream(1, "sensor", 0));
  EXPECT_NEAR(contrast_grey(corner_, deep, frame), contrast_grey(corner_, scene_, frame_), 2);
}

TEST_F(Labels, WhatHasTooLittleContrastIsNotToBeSeen) {
  const double contrast = contrast_grey(corner_, scene_, frame_);
  LabelLimits limits;
  limits.least_contrast_grey = contrast - 1;
  EXPECT_TRUE(label(seen(corner_, {0, 0}), scene_, frame_, limits).is_visible);
  EXPECT_EQ(of(seen(corner_, {0, 0}), limits), ObservationLabel::kInlier);
  limits.least_contrast_grey = contrast + 1;
  EXPECT_FALSE(label(seen(corner_, {0, 0}), scene_, frame_, limits).is_visible);
  EXPECT_EQ(of(seen(corner_, {0, 0}), limits), ObservationLabel::kHidden);
  Observation unseen = seen(corner_, {0, 0});
  unseen.status = ObservationStatus::kTooFewEdgePixels;
  EXPECT_EQ(of(unseen, limits), ObservationLabel::kAbsent);
  EXPECT_EQ(of(unseen), ObservationLabel::kMissing);
}

TEST_F(Labels, TheObservationsOwnCovarianceCounts) {
  Observation observation = seen(corner_, {1, 1});
  observation.covariance_px2 << 4, 0, 0, 0.01;
  const LabelLimits limits{.outlier_px = 5, .outlier_sigmas = 5, .line_px = 3};
  const LabelledObservation labelled = label(observation, scene_, frame_, limits);
  EXPECT_NEAR(labelled.error_sigmas, std::sqrt(1 / 4.0 + 1 / 0.01), 1e-9);
  EXPECT_TRUE(labelled.is_outlier);
  observation.covariance_px2 << 4, 0, 0, 0.1;
  EXPECT_FALSE(label(observation, scene_, frame_, limits).is_outlier);
}

TEST_F(Labels, ALineAlongAnotherEdgeIsAWrongLine) {
  // The trailing edge taken for the leading edge: 20 px away along the tip.
  const auto& edges = scene_.target->features[corner_].edges;
  const Eigen::Vector2d chord = pixel_of(edges[1].end_m) - pixel_of(edges[1].begin_m);
  EXPECT_EQ(of(corner_with_lines(chord, chord, {0, 0})), ObservationLabel::kWrongLine);
}

TEST_F(Labels, TwoLinesAlongTheSameEdgeAreNotBothRight) {
  Observation observation = corner_with_lines({9, 0}, {0, 0}, {0, 0});
  observation.lines[1] = observation.lines[0];
  EXPECT_EQ(of(observation), ObservationLabel::kWrongLine);
}

TEST_F(Labels, RightLinesThatMeetFarOffAreAWrongIntersection) {
  EXPECT_EQ(of(corner_with_lines({9, 0}, {0.5, 0}, {0, 0.5})),
            ObservationLabel::kWrongIntersection);
}

// A lens bends the middles of the edges by several pixels off the lines between their ends.
TEST_F(Labels, ThroughALensLinesAreRightWhereTheCurvesAre) {
  scene_.camera.lens = BrownConrady{.k1 = -300};
  frame_ = Renderer().render(scene_, RandomStream(1, "sensor", 0));
  const auto with_middles_off_by = [&](double off_px) {
    Observation observation = seen(corner_, {10, 0});
    for (const Edge& edge : scene_.target->features[corner_].edges) {
      const auto at = [&](double t) {
        return pixel_of(edge.begin_m + t * (edge.end_m - edge.begin_m));
      };
      ImageLine line;
      line.direction = (at(0.55) - at(0.45)).normalized();
      const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
      for (int i = 0; i < 12; ++i) {
        line.edge_pixels.push_back(at(0.45 + i / 110.0) + off_px * normal);
      }
      observation.lines.push_back(line);
    }
    return of(observation);
  };
  const LabelLimits limits;
  EXPECT_EQ(with_middles_off_by(0), ObservationLabel::kWrongIntersection);
  EXPECT_EQ(with_middles_off_by(0.97 * limits.line_px), ObservationLabel::kWrongIntersection);
  EXPECT_EQ(with_middles_off_by(1.03 * limits.line_px), ObservationLabel::kWrongLine);
}

TEST_F(Labels, ALineOffTheTargetIsClutter) {
  const Eigen::Vector2d off = 30 * (truth(corner_) - Eigen::Vector2d(255.5, 255.5)).normalized();
  EXPECT_EQ(of(corner_with_lines(off, off, off)), ObservationLabel::kClutter);
}

TEST_F(Labels, APointWithoutLinesIsOfTheTargetOrClutter) {
  EXPECT_EQ(of(seen(nose_, {-10, 0})), ObservationLabel::kWrongPoint);  // aft: on the fuselage
  EXPECT_EQ(of(seen(nose_, {10, 0})), ObservationLabel::kClutter);      // ahead: sky
}

// Nobody knows then which pixels show the target, nor what contrast its edges have: an error is
// told by its distance alone, and a line by the edge that it should lie on.
TEST_F(Labels, OfKeypointsAloneNothingIsClutter) {
  const Eigen::Vector2d off = 30 * (truth(corner_) - Eigen::Vector2d(255.5, 255.5)).normalized();
  const Observation point = seen(nose_, {10, 0}), lines = corner_with_lines(off, off, off);
  LabelLimits faint;
  faint.least_contrast_grey = 255;
  EXPECT_EQ(of(point), ObservationLabel::kClutter);
  EXPECT_EQ(of(lines), ObservationLabel::kClutter);
  EXPECT_EQ(of(seen(corner_, {0, 0}), faint), ObservationLabel::kHidden);
  auto points = std::make_shared<Target>(*scene_.target);
  points->mesh.triangles.clear();
  scene_.target = points;
  EXPECT_EQ(of(point), ObservationLabel::kWrongPoint);
  EXPECT_EQ(of(lines), ObservationLabel::kWrongLine);
  EXPECT_EQ(of(seen(nose_, {3, 0})), ObservationLabel::kInlier);
  EXPECT_EQ(of(seen(corner_, {0, 0}), faint), ObservationLabel::kInlier);
}

TEST_F(Labels, AnotherBodysPixelsAreClutter) {
  const Eigen::Vector2d pixel = truth(nose_) + Eigen::Vector2d(-10, 0);
  frame_.body_ids.at<uint8_t>(static_cast<int>(std::lround(pixel.y())),
                              static_cast<int>(std::lround(pixel.x()))) = 2;
  EXPECT_EQ(of(seen(nose_, {-10, 0})), ObservationLabel::kClutter);
}

TEST_F(Labels, HiddenMissingAndAbsentAreTold) {
  Observation missing = seen(corner_, {0, 0});
  missing.status = ObservationStatus::kTooFewEdgePixels;
  EXPECT_EQ(of(missing), ObservationLabel::kMissing);
  EXPECT_TRUE(std::isnan(label(missing, scene_, frame_, {}).error_px));
  frame_.truth.bodies.front().features[corner_].is_visible = false;
  EXPECT_EQ(of(missing), ObservationLabel::kAbsent);
  EXPECT_EQ(of(seen(corner_, {0, 0})), ObservationLabel::kHidden);
}

TEST_F(Labels, EvidenceBeyondTheImageIsClutter) {
  EXPECT_EQ(of(seen(nose_, {1e6, 0})), ObservationLabel::kClutter);
}

}  // namespace
}  // namespace sightline
