// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// [[estimates]], [[observations]], [[external.solver]], [[external.extractor]] and the array
// `extractors`.
#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "eval/doors/estimate_file.h"
#include "eval/doors/external_extractor.h"
#include "eval/doors/external_solver.h"
#include "eval/study/guests.h"
#include "eval/study/study_keys.h"
#include "features/extractor.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// Guests stand in tables, labels and options beside the program's own, so that their names must be
// as plain, and no other's.
void require_new_name(const TomlTable& table, const std::string& name,
                      const std::vector<std::string>& taken) {
  require_plain_name(table, name);
  if (std::find(taken.begin(), taken.end(), name) != taken.end()) {
    table.fail("name", fmt::format("is \"{}\", which is another's name already", name));
  }
}

template <typename Source>
Source read_source(const TomlTable& table) {
  Source source;
  for (const Key& key : keys_of(source)) read_key(table, key);
  return source;
}

// Makes a guest of a process; nothing is started.
template <typename Source, typename Make>
auto read_process(const TomlTable& table, const Source& source, const Make& make) {
  try {
    return make(source);
  } catch (const InputError& error) {
    table.fail("command", error.what());
  }
}

}  // namespace

std::vector<TrialSolver> read_guest_solvers(const TomlTable& study, const SightedSet* set,
                                            std::vector<TrialSolver> given) {
  std::vector<std::string> taken = names_of(pose_solvers());
  for (const TrialSolver& solver : given) taken.push_back(solver.name);
  std::vector<TrialSolver> solvers;
  for (const TomlTable& table : study.tables("estimates")) {
    const auto source = read_source<EstimateSource>(table);
    require_new_name(table, source.name, taken);
    taken.push_back(source.name);
    try {
      solvers.push_back(recorded_solver(source, set));
    } catch (const InputError& error) {
      throw InputError(fmt::format("estimates {}: {}", source.name, error.what()));
    }
  }
  for (const TomlTable& table : study.table("external").tables("solver")) {
    const auto source = read_source<ProcessSource>(table);
    require_new_name(table, source.name, taken);
    taken.push_back(source.name);
    solvers.push_back(read_process(table, source, external_solver));
  }
  std::move(given.begin(), given.end(), std::back_inserter(solvers));
  return solvers;
}

GuestExtractors::GuestExtractors(const TomlTable& study, const std::vector<TrialExtractor>& given) {
  std::vector<std::string> taken = names_of(feature_extractors());
  taken.emplace_back(kExtractorsByKind);
  for (const TrialExtractor& extractor : given) {
    names_.push_back(extractor.name);
    ready_[extractor.name] = std::make_shared<const TrialExtractor>(extractor);
    taken.push_back(extractor.name);
  }
  for (const TomlTable& table : study.tables("observations")) {
    auto source = read_source<ObservationSource>(table);
    require_new_name(table, source.name, taken);
    taken.push_back(source.name);
    names_.push_back(source.name);
    sources_.push_back(std::move(source));
  }
  for (const TomlTable& table : study.table("external").tables("extractor")) {
    const auto source = read_source<ExtractorProcessSource>(table);
    require_new_name(table, source.name, taken);
    taken.push_back(source.name);
    names_.push_back(source.name);
    ready_[source.name] =
        std::make_shared<const TrialExtractor>(read_process(table, source, external_extractor));
  }
}

std::shared_ptr<const TrialExtractor> GuestExtractors::find(
    const std::string& name, const std::function<ShownPictures()>& pictures) {
  if (const auto ready = ready_.find(name); ready != ready_.end()) return ready->second;
  for (const ObservationSource& source : sources_) {
    if (source.name != name) continue;
    return ready_[name] =
               std::make_shared<const TrialExtractor>(recorded_extractor(source, pictures()));
  }
  return nullptr;
}

std::vector<std::string> read_extractor_names(const TomlTable& study,
                                              const GuestExtractors& guests) {
  std::vector<std::string> fallback = guests.names();
  if (fallback.empty()) fallback = {kExtractorsByKind};
  const std::vector<std::string> names = study.texts("extractors", fallback);
  if (names.empty()) study.fail("extractors", "is empty, must name at least one");
  std::vector<std::string> known = {kExtractorsByKind};
  for (const auto& own : names_of(feature_extractors())) known.push_back(own);
  known.insert(known.end(), guests.names().begin(), guests.names().end());
  std::set<std::string> seen;
  for (const std::string& name : names) {
    index_of(name, known, study, "extractors");
    if (!seen.insert(name).second) {
      study.fail("extractors", fmt::format("holds \"{}\" twice", name));
    }
  }
  return names;
}

}  // namespace sightline
