// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Files of estimates that are made by hand, about sightings whose poses are known.
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/doors/estimate_file.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kBop = "scene_id,im_id,obj_id,score,R,t,time";
constexpr const char* kUnturned = "1 0 0 0 1 0 0 0 1";

// A set of the object 4, whose model's axes are not the target's: picture 3 shows it once, picture
// 7 twice.
class Estimates : public testing::Test {
 protected:
  Estimates() {
    set_.obj_id = 4;
    set_.target_from_model << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    for (const auto& [im_id, gt_id, x_m] :
         {std::tuple(3, 0, 0.0), std::tuple(7, 0, -2.0), std::tuple(7, 2, 2.0)}) {
      Sighting& sighting = set_.sightings.emplace_back();
      sighting.picture = fmt::format("set/images/img{}.png", im_id);
      sighting.scene_id = 5;
      sighting.im_id = im_id;
      sighting.gt_id = gt_id;
      sighting.cam_from_target.translation = {x_m, 0, 10};
    }
  }
  TrialSolver solver_of(const std::string& text, bool has_set = true,
                        const std::string& name = "mine") const {
    return recorded_solver({name, folder_.write("e.csv", text), EstimateFormat::kByHeader},
                           has_set ? &set_ : nullptr);
  }
  static SolverAnswer ask(const TrialSolver& solver, const TrialName& trial) {
    const PoseProblem problem;
    const SolverOptions options;
    const std::vector<std::string> features = {"nose", "tail", "fin"};
    return solver.solve({problem, options, features, trial});
  }
  std::string complaint(const std::string& text, bool has_set = true) const {
    return error_of([&] { solver_of(text, has_set); });
  }

  TemporaryFolder folder_;
  SightedSet set_;
};

TEST_F(Estimates, OfBopAreOfTheSetsModelInMillimetres) {
  const TrialSolver solver =
      solver_of(fmt::format("{}\n5,3,4,1,{},100 200 9000,-1\n"
                            "5,3,9,1,{},1 2 3,-1\n",
                            kBop, kUnturned, kUnturned));
  EXPECT_TRUE(solver.is_recorded);
  const SolverAnswer answer = ask(solver, {.scene_id = 5, .im_id = 3});
  ASSERT_EQ(answer.outcome, EstimateOutcome::kOk);
  const Pose& pose = answer.estimate.cam_from_target;
  EXPECT_TRUE(pose.rotation.isApprox(set_.target_from_model.transpose(), 1e-12));
  EXPECT_TRUE(pose.translation.isApprox(Eigen::Vector3d(0.1, 0.2, 9), 1e-12));
  EXPECT_FALSE(answer.estimate.covariance);
  EXPECT_EQ(ask(solver, {.scene_id = 5, .im_id = 7}).outcome, EstimateOutcome::kNoEstimate);
}

TEST_F(Estimates, OfSeveralInstancesGoToTheNearestTheSurestFirst) {
  const TrialSolver solver =
      solver_of(fmt::format("{0}\n5,7,4,0.2,{1},2100 0 10000,-1\n"
                            "5,7,4,0.9,{1},1900 0 10000,-1\n",
                            kBop, kUnturned));
  const auto x_m = [&](int gt_id) {
    return ask(solver, {.scene_id = 5, .im_id = 7, .gt_id = gt_id})
        .estimate.cam_from_target.translation.x();
  };
  EXPECT_NEAR(x_m(2), 1.9, 1e-12) << "the surer one has the choice";
  EXPECT_NEAR(x_m(0), 2.1, 1e-12);
}

TEST_F(Estimates, OfBopMayHaveACovarianceAndWhatWasRemoved) {
  std::string upper;
  for (int i = 1; i <= 21; ++i) upper += fmt::format("{} ", i);
  const std::string head = std::string(kBop) + ",covariance,removed\n";
  const TrialSolver solver =
      solver_of(head + fmt::format("5,3,4,1,{},0 0 9000,-1,{},fin;nose\n", kUnturned, upper));
  const PoseEstimate estimate = ask(solver, {.scene_id = 5, .im_id = 3}).estimate;
  EXPECT_THAT(estimate.removed, ElementsAre(0, 2)) << "places among nose, tail, fin";
  ASSERT_TRUE(estimate.covariance);
  EXPECT_EQ((*estimate.covariance)(0, 5), 6);
  EXPECT_EQ((*estimate.covariance)(5, 0), 6);
  EXPECT_EQ((*estimate.covariance)(1, 1), 7);
  EXPECT_EQ((*estimate.covariance)(5, 5), 21);
  EXPECT_THAT(complaint(head + fmt::format("5,3,4,1,{},0 0 9,-1,1 2 3,\n", kUnturned)),
              HasSubstr("line 2 has 3 numbers for covariance, must have 21"));
}

