// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the numbers come from, how to get them again, and what the words mean.
#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/text.h"
#include "eval/report/figures.h"
#include "eval/report/panels.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr const char* kProvenanceTemplate = R"html(
<h3>This run</h3>
<dl class="facts">
{{#facts}}<dt>{{key}}</dt><dd>{{value}}</dd>
{{/facts}}
</dl>
<h3>To repeat it</h3>
<pre><code>{{repeat}}</code></pre>
<p>Run this in the folder of the report, where study.toml is the study as it was run, with all that
options changed.{{#has_typed}} What was typed: <code>{{typed}}</code>{{/has_typed}}</p>
<p>Every trial depends on the study, the seed and its own number alone, so that the number of
processes and of shards does not matter. On one machine results.csv and summary.json repeat byte
for byte{{#rendered}}; on
another type of processor the images may differ in the last grey level{{/rendered}}.{{#timed}} Times do
not repeat: they stand in timings.csv alone.{{/timed}}</p>
<h3>Conventions</h3>
<ul>
{{^orientation}}<li>Camera: <i>x</i> right, <i>y</i> down, <i>z</i> forward. Pixel centres lie at integer
coordinates: (0, 0)
is the centre of the top-left pixel.</li>
<li>A pose takes points of the target to the camera: x<sub>cam</sub> = R x<sub>target</sub> + T,
metres.</li>{{/orientation}}
{{#orientation}}<li>A pose takes points of one frame to the other: x<sub>b</sub> = R x<sub>a</sub> +
T.</li>{{/orientation}}
<li>Attitude <i>θ</i> = (pitch, yaw, roll) about <i>x</i>, <i>y</i>, <i>z</i>:
R = R<sub>z</sub>(roll) R<sub>y</sub>(yaw) R<sub>x</sub>(pitch), degrees. The ORPE paper prints no
order; this
one is ours.</li>
</ul>
<h3>Definitions</h3>
<ul>
<li><i>θ</i> error: root mean square of the three attitude angles’ errors, as the ORPE paper
defines it.
Near yaw = ±90° it is meaningless; the geodesic angle is not.</li>
<li><i>T</i> error: root mean square of the three components of the translation’s error, over the
imaging
distance |T|, as the ORPE paper defines it.</li>
<li>Geodesic error: the angle of the one rotation that takes the estimated attitude to the true
one.</li>
{{#orientation}}
<li>Error of an Euler angle: the mean of the three attitude angles’ absolute errors, each wrapped to
±180°. The absolute-orientation paper plots one angle and does not say which.</li>
<li>A trial is one draw of points, rotation and translation. Its errors are means over its {{copies}}
noisy copies, each capped at {{angle_cap}}° and {{t_cap}} %, a copy without a rotation counting as the
cap; means and intervals are over the draws.</li>
{{#timed}}<li>Time of a solve: wall time of {{repeats}} solves of a draw’s first copy, over their
number.</li>{{/timed}}
{{/orientation}}
{{^orientation}}
<li>Reprojection RMS: of the features a solver kept, from where its pose projects them.</li>
{{#images}}<li>Outlier: a feature found farther than {{outlier_px}} px from where it truly is. Solvers are not
told
(the oracle is, which is why it serves for evaluation only).</li>{{/images}}
{{^images}}<li>Outlier: a point that the study displaced, by whatever distance. Solvers are not told
(the oracle is, which is why it serves for evaluation only).</li>{{/images}}
<li>Cramér–Rao bound: the least RMS error an unbiased estimator can have on the true inliers of a
trial, {{#images}}each feature with the noise that its inliers show in the same row{{/images}}{{^images}}with the noise
applied; none without noise{{/images}}; capped as errors are.</li>
<li>RMS over oracle’s: on the trials in which the oracle has a pose. RMS over bound: on the trials
that have a bound.</li>
<li>Failures never leave the denominator: means and RMS run over all trials with each error capped
at
{{angle_cap}}° and {{t_cap}} %, a failed trial counting as the cap; medians and percentiles count
it as infinite.</li>{{/orientation}}
<li>Intervals: 95 %, of the mean, by the bias-corrected and accelerated bootstrap, beyond 500
trials by its analytic form (ABC). {{#images}}The mean over
conditions adds
their half-widths as squares.{{/images}}</li>
</ul>
<h3>The study as it was run</h3>
<details>
<summary>study.toml</summary>
<pre><code>{{toml}}</code></pre>
</details>
)html";

// First what a reader asks first; whatever else the manifest holds comes after.
constexpr const char* kFirstKeys[] = {"version", "seed", "machine"};

void add_fact(mustache::data& facts, const std::string& key, const std::string& value) {
  facts << mustache::object{{"key", key}, {"value", value}};
}

int64_t redraws(std::span<const TrialRecord> trials) {
  int64_t sum = 0;
  for (const TrialRecord& trial : trials) sum += trial.redraws;
  return sum;
}

mustache::data facts_of(const ReportInput& input) {
  mustache::data facts(mustache::data::type::list);
  std::map<std::string, std::string> rest = input.meta;
  rest["seed"] = fmt::to_string(input.study.seed);
  add_fact(facts, "study", input.study.name);
  for (const char* key : kFirstKeys) {
    const auto found = rest.find(key);
    if (found == rest.end()) continue;
    add_fact(facts, key, found->second);
    rest.erase(found);
  }
  // Stated from the study itself, and where it says how to repeat the run.
  for (const char* key : {"study", "trials", "command"}) rest.erase(key);
  add_fact(facts, "trials", fmt::to_string(input.trials.size()));
  if (input.study.renders()) {
    add_fact(facts, "poses drawn anew", fmt::to_string(redraws(input.trials)));
  }
  for (const auto& [key, value] : rest) add_fact(facts, words(key), value);
  return facts;
}

std::string repeat_command(const ReportInput& input) {
  const auto shard = input.meta.find("shard");
  const bool is_whole = shard == input.meta.end() || shard->second.ends_with("/1") ||
                        shard->second.find('/') == std::string::npos;  // "merged from 4"
  return fmt::format("sightline study study.toml{} --out again",
                     is_whole ? "" : " --shard " + shard->second);
}

}  // namespace

std::string provenance_figure(const ReportInput& input) {
  const auto typed = input.meta.find("command");
  const ImageStudy* const images = input.study.images();
  const OrientationStudy* const orientation = input.study.orientation();
  const PointPairs pairs = orientation == nullptr ? PointPairs{} : orientation->pairs;
  const bool has_typed = typed != input.meta.end();
  return mustache::mustache(kProvenanceTemplate)
      .render(mustache::object{
          {"facts", facts_of(input)},
          {"repeat", repeat_command(input)},
          {"has_typed", has_typed},
          {"typed", has_typed ? typed->second : ""},
          {"outlier_px", images == nullptr ? "0" : outlier_limit_px(*images)},
          {"rendered", input.study.renders()},
          {"images", images != nullptr},
          {"orientation", orientation != nullptr},
          {"timed", input.study.takes_times()},
          {"repeats", fmt::to_string(pairs.timed_repeats)},
          {"copies", fmt::to_string(pairs.copies)},
          {"angle_cap", fmt::to_string(kAngleCapDeg)},
          {"t_cap", fmt::to_string(kTranslationCapPercent)},
          {"toml", input.study.toml},
      });
}

}  // namespace sightline
