// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the numbers come from, how to get them again, and what the words mean.
#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/plain_text.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"
#include "eval/report/page_text.h"
#include "eval/report/panels.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

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
                     is_whole ? "" : " --shard " + shell_word(shard->second));
}

}  // namespace

std::string provenance_figure(const ReportInput& input) {
  const auto typed = input.meta.find("command");
  const ImageStudy* const images = input.study.images();
  const OrientationStudy* const orientation = input.study.orientation();
  const PointPairs pairs = orientation == nullptr ? PointPairs{} : orientation->pairs;
  // A folder may come from somebody whose command a reader had better not copy.
  const bool has_typed = typed != input.meta.end() && is_harmless_command(typed->second);
  return mustache::mustache(page_text("provenance.mustache"))
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
