// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/report.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/output/text.h"
#include "eval/report/chart_js.h"
#include "eval/report/evidence.h"
#include "eval/report/frame_svg.h"
#include "eval/report/means.h"
#include "eval/report/outline.h"
#include "pose/attitude.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kSide = 64;
// A feature whose name would break a page that forgets to escape.
constexpr const char* kEvilName = "tip <b>&\"quoted\"";

Mesh one_triangle() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.parts = {{"plate", 0.8}};
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  mesh.triangles = {{{0, 1, 2}, 0, {normal, normal, normal}}};
  return mesh;
}

std::shared_ptr<const Target> small_target() {
  const Mesh mesh = one_triangle();
  std::vector<TargetFeature> features(4);
  const char* names[] = {kEvilName, "root", "fin", "nose"};
  for (size_t i = 0; i < features.size(); ++i) {
    features[i].name = names[i];
    features[i].parts = {"plate"};
  }
  std::vector<FeatureShape> shapes = feature_shapes(mesh, features);
  return std::make_shared<Target>(Target{
      "plate", "one triangle", mesh, {}, std::move(features), Occluder(mesh), std::move(shapes)});
}

Study small_study() {
  Study study;
  study.name = "small";
  study.title = "A small study of <plates>";
  study.question = "Is 1 < 2 & 2 > 1?";
  study.draws = 2;
  study.conditions = {{"pose 1", {{"pose", 1}}, {{"orpe", {2.07, 1.6}}}},
                      {"pose 2", {{"pose", 2}}, {{"orpe", {3.07, 2.6}}}}};
  study.conditions[1].pose = 1;
  study.poses.theta_deg = {{-20, 30, 40}, {20, 30, 30}};
  study.poses.t_m = {{-5, 5, 1300}, {5, 5, 1500}};
  study.target = small_target();
  study.features = {0, 1, 2, 3};
  study.camera = centred_camera(kSide, kSide, 1000);
  ImageSetup& setup = study.setups.emplace_back();
  setup.scene.camera = study.camera;
  setup.extractors = {find_feature_extractor("hough_intersection"),
                      find_feature_extractor("shi_tomasi_nearest")};
  study.solvers = {find_pose_solver("orpe"), find_pose_solver("lspe"), find_pose_solver("oracle")};
  study.toml = "# </code><script>alert(1)</script>\nseed = 1\n";
  return study;
}

ObservationRecord found(const std::string& name, const Eigen::Vector2d& pixel, double error_px,
                        bool is_outlier = false) {
  ObservationRecord record;
  record.feature = name;
  record.is_visible = true;
  record.pixel = pixel;
  record.true_pixel = pixel - Eigen::Vector2d(error_px, 0);
  record.error_px = error_px;
  record.is_outlier = is_outlier;
  return record;
}

ObservationRecord missing(const std::string& name, ObservationOutcome status) {
  ObservationRecord record;
  record.feature = name;
  record.status = status;
  return record;
}

EstimateRecord estimate(const std::string& solver, double theta_error_deg,
                        EstimateOutcome status = EstimateOutcome::kOk) {
  EstimateRecord record;
  record.solver = solver;
  record.status = status;
  record.theta_error_deg = theta_error_deg;
  record.t_error_percent = theta_error_deg / 2;
  return record;
}

TrialRecord small_trial(int64_t index, double orpe_error_deg) {
  TrialRecord trial;
  trial.trial = index;
  trial.condition = static_cast<int>(index % 2);
  trial.true_cam_from_target.translation = {0, 0, 1300};
  trial.pose_trial().observations = {
      found(kEvilName, {20, 20}, 0.4), found("root", {40, 22}, 9.5, true),
      missing("fin", ObservationOutcome::kTooFewEdgePixels), found("nose", {30, 45}, 0.2)};
  trial.pose_trial().estimates = {estimate("orpe", orpe_error_deg),
                                  estimate("lspe", orpe_error_deg + 1), estimate("oracle", 0.1)};
  trial.pose_trial().estimates[0].removed = {"root"};
  trial.pose_trial().estimates[0].is_test_failed = false;
  return trial;
}

Observation observed(int feature, const cv::Rect& window) {
  Observation observation;
  observation.feature = feature;
  observation.window = window;
  ImageLine line;
  line.point = {window.x + 5.0, window.y + 5.0};
  line.direction = Eigen::Vector2d(3, 4) / 5;
  line.edge_pixels = {line.point, line.point + Eigen::Vector2d(3, 4)};
  observation.lines = {line};
  return observation;
}

