// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Frames with the evidence drawn over them, as in the ORPE paper's Fig. 4: the whole image, then a
// close-up of every window. The page's script shows one at a time, which a reader picks from a list
// of all trials; without it they stand one below the other.
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>

#include "eval/output/html.h"
#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/records/line_records.h"
#include "eval/report/figures.h"
#include "eval/report/frame_svg.h"
#include "eval/report/means.h"
#include "eval/report/page_text.h"
#include "eval/report/panels.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;
using nlohmann::ordered_json;

constexpr size_t kMostListed = 20'000;  // trials in the list: more would be no list

struct Layer {
  std::string name;
  std::string label;
  std::string swatch;  // a piece of SVG about the origin, 16 units wide
};

constexpr double kLabelsAcross = 50;  // the letters' size, in parts of the image's width

constexpr size_t kOutlineStyles = 6;  // in the style sheet

std::vector<Layer> layers_of(const Study& study) {
  std::vector<Layer> layers = {
      {"windows", "windows", R"(<rect class="windows" x="-5" y="-5" width="10" height="10"/>)"},
      {"edges", "edge pixels of lines and outlines, corners",
       R"(<path class="edges" d="M-5 2h0M-2.5 1h0M0 0h0M2.5 -1h0M5 -2h0"/>)"},
      {"lines", "fitted lines and outlines", R"(<path class="lines" d="M-6 4L6 -4"/>)"},
      {"found", "found", R"(<g class="found"><path d="M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0"/></g>)"},
      {"truth", "truth", R"(<g class="truth"><path d="M-4 -4L4 4M-4 4L4 -4"/></g>)"},
      {"removed", "removed as outlier",
       R"(<g class="removed"><path d="M-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0M-5 5L5 -5"/></g>)"},
  };
  for (size_t i = 0; i < study.solvers().size(); ++i) {
    layers.push_back(
        {fmt::format("outline-{}", i), "outline by " + solver_label(study.solvers()[i].name),
         fmt::format(R"(<path class="outline-{}" d="M-7 0H7"/>)", i % kOutlineStyles)});
  }
  return layers;
}

mustache::data legend(const Study& study) {
  mustache::data list(mustache::data::type::list);
  for (const Layer& layer : layers_of(study)) {
    list << mustache::object{
        {"name", layer.name}, {"label", layer.label}, {"swatch", layer.swatch}};
  }
  return list;
}

// Those that had to find out: the oracle is told. `removed_of` is the list of an estimate that may
// have the name.
std::vector<std::string> removers_of(const Study& study, const TrialRecord& record,
                                     const std::string& name,
                                     std::vector<std::string> EstimateRecord::*removed_of) {
  std::vector<std::string> solvers;
  for (const EstimateRecord& estimate : record.estimates()) {
    const TrialSolver* const solver = study.find_solver(estimate.solver);
    if (solver != nullptr && solver->evaluation_only) continue;
    const auto& removed = estimate.*removed_of;
    if (std::find(removed.begin(), removed.end(), name) != removed.end()) {
      solvers.push_back(solver_label(estimate.solver));
    }
  }
  return solvers;
}

mustache::data outlines_of(const Study& study, const FrameEvidence& frame) {
  mustache::data list(mustache::data::type::list);
  for (size_t i = 0; i < study.solvers().size(); ++i) {
    const auto found = frame.outlines.find(std::string(study.solvers()[i].name));
    if (found == frame.outlines.end() || found->second.empty()) continue;
    list << mustache::object{
        {"index", fmt::to_string(i)},
        {"style", fmt::to_string(i % kOutlineStyles)},
        {"path", outline_path(found->second)},
    };
  }
  return list;
}

// As the paper calls features: p1, p2, ...
std::string short_name(size_t index) {
  return fmt::format("p{}", index + 1);
}

std::string removed_names(const TrialRecord& record, const EstimateRecord& estimate) {
  std::string text;
  for (size_t i = 0; i < record.observations().size(); ++i) {
    const auto& removed = estimate.removed;
    const std::string& feature = record.observations()[i].feature;
    if (std::find(removed.begin(), removed.end(), feature) == removed.end()) continue;
    text += (text.empty() ? "" : ", ") + short_name(i);
  }
  return text.empty() ? "–" : text;
}

mustache::data estimates_of(const TrialRecord& record) {
  mustache::data list(mustache::data::type::list);
  for (const EstimateRecord& estimate : record.estimates()) {
    list << mustache::object{
        {"solver", solver_label(estimate.solver)},
        {"ok", estimate.is_ok()},
        {"status", words(to_string(estimate.status))},
        {"theta", measure(estimate.theta_error_deg)},
        {"t", measure(estimate.t_error_percent)},
        {"reprojection", measure(estimate.reprojection_rms_px)},
        {"removed", removed_names(record, estimate)},
    };
  }
  return list;
}

std::string state(const ObservationRecord& record) {
  if (!record.is_found()) return words(to_string(record.status));
  return fmt::format("{} px off", measure(record.error_px));
}

