// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Targets of keypoints alone in studies, on image sets and in the program's commands.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/trial/image_trial.h"
#include "scenes/target/target.h"
#include "tests/eval/program.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string point_text(const Eigen::Vector3d& point, double factor) {
  return fmt::format("[{}, {}, {}]", factor * point.x(), factor * point.y(), factor * point.z());
}

// The features of a shipped target as keypoints alone, `factor` times as large.
std::string keypoints_of(const std::string& target, double factor = 1) {
  std::string text = fmt::format("name = 'points of the {}'\n", target);
  const auto loaded = load_target(target);
  for (const TargetFeature& feature : loaded->features) {
    text += fmt::format("[[feature]]\nname = '{}'\nposition_m = {}\n", feature.name,
                        point_text(feature.position_m, factor));
    if (feature.kind != FeatureKind::kLineIntersection) continue;
    text += "kind = 'line_intersection'\nedges_m = [\n";
    for (const Edge& edge : feature.edges) {
      text += fmt::format("  [{}, {}],\n", point_text(edge.begin_m, factor),
                          point_text(edge.end_m, factor));
    }
    text += "]\n";
  }
  return text;
}

class KeypointTarget : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text).string();
  }
  // One line that says what is missing, and nothing made.
  void expect_refused(const std::string& arguments, const std::string& why) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(why)) << arguments;
    EXPECT_FALSE(fs::exists(path("out"))) << arguments;
  }
  // A set of images of the cube in BOP's format.
  std::string cube_set() const {
    const Outcome made =
        run("render cube --count 6 --seed 5 --quiet --set camera.width_px=256 --set "
            "camera.height_px=256 --set camera.f_px=1000 --out " +
            path("set"));
    EXPECT_EQ(made.exit_code, 0) << made.output;
    return path("set");
  }
  TemporaryFolder folder_;
};

const std::string kNumeric =
    "kind = 'numeric'\nsolvers = ['orpe_weighed', 'lspe']\ntrials = 20\n"
    "[camera]\nwidth_px = 512\nheight_px = 512\nf_px = 4000.0\n"
    "[poses]\nlateral_m = [-1, 1]\nrange_m = [500.0, 900.0]\n"
    "[noise]\npixel_px = 1.0\n[outliers]\ncount = 1\nlaw = 'uniform'\nsize_px = [15.0, 30.0]\n";

// The estimates of a numeric study on one target and on another.
struct Pair {
  Pose truth;
  EstimateRecord mesh, points;
};

std::vector<Pair> numeric_pairs(const std::string& target, const std::string& points) {
  const auto study_of = [](const std::string& name) {
    return read_study_text("target = '" + name + "'\n" + kNumeric, "numeric");
  };
  const Study mesh = study_of(target);
  const Study alone = study_of(points);
  std::vector<Pair> pairs;
  for (int i = 0; i < 20; ++i) {
    const TrialRecord a = run_numeric_trial(mesh, i);
    const TrialRecord b = run_numeric_trial(alone, i);
    for (size_t s = 0; s < a.estimates().size(); ++s) {
      pairs.push_back({a.true_cam_from_target, a.estimates()[s], b.estimates()[s]});
    }
  }
  return pairs;
}

// The cube's mesh has its corners for vertices, each as often as the others, and these are its
// features: all errors are the same, those over vertices up to rounding.
TEST_F(KeypointTarget, GivesInNumericStudiesWhatItsMeshGives) {
  constexpr double kRounding = 1e-6;  // the mesh's file has single precision
  int solved = 0;
  for (const Pair& pair : numeric_pairs("cube", write("cube.toml", keypoints_of("cube")))) {
    ASSERT_EQ(pair.mesh.status, pair.points.status);
    if (pair.mesh.status != EstimateOutcome::kOk) continue;
    ++solved;
    EXPECT_EQ(pair.mesh.geodesic_deg, pair.points.geodesic_deg);
    EXPECT_GT(pair.points.add_m, 0);
    EXPECT_NEAR(pair.mesh.add_m, pair.points.add_m, kRounding * pair.mesh.add_m);
    EXPECT_NEAR(pair.mesh.mssd_m, pair.points.mssd_m, kRounding * pair.mesh.mssd_m);
    EXPECT_NEAR(pair.mesh.mspd_px, pair.points.mspd_px, kRounding * pair.mesh.mspd_px);
  }
  EXPECT_GT(solved, 30);
}

// Of the airliner they are over seventeen points instead of its skin.
TEST_F(KeypointTarget, HasItsErrorsOverItsKeypoints) {
  constexpr double kRounding = 1e-9;
  const auto airliner = load_target("boeing707");
  const std::string points = write("boeing.toml", keypoints_of("boeing707"));
  int solved = 0;
  for (const Pair& pair : numeric_pairs("boeing707", points)) {
    ASSERT_EQ(pair.mesh.status, pair.points.status);
    if (pair.mesh.status != EstimateOutcome::kOk) continue;
    ++solved;
    EXPECT_EQ(pair.mesh.geodesic_deg, pair.points.geodesic_deg);
    double sum = 0, greatest = 0;
    for (const TargetFeature& feature : airliner->features) {
      const Eigen::Vector3d& x = feature.position_m;
      const double distance = (pair.points.cam_from_target * x - pair.truth * x).norm();
      sum += distance / static_cast<double>(airliner->features.size());
      greatest = std::max(greatest, distance);
    }
    EXPECT_NEAR(pair.points.add_m, sum, kRounding * sum);
    EXPECT_NEAR(pair.points.mssd_m, greatest, kRounding * greatest);
    EXPECT_GT(std::abs(pair.mesh.add_m - sum), 100 * kRounding * sum);
  }
  EXPECT_GT(solved, 30);
}