FrameEvidence small_frame(const TrialRecord& record) {
  FrameEvidence frame;
  frame.caption = "pose 1, draw 1; worst of ORPE";
  frame.stored = record;
  frame.trial.record = record;
  cv::Mat image(kSide, kSide, CV_8U, cv::Scalar(40));
  image(cv::Rect(16, 16, 24, 24)) = 200;
  frame.picture = picture_of(image, 8, {});
  frame.trial.observations = {observed(0, {12, 12, 17, 17}), observed(1, {32, 14, 17, 17}),
                              observed(2, {12, 40, 17, 17}), observed(3, {22, 37, 17, 17})};
  frame.outlines["orpe"] = {{{15.5, 15.5}, {39.5, 15.5}, {39.5, 39.5}, {15.5, 39.5}}};
  return frame;
}

ErrorSummary error_summary(double mean) {
  ErrorSummary summary;
  summary.mean = mean;
  summary.mean_ci95 = {mean - 0.3, mean + 0.4};
  summary.median = mean - 0.05;
  return summary;
}

Summary small_summary() {
  Summary summary;
  for (int condition = 0; condition < 2; ++condition) {
    for (const char* solver : {"orpe", "lspe", "oracle"}) {
      CellSummary cell;
      cell.condition = condition;
      cell.solver = solver;
      cell.trials = 2;
      cell.failures = condition;
      cell.theta_error_deg = error_summary(1.25 + condition);
      cell.t_error_percent = error_summary(0.75);
      cell.ratio_to_bound = std::numeric_limits<double>::quiet_NaN();
      summary.cells.push_back(cell);
    }
    CellObservations observations;
    observations.condition = condition;
    observations.trials = 2;
    observations.inlier_rms_px = 0.31;
    observations.bound_theta_deg = 0.123;
    observations.bound_t_percent = 0.0456;
    observations.outliers = 1;
    summary.observations.push_back(observations);
    for (const char* feature : {kEvilName, "root", "fin", "nose"}) {
      summary.features.push_back({condition, feature, 2, 2, 0, 0.3, 0.25});
    }
  }
  return summary;
}

// Lines may break wherever a page has a space.
std::string one_line(const std::string& text) {
  return std::regex_replace(text, std::regex(R"([ \n]+)"), " ");
}

// A report of everything, held together.
struct SmallReport {
  Study study = small_study();
  Summary summary = small_summary();
  std::vector<TrialRecord> trials = {small_trial(0, 1), small_trial(1, 5), small_trial(2, 2),
                                     small_trial(3, 3)};
  std::vector<FrameEvidence> frames = {small_frame(trials[0])};

  ReportInput input() const {
    return {study, summary, trials, frames, {{"version", "0.1.0"}, {"machine", "two <cores>"}}};
  }
  // Without Chart.js, which is not ours to judge.
  std::string page() const {
    std::string text = render_report(input());
    const std::string library = chart_js();
    const size_t at = text.find(library);
    if (at == std::string::npos) return "a page without Chart.js";
    return one_line(text.erase(at, library.size()));
  }
};

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

size_t count(const std::string& text, const std::string& part) {
  size_t times = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++times;
  return times;
}

// HasSubstr would print the whole page.
::testing::AssertionResult has(const std::string& page, const std::string& part) {
  const bool is_there = page.find(part) != std::string::npos;
  return (is_there ? ::testing::AssertionSuccess() : ::testing::AssertionFailure())
         << "the page " << (is_there ? "has " : "lacks ") << part;
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
  report.study.kind = StudyKind::kNumeric;
  report.study.claim = "It is <small>.";
  report.frames.clear();
  return report;
}

// Its poses are drawn, so that there is a plane of angles.
SmallReport small_drawn_study() {
  SmallReport report;
  report.study.poses.theta_deg.clear();
  return report;
}

