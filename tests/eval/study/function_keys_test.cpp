// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Functions of whoever embeds this program, as a study's file names them.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TrialSolver solver_named(const std::string& name) {
  return {.name = name, .summary = "", .solve = [](const SolverQuestion&) {
            return SolverAnswer{EstimateOutcome::kRaisedError, {}};
          }};
}

Study read_with(Guests guests) {
  return read_study("cube-noise",
                    {.trials = 1,
                     .seed = {},
                     .set = {"solvers=['lspe', 'mine']", "functions.solvers=['mine']"},
                     .guests = std::move(guests)});
}

EstimateOutcome answer_of(const TrialSolver& solver) {
  return solver.solve({PoseProblem{}, SolverOptions{}, {}, TrialName{}}).outcome;
}

TEST(FunctionKeys, WhoIsGivenIsAsked) {
  Guests guests;
  guests.solvers = {solver_named("mine")};
  const Study study = read_with(guests);
  EXPECT_THAT(study.solver_names(), ElementsAre("lspe", "mine"));
  EXPECT_EQ(answer_of(*study.find_solver("mine")), EstimateOutcome::kRaisedError);
  EXPECT_THAT(study.toml, HasSubstr("functions"));
}

TEST(FunctionKeys, WhoIsNotHereIsNobody) {
  Guests guests;
  guests.solvers = {solver_named("another")};
  EXPECT_THAT(error_of([&] { read_with(guests); }),
              AllOf(HasSubstr("functions.solvers"), HasSubstr("\"mine\"")));
}

TEST(FunctionKeys, WhatAnAbsentOneGaveCanBeReadStill) {
  Guests guests;
  guests.may_be_absent = true;
  const Study study = read_with(guests);
  EXPECT_THAT(study.solver_names(), ElementsAre("lspe", "mine"));
  EXPECT_EQ(answer_of(*study.find_solver("mine")), EstimateOutcome::kNoEstimate);
}

}  // namespace
}  // namespace sightline
