// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Callables of Python as solvers and extractors of a study. They are called by way of adapters of
// the package (python/sightline/guests.py), which take bare arrays, give the user's callable a
// question with names, catch what it raises, and bring what it answers into one form.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <pybind11/pybind11.h>

#include "eval/doors/trial_extractor.h"
#include "eval/doors/trial_solver.h"
#include "eval/study/guests.h"

namespace sightline {

/// Names and adapters.
using NamedCallables = std::vector<std::pair<std::string, pybind11::function>>;

Guests guests_from(const NamedCallables& solvers, const NamedCallables& extractors);

}  // namespace sightline