TEST(Report, HasEveryFigureAndAWayToIt) {
  const std::string page = SmallReport().page();
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
  report.study.kind = StudyKind::kOrientation;
  report.study.solvers.clear();
  report.study.pairs.timed_repeats = 10;
  const OrientationMethod other{"other_way", "", nullptr, nullptr};
  report.study.methods = {find_orientation_method("fast"), &other};
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

TEST(Report, SaysWhatPageFileIsMissing) {
  const fs::path folder = fs::path(::testing::TempDir()) / "assets without a report";
  fs::create_directories(folder / "targets");
  const ScopedVariable assets("SIGHTLINE_ASSETS", folder.string());
  try {
    SmallReport().page();
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr((folder / "report").string()));
  }
}

TEST(ReportCatalogue, EqualsTheFolder) {
  const std::set<std::string> helpers = {"chart",   "distributions", "evidence", "frame_svg",
                                         "gnuplot", "means",         "outline",  "page",
                                         "panels",  "report",        "text"};
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

TEST(SilhouetteFigure, SaysWhereTheOutlineShowsEachFeature) {
  SmallReport report;
  const std::string page = one_line(report.page());
  EXPECT_TRUE(has(page, "The outline beside each feature, at the true poses of 4 trials."));
  EXPECT_TRUE(has(page, "<td>4</td><td class=\"kind\">corner</td>"));
  report.trials[1].pose_trial().observations.clear();  // a pose that could not be imaged
  const std::string fewer = one_line(report.page());
  EXPECT_TRUE(has(fewer, "at the true poses of 3 of 4 trials."));
  EXPECT_TRUE(has(fewer, "<td>3</td><td class=\"kind\">corner</td>"));
}

TEST(SilhouetteFigure, OfManyTrialsTakesSome) {
  SmallReport report;
  EXPECT_FALSE(has(one_line(report.page()), "chosen at random"));
  for (int64_t i = 4; i < 400; ++i) report.trials.push_back(small_trial(i, 1));
  const std::string page = one_line(report.page());
  EXPECT_TRUE(has(page, "at the true poses of 300 of 400 trials."));
  EXPECT_TRUE(has(page, "<td>300</td><td class=\"kind\">corner</td>"));
  EXPECT_TRUE(has(page, "Views are those that show it, of poses chosen at random."));
}

TEST(SilhouetteFigure, IsAbsentWhereNoFeatureHasAnOutline) {
  SmallReport report;
  Target bare = *report.study.target;
  bare.shapes.clear();
  report.study.target = std::make_shared<Target>(std::move(bare));
  EXPECT_FALSE(has(report.page(), "The outline beside each feature"));
}

TEST(AnswerFigure, StatesMeansIntervalsFailuresAndThePaper) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "Is 1 &lt; 2 &amp; 2 &gt; 1?"));
  EXPECT_TRUE(has(page, "<b>1.75°</b>"));  // of 1.25 and 2.25
  EXPECT_TRUE(has(page, "The paper’s figures average 2.57° and 2.1&nbsp;%"));
  EXPECT_TRUE(has(page, "1 of 4 trials without a pose"));
}

TEST(AnswerFigure, ComparesSolversTrialByTrial) {
  SmallReport report;
  EXPECT_TRUE(has(report.page(), "the θ error of ORPE is 1.00° [1.00, 1.00] smaller"));
  for (size_t i = 0; i < report.trials.size(); ++i) {
    report.trials[i].pose_trial().estimates[1].theta_error_deg =
        report.trials[i].pose_trial().estimates[0].theta_error_deg + (i % 2 == 0 ? 0.5 : -0.5);
  }
  EXPECT_TRUE(has(report.page(), "do not tell the θ errors of ORPE and LSPE apart"));
}

// As of a shard that has no trial of pose 1.
SmallReport report_of_pose_2() {
  SmallReport report;
  for (CellSummary& cell : report.summary.cells) {
    if (cell.condition != 0) continue;
    CellSummary empty;
    empty.solver = cell.solver;
    cell = empty;
  }
  report.summary.observations[0] = {};
  std::erase_if(report.trials, [](const TrialRecord& trial) { return trial.condition == 0; });
  return report;
}

TEST(AnswerFigure, LeavesConditionsWithoutTrialsOut) {
  const std::string page = report_of_pose_2().page();
  EXPECT_TRUE(has(page, "Over 2 trials in 1 of the 2 conditions"));
  EXPECT_TRUE(has(page, "<b>2.25°</b>"));
  EXPECT_TRUE(has(page, "The paper’s figures average 3.07° and 2.6&nbsp;%")) << "of pose 2 alone";
  EXPECT_TRUE(has(page, "is 0.12° and 0.046 % in the mean"));  // the bound
}

