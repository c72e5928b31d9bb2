// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs whose features or poses come from files, through the program as a user runs it.
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/output/csv_reader.h"
#include "eval/output/json.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// The rows of a CSV file by their columns.
using Rows = std::vector<std::map<std::string, std::string>>;

Rows rows_of(const fs::path& file) {
  Rows rows;
  for (CsvReader csv(file); csv.next();) {
    auto& row = rows.emplace_back();
    for (const std::string& column : csv.columns()) row[column] = csv.text(column);
  }
  return rows;
}

std::set<std::string> values_of(const Rows& rows, const std::string& column) {
  std::set<std::string> values;
  for (const auto& row : rows) values.insert(row.at(column));
  return values;
}

// A set of six pictures of the cube as the program renders it.
class Doors : public testing::Test {
 protected:
  static constexpr int kPictures = 6;

  Doors() {
    const Outcome rendered = run(
        fmt::format("render cube --count {} --seed 5 --quiet --out {}", kPictures, path("set")));
    EXPECT_EQ(rendered.exit_code, 0) << rendered.output;
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  Outcome evaluate(const std::string& out, const std::string& more) const {
    return run(
        fmt::format("evaluate {} --target cube --quiet --out {} {}", path("set"), path(out), more));
  }
  Rows results(const std::string& out) const { return rows_of(path(out) + "/results.csv"); }

  // The observations that the program's own extractor makes, as a file of somebody else's would
  // have them, each moved by so many pixels.
  std::string observations_file(const std::string& run, const std::string& name,
                                double shift_px = 0) const {
    const Outcome read = run_shell(fmt::format(
        "python3 -c \"import sqlite3; [print(*row, sep=',') for row in sqlite3.connect('{}/"
        "results.sqlite').execute('select trial, feature, pixel_u, pixel_v from observations "
        "where status = \\\"found\\\"')]\"",
        path(run)));
    EXPECT_EQ(read.exit_code, 0) << read.output;
    std::string text = "scene_id,im_id,feature,u,v,sigma\n";
    std::istringstream lines(read.output);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream fields(line);
      std::string trial, feature, u, v;
      std::getline(fields, trial, ',');
      std::getline(fields, feature, ',');
      std::getline(fields, u, ',');
      std::getline(fields, v, ',');
      text += fmt::format("0,{},{},{},{},0.3\n", trial, feature, std::stod(u) + shift_px,
                          std::stod(v) + shift_px);
    }
    return folder_.write(name, text).string();
  }

  TemporaryFolder folder_;
};

TEST_F(Doors, ObservationsOfAFileAreAnExtractorBesideOurs) {
  ASSERT_EQ(evaluate("own", "--solvers lspe,oracle --jobs 1").exit_code, 0);
  const std::string same = observations_file("own", "same.csv");
  const std::string moved = observations_file("own", "moved.csv", 0.5);
  const Outcome outcome =
      evaluate("three", "--solvers lspe,oracle --extractor by_kind --observations same=" + same +
                            " --observations moved=" + moved + " --jobs 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const Rows rows = results("three");
  EXPECT_EQ(values_of(rows, "extractor"), (std::set<std::string>{"by_kind", "same", "moved"}));
  ASSERT_EQ(rows.size(), 3u * 2 * kPictures);
  // lspe does not weigh, so that the same pixels make the same pose.
  std::map<std::string, std::map<std::string, double>> tx;
  for (const auto& row : rows) {
    if (row.at("solver") == "lspe" && row.at("status") == "ok") {
      tx[row.at("im_id")][row.at("extractor")] = std::stod(row.at("tx_m"));
    }
  }
  ASSERT_GT(tx.size(), 2u);
  constexpr double kPrintedDigits = 1e-6;  // m, of an iteration that begins elsewhere
  for (const auto& [image, by_extractor] : tx) {
    ASSERT_EQ(by_extractor.size(), 3u) << image;
    EXPECT_NEAR(by_extractor.at("same"), by_extractor.at("by_kind"), kPrintedDigits);
    EXPECT_GT(std::abs(by_extractor.at("moved") - by_extractor.at("by_kind")), kPrintedDigits)
        << "half a pixel is to be seen";
  }
  const std::string page = read_whole(path("three") + "/report.html");
  EXPECT_THAT(page, AllOf(HasSubstr("same.csv"), HasSubstr("LSPE with by_kind"),
                          HasSubstr("LSPE with moved")));
}

TEST_F(Doors, EstimatesOfAFileAreASolverBesideOurs) {
  ASSERT_EQ(evaluate("own", "--solvers orpe,lspe").exit_code, 0);
  const Outcome outcome =
      evaluate("both", "--solvers orpe,lspe --estimates mine=" + path("own") +
                           "/results.csv --estimates lspe2=" + path("own") + "/results.csv");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, AllOf(HasSubstr("has estimates of lspe, orpe"),
                                    HasSubstr("the name must say which are meant")));

  ASSERT_EQ(evaluate("one", "--solvers lspe").exit_code, 0);
  const Outcome good =
      evaluate("again", "--solvers lspe --estimates mine=" + path("one") + "/results.csv");
  ASSERT_EQ(good.exit_code, 0) << good.output;
  std::map<std::string, std::map<std::string, std::string>> theta;
  for (const auto& row : results("again")) {
    theta[row.at("trial")][row.at("solver")] = row.at("theta_error_deg").substr(0, 8);
  }
  ASSERT_EQ(theta.size(), static_cast<size_t>(kPictures));
  for (const auto& [trial, by_solver] : theta)
    EXPECT_EQ(by_solver.at("mine"), by_solver.at("lspe"));
}

