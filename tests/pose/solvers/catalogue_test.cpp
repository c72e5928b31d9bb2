// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "pose/solver.h"

namespace sightline {
namespace {

TEST(Catalogue, EqualsTheFolder) {
  std::set<std::string> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/pose/solvers")) {
    if (entry.path().extension() == ".cpp") files.insert(entry.path().stem().string());
  }
#ifndef SIGHTLINE_POSE_OPENCV
  EXPECT_EQ(files.erase("opencv_ransac"), 1u);
#endif
  std::set<std::string> names;
  for (const PoseSolver& solver : pose_solvers()) names.insert(std::string(solver.name));
  EXPECT_EQ(names, files);
  EXPECT_EQ(names.size(), pose_solvers().size()) << "a name stands twice";
}

TEST(Catalogue, FindsByNameAndNothingElse) {
  for (const PoseSolver& solver : pose_solvers()) {
    EXPECT_EQ(find_pose_solver(solver.name), &solver);
    EXPECT_FALSE(solver.summary.empty());
  }
  EXPECT_EQ(find_pose_solver("LSPE"), nullptr);
  EXPECT_EQ(find_pose_solver(""), nullptr);
}

TEST(Catalogue, OnlyTheOracleNeedsTheTruth) {
  for (const PoseSolver& solver : pose_solvers()) {
    EXPECT_EQ(solver.evaluation_only, solver.name == "oracle");
  }
}

TEST(PoseStatus, NamesDiffer) {
  std::set<std::string_view> names;
  for (const PoseStatus status :
       {PoseStatus::kOk, PoseStatus::kTooFewPoints, PoseStatus::kTooManyPoints,
        PoseStatus::kDegenerate, PoseStatus::kBehindCamera, PoseStatus::kDiverged}) {
    names.insert(to_string(status));
  }
  EXPECT_EQ(names.size(), 6u);
}

}  // namespace
}  // namespace sightline
