// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The study's question and its answer in sentences, every number with its interval.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/page_text.h"
#include "eval/statistics/bootstrap.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

std::string opening(const ReportInput& input) {
  const auto trials = trials_of(input.summary);
  const size_t conditions = input.study.conditions.size();
  if (conditions < 2) return fmt::format("Over {}:", counted(trials, "trial"));
  const auto run = static_cast<size_t>(conditions_with_trials(input.summary));
  return fmt::format(
      "Over {} in {} conditions, each weighing the same:", counted(trials, "trial"),
      run == conditions ? fmt::to_string(run) : fmt::format("{} of the {}", run, conditions));
}

// "24 of 80 trials without a pose (too few points)".
std::string failures(std::span<const TrialRecord> trials, const SolverMeans& means) {
  std::set<std::string> reasons;
  for (const TrialRecord& trial : trials) {
    const EstimateRecord* estimate = find_estimate(trial, means.solver);
    if (estimate != nullptr && !estimate->is_ok())
      reasons.insert(words(to_string(estimate->status)));
  }
  const std::string why = reasons.empty() ? "" : fmt::format(" ({})", fmt::join(reasons, ", "));
  return fmt::format("{} of {} without a pose{}", means.failures, counted(means.trials, "trial"),
                     why);
}

mustache::data solver_line(const ReportInput& input, const TrialSolver& solver) {
  const SolverMeans means = means_over_conditions(input.study, input.summary, solver.name);
  const Measured& theta = means.theta_error_deg;
  const Measured& t = means.t_error_percent;
  const PaperFigure paper = means.paper.value_or(PaperFigure{});
  return mustache::object{
      {"solver", solver_label(solver.name)},
      {"evaluation_only", solver.evaluation_only},
      {"summary", solver.summary},
      {"theta", measure(theta.value)},
      {"theta_interval", interval(theta.ci95, decimals_for(theta.value))},
      {"t", measure(t.value)},
      {"t_interval", interval(t.ci95, decimals_for(t.value))},
      {"has_failures", means.failures > 0},
      {"failures", failures(input.trials, means)},
      {"has_paper", means.paper.has_value()},
      {"paper_words",
       input.study.conditions.size() > 1 ? "The paper’s figures average" : "The paper prints"},
      {"paper_theta", fixed(paper.theta_error_deg, 2)},
      {"paper_t", fixed(paper.t_error_percent, 1)},
  };
}

double capped_theta_deg(const TrialRecord& trial, std::string_view solver) {
  const EstimateRecord* estimate = find_estimate(trial, solver);
  if (estimate == nullptr) return std::numeric_limits<double>::quiet_NaN();
  // Not std::min alone: a NaN must count as the cap.
  const bool is_below = estimate->is_ok() && estimate->theta_error_deg < kAngleCapDeg;
  return is_below ? estimate->theta_error_deg : kAngleCapDeg;
}

