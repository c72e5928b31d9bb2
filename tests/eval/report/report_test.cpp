// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/report.h"

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/means.h"
#include "tests/eval/report/small_report.h"

namespace sightline {
namespace {

using namespace small_report;
namespace fs = std::filesystem;
using ::testing::ElementsAre;

// What a page would load or leave for: none may point outside the page.
std::vector<std::string> outside_references(const std::string& page) {
  const std::regex reference(
      R"re((src|href|action|poster|data)\s*=\s*["']([^"']*)["']|url\(([^)]*)\)|@import)re");
  std::vector<std::string> outside;
  for (std::sregex_iterator i(page.begin(), page.end(), reference), end; i != end; ++i) {
    const std::string address = (*i)[2].str() + (*i)[3].str();
    const bool is_inside = address.starts_with("#") || address.starts_with("data:");
    if (!is_inside) outside.push_back(i->str());
  }
  return outside;
}

// Sets an environment variable for as long as it lives.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    ::setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() { old_ ? ::setenv(name_, old_->c_str(), 1) : ::unsetenv(name_); }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

TEST(Report, IsSelfContained) {
  const std::string page = SmallReport().page();
  EXPECT_THAT(outside_references(page), ElementsAre());
  EXPECT_FALSE(has(page, "http://"));
  EXPECT_FALSE(has(page, "https://"));
}

TEST(Report, TheSelfContainedCheckSeesWhatIsOutside) {
  EXPECT_EQ(outside_references(R"html(<script src="chart.js"></script>)html").size(), 1u);
  EXPECT_EQ(outside_references(R"html(<a href='//x.org'>x</a>)html").size(), 1u);
  EXPECT_EQ(outside_references(R"html(<p style="background: url(x.png)">)html").size(), 1u);
  EXPECT_THAT(outside_references(R"html(<a href="#table"></a><img src="data:x">)html"),
              ElementsAre());
}

// The same cells as of a study without images.
SmallReport small_sweep() {
  SmallReport report;
  NumericStudy numeric;
  static_cast<PoseStudy&>(numeric) = *report.study.images();
  numeric.setups[0].poses = report.study.images()->pose_law();
  numeric.setups[0].camera = report.study.images()->camera_of(0);
  numeric.cells.resize(report.study.conditions.size());
  report.study.kind = std::move(numeric);
  report.study.claim = "It is <small>.";
  report.frames.clear();
  return report;
}

// Its poses are drawn, so that there is a plane of angles.
SmallReport small_drawn_study() {
  SmallReport report;
  images_of(report.study).setups.front().scene.poses.theta_deg.clear();
  return report;
}

// It has the image's bound.
SmallReport small_study_with_ladder() {
  SmallReport report;
  report.summary.ladder = {
      {"image", "outline alone", 4, {1.32, {1.21, 1.43}}, {1.16, {1.02, 1.27}}}};
  return report;
}

TEST(Report, HasEveryFigureAndAWayToIt) {
  EXPECT_FALSE(has(SmallReport().page(), "<section id=\"ladder\""));
  const std::string page = small_study_with_ladder().page();
  EXPECT_TRUE(has(page, "<td>1.32</td>"));
  const std::string drawn = small_drawn_study().page();
  for (const ReportFigure& figure : report_figures()) {
    const std::string name(figure.name);
    const std::string& place = name == "angles" ? drawn : page;
    EXPECT_EQ(count(place, "<section id=\"" + name + "\""), 1u) << name;
    EXPECT_TRUE(has(place, "<li><a href=\"#" + name + "\">"));
  }
}

TEST(Report, OfAStudyWithoutImagesHasItsSweepAlone) {
  const std::string page = small_sweep().page();
  for (const char* name : {"table", "extraction", "silhouette", "frames"}) {
    EXPECT_FALSE(has(page, fmt::format("<section id=\"{}\"", name)));
  }
  EXPECT_TRUE(has(page, "<summary>All numbers</summary>"));
  EXPECT_FALSE(has(SmallReport().page(), "<summary>All numbers</summary>"));
  EXPECT_TRUE(has(page, "The paper: It is &lt;small&gt;."));
  EXPECT_TRUE(has(page, "<td>2.25 <span class=\"interval\">[1.95, 2.65]</span></td>"));
  EXPECT_TRUE(has(page, "at pose 2</span>")) << "the worst condition";
  EXPECT_FALSE(has(page, "farther than"));  // how image studies know an outlier
  EXPECT_FALSE(has(page, "{{"));
  EXPECT_THAT(outside_references(page), ElementsAre());
}

TEST(Report, OfAnOrientationStudyComparesMethodsWithTheFirst) {
  SmallReport report = small_sweep();
  OrientationStudy& orientation = report.study.kind.emplace<OrientationStudy>();
  orientation.cells.resize(report.study.conditions.size());
  orientation.pairs.timed_repeats = 10;
  const OrientationMethod other{"other_way", "", nullptr, nullptr};
  orientation.methods = {find_orientation_method("fast"), &other};
  report.summary.cells.clear();
  for (int condition = 0; condition < 2; ++condition) {
    for (const char* method : {"fast", "other_way"}) {
      CellSummary& cell = report.summary.cells.emplace_back();
      cell.condition = condition;
      cell.solver = method;
      cell.trials = 2;
      const bool is_fast = cell.solver == "fast";
      cell.angle_error_deg = error_summary(is_fast ? 1 : 1.25);
      cell.time_ns = error_summary(is_fast ? 100 : 200 + 100 * condition);
    }
  }
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "other way"));
  EXPECT_TRUE(has(page, "2.5e-01"));
  EXPECT_TRUE(has(page, "2.00 to 3.00"));
  EXPECT_TRUE(has(page, "timings.csv"));
  EXPECT_FALSE(has(page, "{{"));
}