TEST(TableFigure, LeavesConditionsWithoutTrialsOutOfTheMeans) {
  const std::string page = report_of_pose_2().page();
  EXPECT_TRUE(has(page, "<b>–</b> <span class=\"interval\"></span>"));
  EXPECT_FALSE(has(page, "[–, –]"));
  EXPECT_TRUE(has(page, "<th scope=\"row\">bound</th><td>–</td>"));
  const std::string mean = page.substr(page.find("colspan=\"6\">mean<"));
  EXPECT_TRUE(has(mean, "<th scope=\"row\">bound</th><td>0.12</td><td></td> <td>0.046</td>"));
}

TEST(TableFigure, StandsBesideThePaper) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "(−20, 30, 40)"));
  EXPECT_TRUE(has(page, "(−5, 5, 1300)"));
  EXPECT_TRUE(has(page, "<td class=\"beside\">2.07</td>"));
  EXPECT_TRUE(has(page, "[0.95, 1.65]"));
  EXPECT_TRUE(has(page, "colspan=\"6\">mean<"));
  EXPECT_TRUE(has(page, "3 of 12 estimates failed"));
}

TEST(TableFigure, ShowsMediansWhereThePaperPrintsNothing) {
  SmallReport report;
  for (Condition& condition : report.study.conditions) condition.paper.clear();
  report.study.poses.theta_deg.clear();
  report.study.poses.t_m.clear();
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "class=\"beside\">median</th>"));
  EXPECT_TRUE(has(page, "<td class=\"beside\">1.20</td>"));
  EXPECT_FALSE(has(page, "class=\"beside\">paper</th>"));
  EXPECT_FALSE(has(page, "The paper"));
  EXPECT_FALSE(has(page, "colspan=\"6\">mean<"));
  EXPECT_FALSE(has(page, "could not be imaged"));
}

TEST(TableFigure, NamesTheTrialsThatCouldNotBeImaged) {
  SmallReport report;
  report.trials[1].pose_trial().observations.clear();
  report.trials[3].pose_trial().observations.clear();
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "Trials that could not be imaged: 2 of 4 trials"));
  EXPECT_TRUE(has(page, "<li>pose 2: 1, 3</li>"));
}

TEST(ExtractionFigure, SaysWhyAFeatureWasMissing) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "too few edge pixels (4)"));
  EXPECT_TRUE(has(page, "4 (100.0 %)"));  // outliers of root
}

TEST(FramesFigure, ShowsTheEvidence) {
  const std::string page = SmallReport().page();
  EXPECT_EQ(count(page, "data:image/png;base64,"), 1u);  // once a frame, however many close-ups
  EXPECT_EQ(count(page, "<use href=\"#frame-1-image\"/>"), 4u);
  EXPECT_TRUE(has(page, "root: removed by ORPE"));
  EXPECT_TRUE(has(page, "<td class=\"text\">p2</td>"));
  EXPECT_TRUE(has(page, "fin: too few edge pixels"));
  EXPECT_TRUE(has(page, "id=\"frame-1-outline-0\""));
  EXPECT_FALSE(has(page, "id=\"frame-1-outline-1\""));  // no outline of LSPE was given
  for (const char* layer :
       {"windows", "edges", "lines", "found", "truth", "removed", "outline-2"}) {
    EXPECT_TRUE(has(page, std::string("id=\"show-") + layer + "\""));
  }
}

TEST(FramesFigure, MarksNoRemovalWhereNothingWasRemoved) {
  SmallReport report;
  report.frames[0].trial.record.pose_trial().estimates[0].removed.clear();
  EXPECT_FALSE(has(report.page(), "class=\"layer-removed"));
}

TEST(FramesFigure, ShowsAFailedSolverAndAFrameWithoutImage) {
  SmallReport report;
  report.frames[0].stored.pose_trial().estimates[0].status = EstimateOutcome::kTooFewPoints;
  EXPECT_TRUE(has(report.page(), "no pose: too few points"));
  report.frames[0].picture = {};
  EXPECT_FALSE(has(report.page(), "data:image/png"));
  EXPECT_TRUE(has(report.page(), "It could not be imaged."));
}

