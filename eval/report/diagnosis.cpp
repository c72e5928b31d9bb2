// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the solvers themselves say of their poses, and how right they are: an estimate that is said
// to be doubtful should be wrong more often than the others, and sets that are said to be right
// with a probability should be right that often.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"
#include "eval/report/page_text.h"
#include "eval/report/panels.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

// A question that a solver may answer about its pose.
struct Doubt {
  const char* said;
  std::optional<bool> EstimateRecord::*answer;
};

constexpr std::array kDoubts = {
    Doubt{"another pose fits nearly as well", &EstimateRecord::is_ambiguous},
    Doubt{"no more points could be removed", &EstimateRecord::is_removal_limit_reached},
    Doubt{"what is kept is no noise", &EstimateRecord::is_test_failed},
};

// The probabilities that are put together: from each to the next.
constexpr std::array kProbabilities = {0.0, 0.5, 0.9, 0.99, 1.0};

std::vector<const EstimateRecord*> poses_of(std::span<const TrialRecord> trials,
                                            const std::string& solver) {
  std::vector<const EstimateRecord*> poses;
  for (const TrialRecord& trial : trials) {
    const EstimateRecord* const estimate = find_estimate(trial, solver);
    if (estimate != nullptr && estimate->is_ok()) poses.push_back(estimate);
  }
  return poses;
}

// The geodesic error above which a pose is called wrong.
double limit_deg(const std::vector<const EstimateRecord*>& poses) {
  constexpr double kQuantile = 0.9;
  std::vector<double> errors_deg;
  for (const EstimateRecord* pose : poses) errors_deg.push_back(pose->geodesic_deg);
  return errors_deg.empty() ? std::numeric_limits<double>::infinity()
                            : percentile(errors_deg, kQuantile);
}

// How many of some poses are wrong.
struct WrongCount {
  int64_t all = 0;
  int64_t wrong = 0;
};

// A solver's answers to one question; nothing where it never gave any.
std::optional<mustache::data> doubt_row(const std::string& solver, const Doubt& doubt,
                                        const std::vector<const EstimateRecord*>& poses) {
  const double most_deg = limit_deg(poses);
  WrongCount doubted, others;
  for (const EstimateRecord* pose : poses) {
    const std::optional<bool>& answer = pose->*doubt.answer;
    if (!answer) continue;
    WrongCount& count = *answer ? doubted : others;
    ++count.all;
    count.wrong += !pose->is_set_exact() || pose->geodesic_deg > most_deg;
  }
  const int64_t judged = doubted.all + others.all;
  if (judged == 0) return std::nullopt;
  return mustache::object{{"solver", solver},
                          {"said", doubt.said},
                          {"judged", fmt::to_string(judged)},
                          {"doubted", count_of(doubted.all, judged)},
                          {"wrong_doubted", count_of(doubted.wrong, doubted.all)},
                          {"wrong_others", count_of(others.wrong, others.all)}};
}

// The sets to which a solver gave a probability from `low` to below `high` (up to 1, where that is
// the end); nothing where there are none.
std::optional<mustache::data> probability_row(const std::string& solver, double low, double high,
                                              const std::vector<const EstimateRecord*>& poses) {
  int64_t count = 0, exact = 0;
  double sum = 0;
  for (const EstimateRecord* pose : poses) {
    const std::optional<double>& stated = pose->removed_probability;
    if (!stated || *stated < low || (*stated >= high && high < 1)) continue;
    ++count;
    sum += *stated;
    exact += pose->is_set_exact();
  }
  if (count == 0) return std::nullopt;
  const double mean_percent = 100 * sum / static_cast<double>(count);
  return mustache::object{{"solver", solver},
                          {"range", fmt::format("{:g} to {:g}", 100 * low, 100 * high)},
                          {"poses", fmt::to_string(count)},
                          {"stated", fmt::format("{:.1f} %", mean_percent)},
                          {"exact", count_of(exact, count)}};
}

}  // namespace

std::string diagnosis_figure(const ReportInput& input) {
  mustache::data doubts(mustache::data::type::list);
  mustache::data probabilities(mustache::data::type::list);
  for (const std::string& name : input.study.solver_names()) {
    const std::string solver = label_in(input.study, name);
    const std::vector<const EstimateRecord*> poses = poses_of(input.trials, name);
    for (const Doubt& doubt : kDoubts) {
      if (const auto row = doubt_row(solver, doubt, poses)) doubts << *row;
    }
    for (size_t i = 0; i + 1 < kProbabilities.size(); ++i) {
      const auto row = probability_row(solver, kProbabilities[i], kProbabilities[i + 1], poses);
      if (row) probabilities << *row;
    }
  }
  if (doubts.is_empty_list()) return "";
  return mustache::mustache(page_text("diagnosis.mustache"))
      .render(mustache::object{{"doubts", doubts},
                               {"has_probabilities", probabilities.is_non_empty_list()},
                               {"probabilities", probabilities}});
}

}  // namespace sightline
