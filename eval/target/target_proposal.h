// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "eval/target/target_report.h"
#include "scenes/target/target.h"

namespace sightline {

/// Writes a target that any study can use from a mesh alone: target.toml with the features of
/// `propose_features`, the mesh as mesh.glb, and a picture of where they lie. Returns what to tell
/// the user. Throws InputError when the mesh has nothing to propose, the folder holds a target.toml
/// already (it may have been edited) or a file cannot be written.
TargetReport propose_target(const std::shared_ptr<const Target>& target,
                           const TargetArguments& arguments);

}  // namespace sightline