TEST(FramesFigure, StatesTheStoredNumbers) {
  SmallReport report;
  report.frames[0].stored.pose_trial().estimates[0].theta_error_deg = 7.89;
  report.frames[0].trial.record.pose_trial().estimates[0].theta_error_deg = 4.56;
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "<td>7.89</td>"));
  EXPECT_FALSE(has(page, "<td>4.56</td>"));
}

TEST(ProvenanceFigure, RepeatsTheRunFromItsStudyFile) {
  SmallReport report;
  const auto page_of = [&report](const std::string& shard) {
    const ReportInput input{report.study,
                            report.summary,
                            report.trials,
                            report.frames,
                            {{"shard", shard}, {"command", "sightline study x --set a=<b>"}}};
    return one_line(render_report(input));
  };
  EXPECT_TRUE(has(page_of("0/1"), "<code>sightline study study.toml --out again</code>"));
  EXPECT_TRUE(has(page_of("merged from 4"), "<code>sightline study study.toml --out again</code>"));
  EXPECT_TRUE(
      has(page_of("1/4"), "<code>sightline study study.toml --shard 1/4 --out again</code>"));
  EXPECT_TRUE(has(page_of("0/1"), "typed: <code>sightline study x --set a=&lt;b&gt;</code>"));
  EXPECT_TRUE(has(report.page(), "study.toml --out again"));  // without a manifest
  EXPECT_FALSE(has(report.page(), "What was typed"));
  EXPECT_FALSE(has(report.page(), "interrupt"));
}

TEST(FrameSvg, PutsPixelCentresAtIntegers) {
  EXPECT_EQ(view_box({0, 0, 64, 32}), "-0.5 -0.5 64 32");
  EXPECT_TRUE(has(SmallReport().page(), "x=\"-0.5\" y=\"-0.5\" width=\"64\" height=\"64\""));
}

TEST(FrameSvg, CutsLinesAtTheirWindow) {
  Observation observation = observed(0, {10, 20, 11, 11});
  observation.lines[0].point = {15, 25};
  observation.lines[0].direction = Eigen::Vector2d::UnitX();
  const ObservationRecord record = missing("a", ObservationOutcome::kParallelLines);
  EXPECT_THAT(feature_marks(observation, record, {}), HasSubstr("d=\"M9.5 25L20.5 25\""));
  observation.lines[0].point = {15, 40};  // passes by the window
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-lines")));
}

TEST(FrameSvg, DrawsTheEdgePixelsThatAnOutlineWasLaidOn) {
  Observation observation;
  observation.window = {10, 20, 11, 11};
  const ObservationRecord record = missing("a", ObservationOutcome::kTooFewEdgePixels);
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-edges")));
  observation.contour = {{12.25, 22}, {13, 22.5}};
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("<path class=\"layer-edges edges\" d=\"M12.25 22h0M13 22.5h0\"/>"));
}

TEST(FrameSvg, DrawsALaidOutlineFromNeighbourToNeighbour) {
  Observation observation;
  observation.window = {10, 20, 11, 11};
  const ObservationRecord record = missing("a", ObservationOutcome::kParallelLines);
  EXPECT_THAT(feature_marks(observation, record, {}), Not(HasSubstr("layer-lines")));
  observation.laid_outline = {{12, 22}, {10, 22}, {13, 23}, {11, 22}, {13, 24}};
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("<path class=\"layer-lines lines\" d=\"M10 22L12 22L13 23L13 24\"/>"));
  observation.laid_outline = {{12, 22}, {11, 22}, {20, 22}, {21, 22}, {30, 40}};  // one alone
  EXPECT_THAT(feature_marks(observation, record, {}),
              HasSubstr("d=\"M20 22L21 22M12 22L11 22\"/>"));
}

TEST(FrameSvg, DrawsOutlinesAsClosedPaths) {
  EXPECT_EQ(outline_path({{{0, 0.25}, {1.5, 0}, {1, 2}}}), "M0 0.25L1.5 0L1 2Z");
  EXPECT_EQ(outline_path({}), "");
}

TEST(Outline, FinerCamerasSeeTheSame) {
  const Camera coarse = centred_camera(512, 512, 10000);
  const Camera fine = finer(coarse, 4);
  const Eigen::Vector3d x(3, -7, 1300);
  const Eigen::Vector2d in_coarse = *project(coarse, x);
  const Eigen::Vector2d in_fine = *project(fine, x);
  const Eigen::Vector2d half(0.5, 0.5);
  EXPECT_LT(((in_fine + half) / 4 - half - in_coarse).norm(), 1e-9);
}

