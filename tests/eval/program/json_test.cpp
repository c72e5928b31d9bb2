// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// --json: what a command says in tables, for programs.
#include "eval/output/json.h"

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;

class ProgramJson : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  // Of standard output alone, as a pipe takes it.
  static Json printed(const std::string& arguments, int exit_code = 0) {
    const Outcome outcome = run(arguments + " --json 2>/dev/null");
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.output;
    return Json::parse(outcome.output, nullptr, /*allow_exceptions=*/false);
  }

 private:
  TemporaryFolder folder_;
};

constexpr const char* kSmallStudy = "study cube-noise --set 'sweep={noise_px=[1.0]}' --trials ";

TEST_F(ProgramJson, OfAStudyIsItsSummary) {
  const Json told = printed(fmt::format("{} 2 --out {}", kSmallStudy, path("run")));
  EXPECT_EQ(told, read_json(path("run/summary.json")));
  EXPECT_EQ(told["cells"][0]["trials"], 2);
}

TEST_F(ProgramJson, OfAPlanHasTheTrialsThatItsTableShows) {
  const std::string command = fmt::format("{} 20 --plan 0.05 --quiet", kSmallStudy);
  const Json told = printed(command);
  const std::string table = run(command).output;
  EXPECT_EQ(told["relative_half_width"], 0.05);
  EXPECT_THAT(table, HasSubstr(fmt::format("--trials {}", told["trials"].get<int64_t>())));
  ASSERT_GT(told["cells"].size(), 1u);
  for (const Json& cell : told["cells"]) {
    EXPECT_LE(cell["trials"], told["trials"]);
    EXPECT_THAT(table, HasSubstr(fmt::to_string(cell["trials"].get<int64_t>())));
  }
}

TEST_F(ProgramJson, OfADryRunIsWhatASetWillTake) {
  const Json told = printed("render cube --count 1000 --dry-run --jobs 2 --out " + path("set"));
  EXPECT_EQ(told["images"], 1000);
  EXPECT_EQ(told["files"], 1000 * told["image"]["files"].get<double>());
  EXPECT_GT(told["disk_bytes"], told["bytes"]);
  EXPECT_DOUBLE_EQ(
      told["seconds"].get<double>(),
      (told["image"]["render_ms"].get<double>() + told["image"]["encode_ms"].get<double>()) / 2);
  EXPECT_FALSE(std::filesystem::exists(path("set")));
}

TEST_F(ProgramJson, OfAComparisonHasEveryNumber) {
  ASSERT_EQ(run(fmt::format("{} 5 --quiet --out {}", kSmallStudy, path("base"))).exit_code, 0);
  ASSERT_EQ(run(fmt::format("{} 5 --quiet --set noise.scale=9 --out {}", kSmallStudy, path("now")))
                .exit_code,
            0);
  const std::string both = fmt::format("compare {} {}", path("base"), path("now"));
  const Json told = printed(both + " --measure geodesic_deg.mean");
  EXPECT_EQ(told["study"], "cube-noise");
  EXPECT_FALSE(told["has_regression"]);
  const Json base = read_json(path("base/summary.json"));
  ASSERT_EQ(told["cells"].size(), base["cells"].size());
  for (size_t i = 0; i < told["cells"].size(); ++i) {
    const Json& difference = told["cells"][i]["differences"][0];
    EXPECT_EQ(told["cells"][i]["solver"], base["cells"][i]["solver"]);
    EXPECT_EQ(difference["measure"], "geodesic_deg.mean");
    EXPECT_DOUBLE_EQ(difference["base"], base["cells"][i]["geodesic_deg"]["mean"]);
    EXPECT_GT(difference["new"], difference["base"]);
  }
}

TEST_F(ProgramJson, OfACoverageHasTheTablesFigures) {
  const std::string command =
      "coverage cube-noise --quiet --trials 3 --repeats 3 --set 'sweep={noise_px=[1.0]}'";
  const Json told = printed(command);
  const std::string table = run(command).output;
  EXPECT_EQ(told["repeats"], 3);
  int shown = 0;
  for (const Json& number : told["numbers"]) {
    if (number["cells"] == 0) {
      EXPECT_TRUE(number["mean"].is_null());
      continue;
    }
    EXPECT_THAT(table, HasSubstr(fmt::format(
                           "| {} | {} | {:.1f} % |", number["number"].get<std::string>(),
                           number["cells"].get<int>(), 100 * number["mean"].get<double>())));
    ++shown;
  }
  EXPECT_GT(shown, 3);
}