TEST_F(Estimates, OfEsaNamePicturesAndAreInMetres) {
  const double half = std::sqrt(0.5);
  const TrialSolver solver =
      solver_of(fmt::format("img3.png,{0},0,0,{0},0.5,0.25,9\n", half));  // a quarter turn about z
  const Pose pose = ask(solver, {.scene_id = 5, .im_id = 3}).estimate.cam_from_target;
  Eigen::Matrix3d quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_TRUE(pose.rotation.isApprox(quarter * set_.target_from_model.transpose(), 1e-9));
  EXPECT_EQ(pose.translation, Eigen::Vector3d(0.5, 0.25, 9));
  EXPECT_EQ(ask(solver, {.scene_id = 5, .im_id = 7}).outcome, EstimateOutcome::kNoEstimate);

  EXPECT_THAT(complaint("img3.png,1,0,0,0,0,0,9\nimg3.png,1,0,0,0,0,0,9\n"),
              HasSubstr("line 2 names a picture that was named before"));
  EXPECT_THAT(complaint("img3.png,1,0,0,0,0,0,9\nimages/img3.png,1,0,0,0,0,0,9\n"),
              HasSubstr("two estimates of one picture, as img3.png and as images/img3.png"));
  EXPECT_THAT(complaint("lightbox/img3.png,1,0,0,0,0,0,9\n"),
              HasSubstr("line 1 is about 'lightbox/img3.png'"));
  EXPECT_THAT(complaint("img9.png,1,0,0,0,0,0,9\n"), HasSubstr("line 1 is about 'img9.png'"));
  EXPECT_EQ(ask(solver_of("img3.png,2,0,0,0,0,0,9\n"), {.scene_id = 5, .im_id = 3}).outcome,
            EstimateOutcome::kNotRigid);
  EXPECT_THAT(complaint("img3.png,1,0,0,0,0,0,9\n", false), HasSubstr("only a data set has"));
}

TEST_F(Estimates, OfARunGoByTheTrialsNumber) {
  const std::string head = "trial,solver,status,removed,qw,qx,qy,qz,tx_m,ty_m,tz_m\n";
  const std::string rows =
      head + "0,lspe,ok,,1,0,0,0,0,0,5\n1,lspe,degenerate,,,,,,,,\n0,orpe,ok,tail,1,0,0,0,0,0,6\n";
  const TrialSolver orpe = solver_of(rows, false, "orpe");
  EXPECT_EQ(ask(orpe, {.trial = 0}).estimate.cam_from_target.translation.z(), 6);
  EXPECT_THAT(ask(orpe, {.trial = 0}).estimate.removed, ElementsAre(1));
  EXPECT_EQ(ask(orpe, {.trial = 1}).outcome, EstimateOutcome::kNoEstimate);
  EXPECT_EQ(ask(solver_of(rows, false, "lspe"), {.trial = 1}).outcome,
            EstimateOutcome::kDegenerate);
  EXPECT_THAT(complaint(rows, false), HasSubstr("the name must say which are meant"));
  EXPECT_THAT(complaint(head + "0,a,fine,,1,0,0,0,0,0,5\n", false),
              HasSubstr("line 2 has a status that 'fine' is none of ok"));
  EXPECT_THAT(complaint(head + "0,a,ok,,1,0,0,0,0,0,5\n0,a,ok,,1,0,0,0,0,0,5\n", false),
              HasSubstr("line 3 has trial 0 of a a second time"));
}

TEST_F(Estimates, OfNoKnownKindAreRefused) {
  EXPECT_THAT(complaint("a,b,c\n1,2,3\n"), HasSubstr("line 1 begins no file of estimates"));
  EXPECT_THAT(complaint(fmt::format("{}\n6,3,4,1,{},0 0 9,-1\n", kBop, kUnturned)),
              HasSubstr("has no pose of the target in a picture of the study"));
}

// Two rows of one picture with one target: the better score counts, though it is no pose.
TEST_F(Estimates, ThatAreNoPosesAreFailuresOfTheirOwnTrials) {
  const TrialName trial{.scene_id = 5, .im_id = 3};
  const std::string good = fmt::format("5,3,4,1,{},0 0 9,-1\n", kUnturned);
  const auto outcome = [&](const std::string& rows) {
    return ask(solver_of(fmt::format("{}\n{}", kBop, rows)), trial).outcome;
  };
  const std::string bad = "5,3,4,2,1 0 0 0 1 0 0 0 2,0 0 9,-1\n";
  EXPECT_EQ(outcome(good), EstimateOutcome::kOk);
  EXPECT_EQ(outcome(bad), EstimateOutcome::kNotRigid);
  EXPECT_EQ(outcome(good + bad), EstimateOutcome::kNotRigid);
  EXPECT_EQ(outcome(good + fmt::format("5,3,4,nan,{},0 0 9,-1\n", kUnturned)),
            EstimateOutcome::kOk);
  EXPECT_EQ(ask(solver_of(good), trial).outcome, EstimateOutcome::kOk) << "without a header";
}

}  // namespace
}  // namespace sightline