// Half a subdivided pixel inside the silhouette, and half a one of the raster.
constexpr double kOutlineTolerancePx = 0.3;

Scene cube_scene() {
  Scene scene;
  scene.target = load_target("cube");
  scene.camera = centred_camera(256, 256, 2000);
  scene.cam_from_target.rotation = rotation_from_attitude({0.4, -0.3, 0.2});
  scene.cam_from_target.translation = {0.3, -0.2, 20};
  return scene;
}

TEST(Outline, SpansWhatTheMeshProjectsTo) {
  Renderer renderer;
  const Scene scene = cube_scene();
  const Outline outline = target_outline(renderer, scene, scene.cam_from_target);
  ASSERT_EQ(outline.size(), 1u);
  Eigen::AlignedBox2d drawn;
  for (const Eigen::Vector2d& pixel : outline[0]) drawn.extend(pixel);
  Eigen::AlignedBox2d projected;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    projected.extend(*project(scene.camera, scene.cam_from_target * vertex));
  }
  EXPECT_LT((drawn.min() - projected.min()).cwiseAbs().maxCoeff(), kOutlineTolerancePx);
  EXPECT_LT((drawn.max() - projected.max()).cwiseAbs().maxCoeff(), kOutlineTolerancePx);
}

TEST(Outline, OfWhatCannotBeImagedIsEmpty) {
  Renderer renderer;
  const Scene scene = cube_scene();
  Pose behind = scene.cam_from_target;
  behind.translation.z() = -20;
  EXPECT_TRUE(target_outline(renderer, scene, behind).empty());
}

TEST(FramesFigure, ListsEveryTrialWithItsErrorAndKind) {
  SmallReport report;
  report.trials[2].pose_trial().estimates[0].status = EstimateOutcome::kTooFewPoints;
  const std::string page = report.page();
  EXPECT_TRUE(has(page, R"("trial":[0,1,2,3],"condition":[0,1,0,1],"frame":[1,0,0,0])"));
  EXPECT_TRUE(has(page, R"("error":[[1.0,5.0,null,3.0],[2.0,6.0,3.0,4.0])"));
  EXPECT_TRUE(has(page, R"("kinds":["removed just the outliers","removed nothing, rightly",)"
                        R"("no pose: too few points"])"));
  EXPECT_TRUE(has(page, R"("shards":4)"));
}