TEST_F(ProgramJson, OfABoundHasARowForEachValueOfAKey) {
  const std::string command =
      "bound boeing-random --scenes 1 --over 'poses.range_m=[1000,1000],[2000,2000]'";
  const Json told = printed(command);
  ASSERT_EQ(told["conditions"].size(), 2u);
  const std::string table = run(command).output;
  for (const Json& condition : told["conditions"]) {
    const double theta_deg = condition["unknown_light"]["theta_error_deg"];
    EXPECT_THAT(table, HasSubstr(condition["condition"].get<std::string>()));
    EXPECT_THAT(table, HasSubstr(fmt::format("{:.5f}", theta_deg)));
  }
}

TEST_F(ProgramJson, OfABoundHasARowForEachWord) {
  const Json told =
      printed("bound boeing-random --scenes 1 --over 'background.kind=uniform, stars'");
  ASSERT_EQ(told["conditions"].size(), 2u);
  EXPECT_THAT(told["conditions"][1]["condition"].get<std::string>(), HasSubstr("stars"));
  EXPECT_THAT(run("bound boeing-random --over 'poses.range_m=[1,2],[3 4]'").output,
              HasSubstr("--over poses.range_m=[1,2],[3 4]: [3 4] is no value"));
}

TEST_F(ProgramJson, OfListsHasTheirNames) {
  const Json all = printed("list");
  EXPECT_EQ(all.size(), 5u);
  EXPECT_EQ(all["targets"], printed("list targets")["targets"]);
  EXPECT_EQ(all["targets"][0]["name"], "boeing707");
  const Json keys = printed("list keys noise");
  EXPECT_EQ(keys["tables"].size(), 1u);
  EXPECT_EQ(keys["tables"][0]["table"], "noise");
  EXPECT_EQ(run("list columns --json").exit_code, 1);
}

TEST_F(ProgramJson, OfATargetHasItsMeshAndFeatures) {
  const Json told = printed("target cube");
  EXPECT_EQ(told["triangles"], 12);
  EXPECT_EQ(told["size_m"], Json::array({1.0, 1.0, 1.0}));
  EXPECT_EQ(told["features"].size(), 8u);
  EXPECT_EQ(told["features"][0]["kind"], "line_intersection");
  EXPECT_EQ(run("target cube --json --propose " + path("cube")).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(path("cube")));
}

TEST_F(ProgramJson, OfTheDoctorSaysWhatTheProgramStandsOn) {
  const Json told = printed("doctor");
  EXPECT_THAT(told["folders"]["assets"].get<std::string>(), HasSubstr("targets"));
  EXPECT_TRUE(told["libraries"].contains("OpenCV"));
  EXPECT_EQ(told["programs"]["gnuplot"], "found");
  // Without any program in PATH it says what is lost.
  const Json alone = Json::parse(
      run_shell(fmt::format("PATH=/nowhere '{}' doctor --json", SIGHTLINE_PROGRAM)).output);
  EXPECT_THAT(alone["programs"]["gnuplot"].get<std::string>(), HasSubstr("no figures/"));
  const Json licences = printed("doctor --licences");
  EXPECT_GT(licences["libraries"].size(), 20u);
  EXPECT_EQ(licences["libraries"][0]["name"], "Assimp");
}

TEST_F(ProgramJson, OfASetAndItsScoresIsTheirSummary) {
  const Json set = printed("render cube --count 2 --out " + path("set"));
  EXPECT_EQ(set["images"], 2);
  EXPECT_TRUE(set["is_complete"]);
  EXPECT_TRUE(printed("render --verify " + path("set"))["problems"].empty());
  ASSERT_EQ(run(fmt::format("evaluate {0} --target cube --solvers lspe --quiet --out {1} && "
                            "{2} export {1} --solver lspe --format bop --out {3}",
                            path("set"), path("run"), SIGHTLINE_PROGRAM, path("lspe.csv")))
                .exit_code,
            0);
  const std::string score =
      fmt::format("score {} --dataset {} --out ", path("lspe.csv"), path("set"));
  Json scores = printed(score + path("scores") + " --require 'add_recall<=1'");
  EXPECT_TRUE(scores["requirements"][0]["is_met"]);
  scores.erase("requirements");
  EXPECT_EQ(scores, read_json(path("scores/scores.json")));
  EXPECT_FALSE(printed(score + path("again") + " --require 'add_recall>=2'",
                       3)["requirements"][0]["is_met"]);
  std::filesystem::remove(path("set/test/000000/gray/000001.png"));
  EXPECT_EQ(printed("render --verify " + path("set"), 1)["missing"], 1);
}

}  // namespace
}  // namespace sightline
