// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Frames with the evidence drawn over them, as in the ORPE paper's Fig. 4: the whole image, then a
// close-up of every window.
#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/report/figures.h"
#include "eval/report/frame_svg.h"
#include "eval/report/text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

// The legend's boxes need no script: a rule each hides a layer whose box is not ticked.
constexpr const char* kTemplate = R"html(
<p>A choice of trials, run again for their pictures: the image as the extractor saw it, what it
found, and the target’s outline at each solver’s pose. The tables state the stored trials.</p>
<style>
{{#layers}}#frames:has(#show-{{name}}:not(:checked)) .layer-{{name}} { display: none; }
{{/layers}}
</style>
<fieldset class="legend">
<legend>Layers</legend>
{{#layers}}
<label><input type="checkbox" id="show-{{name}}" checked>
<svg class="swatch" viewBox="-8 -8 16 16" aria-hidden="true">{{{swatch}}}</svg>{{label}}</label>
{{/layers}}
</fieldset>
{{#frames}}
<article class="frame" id="{{id}}" aria-labelledby="{{id}}-title">
<h3 id="{{id}}-title">{{caption}}</h3>
<p class="given">True pose: <i>θ</i> = {{theta}}°, <i>T</i> = {{t}} m <span class="note">(trial
{{trial}})</span></p>
<div class="evidence">
{{#has_image}}
<div class="picture">
<svg class="whole" viewBox="{{view}}" role="img" aria-labelledby="{{id}}-alt">
<title id="{{id}}-alt">{{alt}}</title>
<image class="pixels" id="{{id}}-image" x="-0.5" y="-0.5" width="{{width}}" height="{{height}}"
href="{{{png}}}"/>
{{#outlines}}<g class="layer-outline-{{index}} outline-{{style}}"><path class="outline"
id="{{id}}-outline-{{index}}" d="{{path}}"/></g>
{{/outlines}}
{{{marks}}}
{{#labels}}<text class="layer-windows name" x="{{x}}" y="{{y}}"
font-size="{{size}}">{{label}}</text>{{/labels}}
</svg>
</div>
{{/has_image}}
<div class="scroll" role="region" aria-label="Errors in this frame, table" tabindex="0">
<table class="errors">
<caption><span>What each solver made of this frame.</span></caption>
<thead><tr><th scope="col">Solver</th><th scope="col"><i>θ</i>&nbsp;error,&nbsp;°</th><th
scope="col"><i>T</i>&nbsp;error,&nbsp;%</th>
<th scope="col">reprojection RMS,&nbsp;px</th><th scope="col" class="text">removed</th></tr></thead>
<tbody>
{{#estimates}}
<tr><th scope="row">{{solver}}</th>
{{#ok}}<td>{{theta}}</td><td>{{t}}</td><td>{{reprojection}}</td><td
class="text">{{removed}}</td>{{/ok}}
{{^ok}}<td colspan="4" class="text">no pose: {{status}}</td>{{/ok}}</tr>
{{/estimates}}
</tbody>
</table>
</div>
</div>
<ul class="closeups">
{{#closeups}}
<li class="closeup">
{{#window}}
<svg viewBox="{{view}}" role="img" aria-label="{{alt}}">
<use href="#{{id}}-image"/>
{{#outlines}}<use class="layer-outline-{{index}} outline-{{style}}"
href="#{{id}}-outline-{{index}}"/>{{/outlines}}
{{{marks}}}
</svg>
{{/window}}
{{^window}}<div class="no-window">no window</div>{{/window}}
<p><b>{{label}}</b> {{name}}: {{state}}{{#tags}} <span class="tag
{{kind}}">{{text}}</span>{{/tags}}</p>
</li>
{{/closeups}}
</ul>
</article>
{{/frames}}
)html";

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
      {"edges", "edge pixels, corners",
       R"(<path class="edges" d="M-5 2h0M-2.5 1h0M0 0h0M2.5 -1h0M5 -2h0"/>)"},
      {"lines", "fitted lines", R"(<path class="lines" d="M-6 4L6 -4"/>)"},
      {"found", "found", R"(<g class="found"><path d="M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0"/></g>)"},
      {"truth", "truth", R"(<g class="truth"><path d="M-4 -4L4 4M-4 4L4 -4"/></g>)"},
      {"removed", "removed as outlier",
       R"(<g class="removed"><path d="M-5 0a5 5 0 1 0 10 0a5 5 0 1 0 -10 0M-5 5L5 -5"/></g>)"},
  };
  for (size_t i = 0; i < study.solvers.size(); ++i) {
    layers.push_back(
        {fmt::format("outline-{}", i), "outline by " + solver_label(study.solvers[i]->name),
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

// Those that had to find out: the oracle is told.
std::vector<std::string> removers_of(const TrialRecord& record, const std::string& feature) {
  std::vector<std::string> solvers;
  for (const EstimateRecord& estimate : record.estimates) {
    const PoseSolver* solver = find_pose_solver(estimate.solver);
    if (solver != nullptr && solver->evaluation_only) continue;
    const auto& removed = estimate.removed;
    if (std::find(removed.begin(), removed.end(), feature) != removed.end()) {
      solvers.push_back(solver_label(estimate.solver));
    }
  }
  return solvers;
}

mustache::data outlines_of(const Study& study, const FrameEvidence& frame) {
  mustache::data list(mustache::data::type::list);
  for (size_t i = 0; i < study.solvers.size(); ++i) {
    const auto found = frame.outlines.find(std::string(study.solvers[i]->name));
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
  for (size_t i = 0; i < record.observations.size(); ++i) {
    const auto& removed = estimate.removed;
    const std::string& feature = record.observations[i].feature;
    if (std::find(removed.begin(), removed.end(), feature) == removed.end()) continue;
    text += (text.empty() ? "" : ", ") + short_name(i);
  }
  return text.empty() ? "–" : text;
}

mustache::data estimates_of(const TrialRecord& record) {
  mustache::data list(mustache::data::type::list);
  for (const EstimateRecord& estimate : record.estimates) {
    list << mustache::object{
        {"solver", solver_label(estimate.solver)},
        {"ok", estimate.is_ok()},
        {"status", words(estimate.status)},
        {"theta", measure(estimate.theta_error_deg)},
        {"t", measure(estimate.t_error_percent)},
        {"reprojection", measure(estimate.reprojection_rms_px)},
        {"removed", removed_names(record, estimate)},
    };
  }
  return list;
}

std::string state(const ObservationRecord& record) {
  if (!record.is_found()) return words(record.status);
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

FeatureDrawings draw_features(const Trial& trial) {
  FeatureDrawings drawings;
  const size_t count = std::min(trial.observations.size(), trial.record.observations.size());
  for (size_t i = 0; i < count; ++i) {
    const Observation& observation = trial.observations[i];
    const ObservationRecord& record = trial.record.observations[i];
    const auto removers = removers_of(trial.record, record.feature);
    const std::string marks = feature_marks(observation, record, removers);
    const std::string label = short_name(i);
    const bool has_window = !observation.window.empty() && !trial.frame.image.empty();
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

mustache::data frame_data(const Study& study, const FrameEvidence& frame, size_t number) {
  const TrialRecord& record = frame.stored;
  const cv::Mat& image = frame.trial.frame.image;
  const std::string id = fmt::format("frame-{}", number);
  const FeatureDrawings drawings = draw_features(frame.trial);
  return mustache::object{
      {"id", id},
      {"caption", frame.caption},
      {"alt",
       fmt::format("{}: the rendered target with windows, features and outlines", frame.caption)},
      {"trial", fmt::to_string(record.trial)},
      {"theta", triple(attitude_deg(record.true_cam_from_target.rotation), 1)},
      {"t", triple(record.true_cam_from_target.translation, 2)},
      {"has_image", !image.empty()},
      {"png", image.empty() ? "" : png_data_url(image, frame.trial.scene.sensor.bits)},
      {"width", fmt::to_string(image.cols)},
      {"height", fmt::to_string(image.rows)},
      {"view", view_box({0, 0, image.cols, image.rows})},
      {"outlines", outlines_of(study, frame)},
      {"marks", drawings.marks},
      {"labels", drawings.labels},
      {"size", fmt::format("{:.1f}", image.cols / kLabelsAcross)},
      {"estimates", estimates_of(record)},
      {"closeups", drawings.closeups},
  };
}

}  // namespace

std::string frames_figure(const ReportInput& input) {
  if (input.frames.empty()) return "";
  mustache::data frames(mustache::data::type::list);
  for (size_t i = 0; i < input.frames.size(); ++i) {
    frames << frame_data(input.study, input.frames[i], i + 1);
  }
  return mustache::mustache(kTemplate).render(
      mustache::object{{"layers", legend(input.study)}, {"frames", frames}});
}

}  // namespace sightline
