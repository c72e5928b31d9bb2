// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "eval/doors/external_process.h"
#include "eval/doors/trial_solver.h"

namespace sightline {

/// A solver that a process is. What fails is a status of its answer, with the reason in the
/// process's log. Throws InputError for a command without words.
TrialSolver external_solver(const ProcessSource& source);

}  // namespace sightline