TEST(FrameSvg, ShowsAllButSmallImagesByTheirPartAboutTheTarget) {
  const cv::Mat image(3000, 4000, CV_8U, cv::Scalar(40));
  const FramePicture part = picture_of(image, 8, {1000, 500, 800, 700});
  EXPECT_EQ(part.pixels, cv::Rect(919, 419, 962, 862));  // a margin of a tenth, and a pixel
  EXPECT_EQ(part.reduction, 1);
  const FramePicture whole = picture_of(image, 8, {0, 0, 4000, 3000});
  EXPECT_EQ(whole.reduction, 4);
  EXPECT_EQ(whole.pixels, cv::Rect(0, 0, 4000, 3000));
  EXPECT_LT(whole.png_url.size(), 100'000u);
  const FramePicture small = picture_of(image({0, 0, 256, 200}), 8, {100, 100, 20, 20});
  EXPECT_EQ(small.pixels, cv::Rect(0, 0, 256, 200));
  EXPECT_TRUE(picture_of({}, 8, {}).png_url.empty());
}

// The choices as trial numbers, for a solver's story is told by its captions.
std::map<int64_t, std::string> captions(const std::vector<FrameChoice>& choices) {
  std::map<int64_t, std::string> by_trial;
  for (const FrameChoice& choice : choices) by_trial[choice.trial] += choice.caption;
  return by_trial;
}

TEST(Evidence, TakesTheFirstDrawOfEachConditionTheMedianAndTheWorst) {
  const SmallReport report;
  const auto choices = choose_frames(report.study, report.trials);
  ASSERT_EQ(choices.size(), 4u);  // all, as there is room
  EXPECT_EQ(choices[0].trial, 0);
  EXPECT_THAT(choices[0].caption, HasSubstr("pose 1, draw 1; ORPE removes an outlier"));
  EXPECT_EQ(choices[1].trial, 1);
  EXPECT_THAT(choices[1].caption, HasSubstr("pose 2, draw 1; worst pose of ORPE"));
  EXPECT_EQ(choices[2].trial, 3);
  EXPECT_THAT(choices[2].caption, HasSubstr("median of ORPE"));
}

TEST(Evidence, TakesEachKindOfFailureOfEverySolver) {
  SmallReport report;
  report.trials[2].pose_trial().estimates[0].status = EstimateOutcome::kDiverged;
  report.trials[3].pose_trial().estimates[0].false_removals = 1;
  report.trials[3].pose_trial().estimates[1].missed_outliers = 1;
  auto found = captions(choose_frames(report.study, report.trials));
  EXPECT_THAT(found[2], HasSubstr("ORPE finds no pose: diverged"));
  EXPECT_THAT(found[3], HasSubstr("ORPE removes an inlier"));
  EXPECT_THAT(found[3], HasSubstr("LSPE keeps an outlier"));
  EXPECT_THAT(found[0], HasSubstr("a feature is missing: too few edge pixels"));
  EXPECT_THAT(found[0], Not(HasSubstr("finds no pose")));
}

SmallReport random_study(int trials) {
  SmallReport report;
  report.study.conditions.resize(1);
  report.trials.clear();
  for (int i = 0; i < trials; ++i) {
    report.trials.push_back(small_trial(i, trials - i));
    report.trials.back().condition = 0;
  }
  return report;
}

TEST(Evidence, TakesEachTrialOnceUpToItsLimitAndTheSameAgain) {
  const SmallReport report = random_study(100);
  const auto choices = choose_frames(report.study, report.trials);
  EXPECT_EQ(choices.size(), kMostFrames);
  EXPECT_EQ(captions(choices).size(), choices.size());
  EXPECT_EQ(captions(choices), captions(choose_frames(report.study, report.trials)));
  EXPECT_EQ(choices.front().trial, 0);  // the first is the worst as well
  EXPECT_THAT(choices.front().caption, HasSubstr("first draw; worst pose of ORPE"));
  EXPECT_EQ(choices.back().caption, "chosen at random");
  EXPECT_EQ(choose_frames(report.study, report.trials, 5).size(), 5u);
}

TEST(Evidence, OfATrialWithoutAnyPoseIsThatTrial) {
  SmallReport report = random_study(1);
  for (EstimateRecord& estimate : report.trials[0].pose_trial().estimates)
    estimate.status = EstimateOutcome::kTooFewPoints;
  const auto choices = choose_frames(report.study, report.trials);
  ASSERT_EQ(choices.size(), 1u);
  EXPECT_THAT(choices[0].caption, HasSubstr("ORPE finds no pose: too few points"));
  EXPECT_THAT(choices[0].caption, Not(HasSubstr("worst")));
}

TEST(Evidence, SaysWhereTheRunAgainDiffersFromTheStoredTrial) {
  Renderer renderer;
  StudyOverrides overrides;
  overrides.trials = 1;
  const Study study = read_study("boeing-table1", overrides);
  std::vector<TrialRecord> trials = {run_trial(study, 0, renderer).record};
  const std::string differs = "this re-run differs from the stored trial";

  std::vector<FrameEvidence> frames = gather_evidence(study, trials, renderer);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_THAT(frames[0].caption, Not(HasSubstr(differs)));

  double& x_m = trials[0].pose_trial().estimates[0].cam_from_target.translation.x();
  x_m = std::nextafter(x_m, 1e9);
  frames = gather_evidence(study, trials, renderer);
  EXPECT_THAT(frames[0].caption, HasSubstr(differs));
  EXPECT_EQ(frames[0].stored.estimates()[0].cam_from_target.translation.x(), x_m);

  trials[0].pose_trial().estimates[0].status = EstimateOutcome::kDegenerate;
  EXPECT_THAT(gather_evidence(study, trials, renderer)[0].caption, HasSubstr(differs));
}

TEST(Evidence, OfNothingIsNothing) {
  EXPECT_TRUE(choose_frames(small_study(), {}).empty());
}

TEST(Means, AddHalfWidthsAsSquares) {
  const SolverMeans means = means_over_conditions(small_study(), small_summary(), "orpe");
  EXPECT_DOUBLE_EQ(means.theta_error_deg.mean, 1.75);
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