TEST_F(KeypointTarget, IsRefusedWhereItWouldBeRendered) {
  const std::string points = write("points.toml", keypoints_of("cube"));
  fs::create_directory(path("points"));
  const std::string target = write("points/target.toml", keypoints_of("cube"));
  const std::string why = "'points of the cube' has keypoints alone and no mesh";
  expect_refused("render " + target + " --count 1 --out " + path("out"), why);
  const std::string scene = write(
      "scene.toml", "target = '" + target +
                        "'\n[camera]\nwidth_px = 64\nheight_px = 64\nf_px = 250.0\n"
                        "[poses]\nattitude = 'uniform'\nlateral_m = [0, 0]\nrange_m = [10, 20]\n");
  expect_refused("render " + scene + " --count 1 --out " + path("out"), why);
  expect_refused(
      "render cube --count 1 --set 'other=[{target=\"" + target + "\"}]' --out " + path("out"),
      why);
  expect_refused("study boeing-random --set 'target=\"" + points + "\"' --set features=all --out " +
                     path("out"),
                 why);
  expect_refused("target " + target, why);
  expect_refused("target " + target + " --propose " + path("out"), why);
  // The same commands do their work on a target with a mesh.
  EXPECT_EQ(run("target cube").exit_code, 0);
  EXPECT_EQ(run("render cube --count 1 --quiet --out " + path("out")).exit_code, 0);
}

TEST_F(KeypointTarget, IsEvaluatedOnASetWithNothingPredictedHidden) {
  const std::string set = cube_set();
  const auto study_of = [&](const std::string& target) {
    return read_study_text("target = '" + target + "'\nsolvers = ['orpe', 'lspe']\n[dataset]\n" +
                               "path = '" + set + "'\n",
                           "evaluate");
  };
  const Study mesh = study_of("cube");
  const Study points = study_of(write("points.toml", keypoints_of("cube")));
  Renderer renderer;
  int hidden_by_mesh = 0, hidden = 0, found = 0, clutter = 0, solved = 0;
  for (int i = 0; i < 6; ++i) {
    const TrialRecord of_mesh = run_trial(mesh, i, renderer).record;
    for (const ObservationRecord& observation : of_mesh.observations()) {
      hidden_by_mesh += observation.status == ObservationOutcome::kHidden ? 1 : 0;
    }
    const TrialRecord record = run_trial(points, i, renderer).record;
    for (const ObservationRecord& observation : record.observations()) {
      EXPECT_TRUE(observation.is_visible);
      hidden += observation.status == ObservationOutcome::kHidden ? 1 : 0;
      found += observation.is_found() ? 1 : 0;
      clutter += observation.label == ObservationLabel::kClutter ? 1 : 0;
    }
    for (const EstimateRecord& estimate : record.estimates()) {
      if (estimate.status != EstimateOutcome::kOk) continue;
      ++solved;
      EXPECT_GT(estimate.add_m, 0);
    }
  }
  EXPECT_GT(hidden_by_mesh, 5);  // a corner or more an image
  EXPECT_EQ(hidden, 0);
  EXPECT_GT(found, 20);
  EXPECT_EQ(clutter, 0);
  EXPECT_GT(solved, 6);
}

TEST_F(KeypointTarget, IsEvaluatedAsAnyRunIs) {
  const std::string set = cube_set();
  const std::string points = write("points.toml", keypoints_of("cube"));
  const auto evaluate = [&](const std::string& out, const std::string& more) {
    const Outcome outcome = run("evaluate " + set + " --target " + points +
                                " --solvers orpe,lspe --quiet --out " + path(out) + " " + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return read_whole(path(out + "/results.csv"));
  };
  const std::string all = evaluate("all", "--jobs 1");
  EXPECT_EQ(lines_of(all), 1u + 2 * 6);
  EXPECT_EQ(evaluate("jobs", "--jobs 2"), all);
  EXPECT_THAT(all, StartsWith(evaluate("two", "--trials 2")));
  EXPECT_THAT(read_whole(path("all/report.html")), HasSubstr("How well do these solvers do"));
}

TEST_F(KeypointTarget, LiesWithinTheModelOfTheSet) {
  const std::string set = cube_set();
  const auto problem_with = [&](double factor) {
    const std::string points = write("points.toml", keypoints_of("cube", factor));
    return error_of([&] {
      read_study_text(
          "target = '" + points + "'\nsolvers = ['orpe']\n[dataset]\npath = '" + set + "'\n",
          "evaluate");
    });
  };
  EXPECT_EQ(problem_with(1), "");
  EXPECT_EQ(problem_with(0.6), "");  // keypoints may lie anywhere in it
  EXPECT_THAT(problem_with(1.2), AllOf(HasSubstr("models_info.json: object 1 fills"),
                                       HasSubstr("must lie within it")));
  // Of a set without models nobody can say so.
  fs::remove_all(set + "/models");
  fs::remove_all(set + "/models_eval");
  EXPECT_EQ(problem_with(1.2), "");
}

TEST_F(KeypointTarget, IsRefusedToWhatLooksForItsMesh) {
  const std::string set = cube_set();
  const std::string points = write("points.toml", keypoints_of("cube"));
  const std::string evaluate =
      "evaluate " + set + " --target " + points + " --solvers orpe --quiet --out " + path("out");
  const std::string alone = "'points of the cube' has keypoints alone";
  expect_refused(evaluate + " --extractor model_edges", alone);
  expect_refused(evaluate + " --extractor edges_else_contour", alone);
  expect_refused(evaluate + " --axes file", alone);
  EXPECT_EQ(run(evaluate + " --extractor hough_subpixel --trials 1").exit_code, 0);
}

}  // namespace
}  // namespace sightline