mustache::data tags(const ObservationRecord& record, const std::vector<std::string>& removers) {
  mustache::data list(mustache::data::type::list);
  if (record.is_outlier) list << mustache::object{{"kind", "outlier"}, {"text", "outlier"}};
  for (const std::string& solver : removers) {
    list << mustache::object{{"kind", "removed-by"}, {"text", "removed by " + solver}};
  }
  return list;
}

std::string closeup_alt(const ObservationRecord& record) {
  return fmt::format("Close-up of {}: {}{}", record.feature, state(record),
                     record.is_outlier ? ", an outlier" : "");
}

// The lines of an observation that solvers were given, the first of those that are left.
std::string line_marks_of(const Study& study, const TrialRecord& record,
                          const Observation& observation, std::span<const LineRecord>& left) {
  const size_t count = std::min(observation.edge_lines.size(), left.size());
  std::string marks;
  for (size_t i = 0; i < count; ++i) {
    marks += observed_line_mark(
        observation.edge_lines[i], left[i],
        removers_of(study, record, name_of(left[i]), &EstimateRecord::removed_lines));
  }
  left = left.subspan(count);
  return marks;
}

// Everything about a frame's features, which the image and the close-ups share.
struct FeatureDrawings {
  mustache::data closeups{mustache::data::type::list};
  mustache::data labels{mustache::data::type::list};
  std::string marks;
};

// Above and below by turns: neighbours in the list are often neighbours in the image.
int label_row(const cv::Rect& window, size_t index) {
  return index % 2 == 0 ? window.y - 4 : window.br().y + 11;
}

FeatureDrawings draw_features(const Study& study, const Trial& trial, bool has_picture) {
  FeatureDrawings drawings;
  const size_t count = std::min(trial.observations.size(), trial.record.observations().size());
  // In the order of the observations that they were found with; empty where none were used.
  std::span<const LineRecord> lines = trial.record.lines();
  for (size_t i = 0; i < count; ++i) {
    const Observation& observation = trial.observations[i];
    const ObservationRecord& record = trial.record.observations()[i];
    const auto removers =
        removers_of(study, trial.record, record.feature, &EstimateRecord::removed);
    const std::string marks = feature_marks(observation, record, removers) +
                              line_marks_of(study, trial.record, observation, lines);
    const std::string label = short_name(i);
    const bool has_window = !observation.window.empty() && has_picture;
    drawings.marks += marks;
    drawings.closeups << mustache::object{
        {"window", has_window},
        {"view", view_box(observation.window)},
        {"marks", marks},
        {"label", label},
        {"name", words(record.feature)},
        {"alt", closeup_alt(record)},
        {"state", state(record)},
        {"tags", tags(record, removers)},
    };
    if (!has_window) continue;
    drawings.labels << mustache::object{{"label", label},
                                        {"x", fmt::to_string(observation.window.x)},
                                        {"y", fmt::to_string(label_row(observation.window, i))}};
  }
  return drawings;
}

// What a picture leaves out of the image.
std::string reduction_text(const Study& study, const FramePicture& picture) {
  if (picture.png_url.empty()) {
    return !study.renders() ? "It could not be run." : "It could not be imaged.";
  }
  std::string text;
  if (picture.pixels.size() != picture.image) {
    text = fmt::format("The picture is the part about the target of {} x {} pixels.",
                       picture.image.width, picture.image.height);
  }
  if (picture.reduction > 1) {
    text += fmt::format("{}Each of its pixels is the mean of {} x {}.", text.empty() ? "" : " ",
                        picture.reduction, picture.reduction);
  }
  return text;
}

// The image, the model and what it leaves, side by side.
mustache::data residual_section(const FrameEvidence& frame) {
  if (!frame.residual) return mustache::data(mustache::data::type::list);
  const ResidualPicture& residual = *frame.residual;
  return mustache::object{{"solver", solver_label(residual.solver)},
                          {"view", view_box(residual.pixels)},
                          {"x", fmt::format("{}", residual.pixels.x - 0.5)},
                          {"y", fmt::format("{}", residual.pixels.y - 0.5)},
                          {"width", fmt::to_string(residual.pixels.width)},
                          {"height", fmt::to_string(residual.pixels.height)},
                          {"model", residual.model_url},
                          {"residual", residual.residual_url},
                          {"most", fmt::to_string(kMostResidualSds)}};
}