TEST(Report, LeavesOutAFigureThatDoesNotApply) {
  SmallReport report;
  report.frames.clear();
  const std::string page = report.page();
  EXPECT_FALSE(has(page, "<section id=\"frames\""));
  EXPECT_FALSE(has(page, "href=\"#frames\""));
}

TEST(Report, EscapesWhatOthersNamed) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "tip &lt;b&gt;&amp;&quot;quoted&quot;"));
  EXPECT_FALSE(has(page, "tip <b>"));
  EXPECT_TRUE(has(page, "A small study of &lt;plates&gt;"));
  EXPECT_TRUE(has(page, "two &lt;cores&gt;"));
  EXPECT_FALSE(has(page, "<script>alert"));
}

TEST(Report, HasNoTemplateTagLeft) {
  EXPECT_FALSE(has(SmallReport().page(), "{{"));
}

TEST(Report, EveryFragmentHasItsAnchorOnce) {
  const std::string page = SmallReport().page();
  const std::regex fragment(R"re(href="#([^"]+)")re");
  for (std::sregex_iterator i(page.begin(), page.end(), fragment), end; i != end; ++i) {
    EXPECT_EQ(count(page, " id=\"" + (*i)[1].str() + "\""), 1u) << i->str();
  }
}

TEST(ReportCatalogue, EqualsTheFolder) {
  const std::set<std::string> helpers = {"chart",   "distributions", "evidence", "frame_svg",
                                         "gnuplot", "means",         "outline",  "page",
                                         "panels",  "report"};
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(SIGHTLINE_SOURCE_DIR "/eval/report")) {
    if (entry.path().extension() == ".cpp") files.insert(entry.path().stem());
  }
  for (const std::string& helper : helpers) EXPECT_EQ(files.erase(helper), 1u) << helper;
  std::set<std::string> names;
  for (const ReportFigure& figure : report_figures()) names.emplace(figure.name);
  EXPECT_EQ(names, files);
  EXPECT_EQ(names.size(), report_figures().size());
}

TEST(Means, AddHalfWidthsAsSquares) {
  const SolverMeans means = means_over_conditions(small_study(), small_summary(), "orpe");
  EXPECT_DOUBLE_EQ(means.theta_error_deg.value, 1.75);
  EXPECT_NEAR(means.theta_error_deg.ci95[0], 1.75 - 0.3 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(means.theta_error_deg.ci95[1], 1.75 + 0.4 / std::sqrt(2.0), 1e-12);
  EXPECT_FALSE(means_over_conditions(small_study(), small_summary(), "lspe").paper.has_value());
}

TEST(ReportText, WritesNumbersForReaders) {
  EXPECT_EQ(measure(1.305), "1.30");
  EXPECT_EQ(measure(0.01234), "0.012");
  EXPECT_EQ(measure(1300), "1300");
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(fixed(-2.5, 1), "−2.5");
  EXPECT_EQ(measure(std::numeric_limits<double>::quiet_NaN()), "–");
  EXPECT_EQ(measure(std::numeric_limits<double>::infinity()), "∞");
  EXPECT_EQ(count_of(3, 100), "3 (3.0 %)");
  EXPECT_EQ(count_of(0, 100), "0");
  EXPECT_EQ(count_of(0, 0), "–");
  EXPECT_EQ(solver_label("orpe"), "ORPE");
  EXPECT_EQ(solver_label("oracle"), "oracle");
  EXPECT_EQ(solver_label("opencv_ransac"), "OpenCV RANSAC");
  EXPECT_EQ(solver_label("minimax_two_step"), "minimax two step");
  EXPECT_EQ(words("too_few_points"), "too few points");
}

}  // namespace
}  // namespace sightline