// The same trials through both solvers, so that what the images have in common cancels.
std::vector<double> paired_differences_deg(std::span<const TrialRecord> trials,
                                           std::string_view lead, std::string_view other) {
  std::vector<double> differences;
  for (const TrialRecord& trial : trials) {
    const double difference = capped_theta_deg(trial, lead) - capped_theta_deg(trial, other);
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  return differences;
}

// What two sides of the same trials differ by, in a sentence; empty where there are too few. `draw`
// names the random numbers of the interval.
std::string difference_sentence(const ReportInput& input, const std::vector<double>& differences,
                                const std::string& draw, const std::string& first,
                                const std::string& second) {
  if (differences.size() < 2) return "";
  double mean = 0;
  for (const double difference : differences) {
    mean += difference / static_cast<double>(differences.size());
  }
  const auto ci95 = bca_mean_interval(differences, input.study.seed, draw);
  const bool is_clear = ci95[0] > 0 || ci95[1] < 0;
  if (!is_clear) {
    return fmt::format(
        "Trial by trial, these images do not tell the θ errors of {} and {} apart: they differ by "
        "{}° {} in the mean.",
        first, second, measure(mean), interval(ci95, decimals_for(mean)));
  }
  const std::array<double, 2> size = {std::min(std::abs(ci95[0]), std::abs(ci95[1])),
                                      std::max(std::abs(ci95[0]), std::abs(ci95[1]))};
  return fmt::format("Trial by trial, the θ error of {} is {}° {} {} than that of {} in the mean.",
                     first, measure(std::abs(mean)), interval(size, decimals_for(mean)),
                     mean < 0 ? "smaller" : "greater", second);
}

std::string comparison(const ReportInput& input, std::string_view lead, std::string_view other) {
  return difference_sentence(input, paired_differences_deg(input.trials, lead, other),
                             fmt::format("report/answer/{}-{}", lead, other), solver_label(lead),
                             solver_label(other));
}

// Two conditions that differ in who finds the features alone, so that their trials show the same
// pictures.
struct ExtractorPair {
  int first;
  int second;
};

// The first extractor of the study against each of the others, wherever all else is the same.
std::vector<ExtractorPair> extractor_pairs(const Study& study) {
  constexpr const char* kExtractor = "extractor";
  std::vector<ExtractorPair> pairs;
  const auto rest_of = [&](int index) {
    auto words = study.conditions[static_cast<size_t>(index)].words;
    words.erase(kExtractor);
    return std::pair(std::move(words), study.conditions[static_cast<size_t>(index)].values);
  };
  const int count = static_cast<int>(study.conditions.size());
  for (int second = 0; second < count; ++second) {
    if (!study.conditions[static_cast<size_t>(second)].words.contains(kExtractor)) continue;
    for (int first = 0; first < second; ++first) {
      if (rest_of(first) != rest_of(second)) continue;
      pairs.push_back({first, second});
      break;
    }
  }
  return pairs;
}

// The same draws through both, by one solver.
std::vector<double> paired_differences_deg(std::span<const TrialRecord> trials,
                                           std::string_view solver, const ExtractorPair& pair) {
  std::map<int64_t, double> of_first;
  for (const TrialRecord& trial : trials) {
    if (trial.condition == pair.first) of_first[trial.trial] = capped_theta_deg(trial, solver);
  }
  std::vector<double> differences;
  for (const TrialRecord& trial : trials) {
    if (trial.condition != pair.second) continue;
    const auto found = of_first.find(trial.trial - pair.second + pair.first);
    if (found == of_first.end()) continue;
    const double difference = found->second - capped_theta_deg(trial, solver);
    if (!std::isnan(difference)) differences.push_back(difference);
  }
  return differences;
}

std::string comparison(const ReportInput& input, std::string_view solver,
                       const ExtractorPair& pair) {
  const auto label = [&](int condition) {
    return fmt::format("{} with {}", solver_label(solver),
                       input.study.conditions[static_cast<size_t>(condition)].label);
  };
  return difference_sentence(input, paired_differences_deg(input.trials, solver, pair),
                             fmt::format("report/answer/{}/{}-{}", solver, pair.first, pair.second),
                             label(pair.first), label(pair.second));
}

// The least error that an unbiased estimator can have, and where that noise was found.
std::string bound_sentence(const Summary& summary) {
  const double theta = mean_over_conditions(summary, &CellObservations::bound_theta_deg);
  const double t = mean_over_conditions(summary, &CellObservations::bound_t_percent);
  if (!(theta > 0)) return "";
  return fmt::format(
      "The Cramér–Rao bound of the true inliers, with the noise that they show, is {}° and {} % in "
      "the mean.",
      measure(theta), measure(t));
}

mustache::data comparisons(const ReportInput& input) {
  mustache::data sentences(mustache::data::type::list);
  const std::string lead = lead_solver(input.study);
  for (const TrialSolver& other : input.study.solvers()) {
    if (other.evaluation_only || other.name == lead) continue;
    const std::string sentence = comparison(input, lead, other.name);
    if (!sentence.empty()) sentences << sentence;
  }
  for (const ExtractorPair& pair : extractor_pairs(input.study)) {
    const std::string sentence = comparison(input, lead, pair);
    if (!sentence.empty()) sentences << sentence;
  }
  const std::string bound = bound_sentence(input.summary);
  if (!bound.empty()) sentences << bound;
  return sentences;
}

}  // namespace

std::string answer_figure(const ReportInput& input) {
  if (input.study.images() == nullptr) return sweep_answer(input);
  mustache::data solvers(mustache::data::type::list);
  for (const TrialSolver& solver : input.study.solvers()) {
    solvers << solver_line(input, solver);
  }
  return mustache::mustache(page_text("answer.mustache"))
      .render(mustache::object{
          {"has_question", !input.study.question.empty()},
          {"question", input.study.question},
          {"opening", opening(input)},
          {"solvers", solvers},
          {"comparisons", comparisons(input)},
          {"angle_cap", fmt::to_string(kAngleCapDeg)},
          {"t_cap", fmt::to_string(kTranslationCapPercent)},
      });
}

}  // namespace sightline
