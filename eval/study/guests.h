// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Guests: solvers and extractors that are not of this program (eval/doors/), and how a study's file
// names them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/datasets/sightings.h"
#include "eval/doors/observation_file.h"
#include "eval/doors/shown_pictures.h"
#include "eval/doors/trial_extractor.h"
#include "eval/doors/trial_solver.h"
#include "scenes/files/toml_table.h"

namespace sightline {

/// What whoever embeds this program adds to what a study's file names: functions of its own. The
/// file may name them in `solvers` and `extractors` as it names the program's.
struct Guests {
  std::vector<TrialSolver> solvers;
  std::vector<TrialExtractor> extractors;
  /// Whether functions that the file names may be absent, for what they gave is there already:
  /// others stand in for them, which answer nothing.
  bool may_be_absent = false;
};

/// The word for the extractors that [extraction] names, one for each kind of feature.
inline constexpr const char* kExtractorsByKind = "by_kind";

/// The guests that are given and, where they may be absent, stand-ins for those of [functions] that
/// are not. Throws InputError for a name of [functions] that is nobody's.
Guests with_functions(const TomlTable& study, Guests given);

/// The solvers of [[estimates]] and [[external.solver]], then those that are `given`. `set` is the
/// data set that the trials show, null where they are rendered or numeric. Throws InputError for a
/// name that another solver has.
std::vector<TrialSolver> read_guest_solvers(const TomlTable& study, const SightedSet* set,
                                            std::vector<TrialSolver> given);

/// The extractors of [[observations]] and [[external.extractor]], and those that are given.
class GuestExtractors {
 public:
  /// Throws InputError for a name that another extractor has.
  GuestExtractors(const TomlTable& study, const std::vector<TrialExtractor>& given);

  bool are_files_among() const { return !sources_.empty(); }
  const std::vector<std::string>& names() const { return names_; }
  /// The extractor of that name; null where no guest has the name. Its file, which is about these
  /// pictures, is read when it is first asked for. Throws InputError for what is wrong in it.
  std::shared_ptr<const TrialExtractor> find(const std::string& name,
                                             const std::function<ShownPictures()>& pictures);

 private:
  std::vector<std::string> names_;
  std::vector<ObservationSource> sources_;
  std::map<std::string, std::shared_ptr<const TrialExtractor>> ready_;
};

/// The extractors that the study asks, each in cells of its own: the array `extractors`; without
/// it the guests, and without guests kExtractorsByKind.
std::vector<std::string> read_extractor_names(const TomlTable& study,
                                              const GuestExtractors& guests);

}  // namespace sightline