mustache::data frame_section(const Study& study, const FrameEvidence& frame, size_t number) {
  const TrialRecord& record = frame.stored;
  const FramePicture& picture = frame.picture;
  const std::string id = fmt::format("frame-{}", number);
  const bool has_picture = !picture.png_url.empty();
  const FeatureDrawings drawings = draw_features(study, frame.trial, has_picture);
  const bool has_conditions = study.conditions.size() > 1;
  return mustache::object{
      {"id", id},
      {"caption", frame.caption},
      {"alt", fmt::format("{}: the target with windows, features and outlines", frame.caption)},
      {"condition", has_conditions ? study.conditions[record.condition].label + ". " : ""},
      {"trial", fmt::to_string(record.trial)},
      {"image", study.renders() ? "" : ", " + study.images()->sighting_of(record.trial).image},
      {"theta", triple(attitude_deg(record.true_cam_from_target.rotation), 1)},
      {"t", triple(record.true_cam_from_target.translation, 2)},
      {"reduction", reduction_text(study, picture)},
      {"has_image", has_picture},
      {"png", picture.png_url},
      {"x", fmt::format("{}", picture.pixels.x - 0.5)},
      {"y", fmt::format("{}", picture.pixels.y - 0.5)},
      {"width", fmt::to_string(picture.pixels.width)},
      {"height", fmt::to_string(picture.pixels.height)},
      {"view", view_box(picture.pixels)},
      {"outlines", outlines_of(study, frame)},
      {"marks", drawings.marks},
      {"labels", drawings.labels},
      {"size", fmt::format("{:.1f}", picture.pixels.width / kLabelsAcross)},
      {"residuals", residual_section(frame)},
      {"estimates", estimates_of(record)},
      {"closeups", drawings.closeups},
  };
}

// What a solver made of a trial, in words to choose by.
std::string kind_of(const EstimateRecord& estimate) {
  if (!estimate.is_ok()) return "no pose: " + words(to_string(estimate.status));
  if (estimate.false_removals > 0 && estimate.missed_outliers > 0) {
    return "removed an inlier, kept an outlier";
  }
  if (estimate.false_removals > 0) return "removed an inlier";
  if (estimate.missed_outliers > 0) return "kept an outlier";
  return estimate.removed.empty() ? "removed nothing, rightly" : "removed just the outliers";
}

// Adds each solver's error and kind; kinds are numbered as they come.
void add_estimates(ordered_json& json, const TrialRecord& trial,
                   const std::vector<TrialError>& errors,
                   std::map<std::string, size_t>& number_of) {
  for (size_t s = 0; s < trial.estimates().size(); ++s) {
    const double error = errors.front().of(trial, s);
    json["error"][s].push_back(std::isfinite(error) ? ordered_json(std::round(1e4 * error) / 1e4)
                                                    : ordered_json(nullptr));
    const size_t next = number_of.size();
    const auto [kind, is_new] = number_of.emplace(kind_of(trial.estimates()[s]), next);
    if (is_new) json["kinds"].push_back(kind->first);
    json["kind"][s].push_back(kind->second);
  }
}

// All trials, column by column, for the list to pick from.
std::string trial_list(const ReportInput& input) {
  const Study& study = input.study;
  ordered_json json = {{"solvers", ordered_json::array()},    {"lead", 0},
                       {"conditions", ordered_json::array()}, {"kinds", ordered_json::array()},
                       {"trial", ordered_json::array()},      {"condition", ordered_json::array()},
                       {"frame", ordered_json::array()},      {"error", ordered_json::array()},
                       {"kind", ordered_json::array()}};
  const std::string lead = lead_solver(study);
  for (const TrialSolver& solver : study.solvers()) {
    if (solver.name == lead) json["lead"] = json["solvers"].size();
    json["solvers"].push_back(solver_label(solver.name));
    json["error"].push_back(ordered_json::array());
    json["kind"].push_back(ordered_json::array());
  }
  for (const Condition& condition : study.conditions) json["conditions"].push_back(condition.label);
  json["shards"] = study.trial_count();
  json["all"] = input.trials.size();
  const std::vector<TrialError> errors = trial_errors(study);
  std::map<std::string, size_t> number_of;
  std::map<int64_t, size_t> frame_of;
  for (size_t i = 0; i < input.frames.size(); ++i) frame_of[input.frames[i].stored.trial] = i + 1;
  size_t listed = 0;
  for (const TrialRecord& trial : input.trials) {
    const auto frame = frame_of.find(trial.trial);
    const bool is_framed = frame != frame_of.end();
    if (trial.estimates().size() != study.solvers().size()) continue;
    if (!is_framed && ++listed > kMostListed) continue;
    json["trial"].push_back(trial.trial);
    json["condition"].push_back(trial.condition);
    json["frame"].push_back(is_framed ? frame->second : 0);
    add_estimates(json, trial, errors, number_of);
  }
  return script_json(json.dump());
}

}  // namespace

std::string frames_figure(const ReportInput& input) {
  if (input.frames.empty()) return "";
  mustache::data frames(mustache::data::type::list);
  for (size_t i = 0; i < input.frames.size(); ++i) {
    frames << frame_section(input.study, input.frames[i], i + 1);
  }
  return mustache::mustache(page_text("frames.mustache"))
      .render(mustache::object{
          {"shown", fmt::to_string(input.frames.size())},
          {"trials", counted(static_cast<int64_t>(input.trials.size()), "trial")},
          {"layers", legend(input.study)},
          {"frames", frames},
          {"data", trial_list(input)},
      });
}

}  // namespace sightline