TEST_F(Doors, GuestsInShardsMergeToOneRun) {
  ASSERT_EQ(evaluate("own", "--solvers lspe").exit_code, 0);
  const std::string guests =
      "--solvers lspe,oracle --observations net=" + observations_file("own", "net.csv", 0.2) +
      " --estimates mine=" + path("own") + "/results.csv ";
  ASSERT_EQ(evaluate("whole", guests).exit_code, 0);
  for (const std::string shard : {"0", "1"}) {
    const Outcome part = evaluate("part-" + shard, guests + "--shard " + shard + "/2");
    ASSERT_EQ(part.exit_code, 0) << part.output;
  }
  const std::string merge =
      "merge " + path("part-0") + " " + path("part-1") + " --out " + path("merged");
  const Outcome merged = run(merge);
  ASSERT_EQ(merged.exit_code, 0) << merged.output;
  EXPECT_EQ(read_whole(path("merged") + "/results.csv"),
            read_whole(path("whole") + "/results.csv"));
  EXPECT_EQ(read_whole(path("merged") + "/summary.json"),
            read_whole(path("whole") + "/summary.json"));
}

TEST_F(Doors, MissingEstimatesAreFailedTrials) {
  const std::string head = "scene_id,im_id,obj_id,score,R,t,time\n";
  const std::string row = "0,1,1,1,1 0 0 0 1 0 0 0 1,0 0 10000,-1\n";
  folder_.write("one.csv", head + row);
  const Outcome outcome = evaluate("run", "--solvers lspe --estimates mine=" + path("one.csv"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  int missing = 0;
  for (const auto& r : results("run")) {
    if (r.at("solver") != "mine") continue;
    if (r.at("im_id") == "1") {
      EXPECT_EQ(r.at("status"), "ok");
      EXPECT_EQ(r.at("tz_m"), "10");
    } else {
      EXPECT_EQ(r.at("status"), "no estimate");
      ++missing;
    }
  }
  EXPECT_EQ(missing, kPictures - 1);

  folder_.write("bad.csv", head + "0,1,1,1,1 0 0 0 1 0 0 0 2,0 0 10000,-1\n");
  const Outcome bad = evaluate("bad", "--solvers lspe --estimates mine=" + path("bad.csv"));
  ASSERT_EQ(bad.exit_code, 0) << bad.output;
  for (const auto& r : results("bad")) {
    if (r.at("solver") != "mine") continue;
    EXPECT_EQ(r.at("status"), r.at("im_id") == "1" ? "not rigid" : "no estimate");
  }
}

TEST_F(Doors, WhatARunFoundGoesOutAndComesInAgain) {
  ASSERT_EQ(evaluate("own", "--solvers lspe,orpe").exit_code, 0);
  const std::string out = "export " + path("own") + " --out ";
  ASSERT_EQ(run(out + path("lspe.csv") + " --solver lspe").exit_code, 0);
  ASSERT_EQ(run(out + path("found.json") + " --format coco").exit_code, 0);
  const Outcome again =
      evaluate("again", "--solvers lspe --estimates exported=" + path("lspe.csv") +
                            " --observations found=" + path("found.json"));
  ASSERT_EQ(again.exit_code, 0) << again.output;
  std::map<std::string, std::map<std::string, double>> theta_deg;
  for (const auto& row : results("again")) {
    if (row.at("status") == "ok") {
      theta_deg[row.at("trial")][row.at("solver")] = std::stod(row.at("theta_error_deg"));
    }
  }
  ASSERT_FALSE(theta_deg.empty());
  // Of poses that are written in millimetres, and of an iteration that begins at another prior.
  constexpr double kRoundingDeg = 1e-6;
  for (const auto& [trial, by_solver] : theta_deg) {
    EXPECT_NEAR(by_solver.at("exported"), by_solver.at("lspe"), kRoundingDeg) << trial;
  }
  EXPECT_THAT(run(out + path("x.csv")).output, HasSubstr("--solver must be one of lspe, orpe"));
  EXPECT_THAT(run(out + path("x.csv") + " --solver lsep").output, HasSubstr("did you mean 'lspe'"));
  EXPECT_THAT(run(out + path("x.csv") + " --solver lspe --condition some").output,
              HasSubstr("--condition must be one of all"));
  EXPECT_FALSE(fs::exists(path("x.csv")));
}

// COCO's results know an image by one number, which each scene begins anew.
TEST_F(Doors, KeypointsOfSeveralScenesGoOutSceneByScene) {
  const fs::path scenes = path("set") + "/test";
  fs::copy(scenes / "000000", scenes / "000007", fs::copy_options::recursive);
  fs::remove(path("set") + "/test_targets_bop19.json");
  ASSERT_EQ(evaluate("two", "--solvers lspe").exit_code, 0);
  const std::string out = "export " + path("two") + " --format coco";
  EXPECT_THAT(run(out).output, HasSubstr("of several scenes (0, 7, ...)"));
  EXPECT_THAT(run(out + " --scene 3").output, HasSubstr("--scene 3: is of no trial"));
  const Outcome first = run(out + " --scene 0");
  const Outcome second = run(out + " --scene 7");
  EXPECT_EQ(second.exit_code, 0);
  EXPECT_EQ(Json::parse(second.output).size(), static_cast<size_t>(kPictures));
  EXPECT_EQ(Json::parse(first.output)[0]["image_id"], Json::parse(second.output)[0]["image_id"]);
  EXPECT_EQ(lines_of(run("export " + path("two") + " --scene 7").output), 1u + kPictures);
}

TEST_F(Doors, GuestsNeedNamesOfTheirOwn) {
  folder_.write("a.csv", "scene_id,im_id,feature,u,v\n0,0,vertex_0,1,2\n");
  EXPECT_THAT(evaluate("a", "--observations model_edges=" + path("a.csv")).output,
              HasSubstr("is another's name already"));
  EXPECT_THAT(evaluate("a", "--observations " + path("a.csv")).output,
              HasSubstr("must be NAME=FILE"));
  EXPECT_THAT(evaluate("a", "--extractor modle_edges").output,
              AllOf(HasSubstr("extractors"), HasSubstr("did you mean 'model_edges'")));
  EXPECT_THAT(evaluate("a", "--observations net=" + path("absent.csv")).output,
              AllOf(HasSubstr("absent.csv"), HasSubstr("cannot be read")));
  EXPECT_FALSE(fs::exists(path("a")));
}

TEST_F(Doors, AStudyThatRendersTakesFilesAboutItsOwnPictures) {
  const std::string study =
      "study boeing-random --trials 3 --seed 4 --quiet --set \"solvers=['lspe']\" ";
  ASSERT_EQ(run(study + "--out " + path("own")).exit_code, 0);
  const std::string net = observations_file("own", "net.csv");
  const Outcome outcome = run(study + "--observations net=" + net + " --out " + path("net"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  ASSERT_EQ(results("net").size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(results("net")[i].at("found"), results("own")[i].at("found"));
  }
  const Outcome swept = run(study + "--observations net=" + net +
                            " --set 'sweep={\"noise.scale\" = [1, 2]}' --out " + path("swept"));
  EXPECT_EQ(swept.exit_code, 1);
  EXPECT_THAT(swept.output, HasSubstr("cannot stand beside a sweep of noise.scale"));
}

}  // namespace
}  // namespace sightline
