// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// [functions]: which guests of a study are functions of whoever ran it. A file cannot hold them, so
// that it at least says who they were.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "eval/study/guests.h"

namespace sightline {
namespace {

template <typename Guest>
bool is_among(const std::vector<Guest>& guests, const std::string& name) {
  return std::any_of(guests.begin(), guests.end(),
                     [&](const Guest& guest) { return guest.name == name; });
}

template <typename Guest>
void add_absent(const TomlTable& functions, const char* key, bool may_be_absent,
                std::vector<Guest>& guests) {
  for (const std::string& name : functions.texts(key, std::vector<std::string>{})) {
    if (is_among(guests, name)) continue;
    if (!may_be_absent) {
      functions.fail(key, fmt::format("holds \"{}\", a function of the program that wrote this "
                                      "file: only that program can run the study",
                                      name));
    }
    guests.push_back({});
    guests.back().name = name;
    guests.back().summary = "a function of the program that ran the study";
  }
}

}  // namespace

Guests with_functions(const TomlTable& study, Guests given) {
  const TomlTable functions = study.table("functions");
  const size_t solvers = given.solvers.size();
  const size_t extractors = given.extractors.size();
  add_absent(functions, "solvers", given.may_be_absent, given.solvers);
  add_absent(functions, "extractors", given.may_be_absent, given.extractors);
  for (size_t i = solvers; i < given.solvers.size(); ++i) {
    given.solvers[i].solve = [](const SolverQuestion&) { return SolverAnswer{}; };
  }
  for (size_t i = extractors; i < given.extractors.size(); ++i) {
    given.extractors[i].extract = [](const ExtractorQuestion&) {
      return ExtractorAnswer{{}, EstimateOutcome::kNoEstimate};
    };
  }
  return given;
}

}  // namespace sightline
