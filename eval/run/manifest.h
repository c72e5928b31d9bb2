// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// manifest.json: how, where and when a run was made.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "eval/study/study.h"

namespace sightline {

/// What a run of the study has in its manifest from its beginning; `command` is the line as typed.
nlohmann::json manifest_of(const Study& study, const std::string& command);

/// The manifest in a run's folder; a discarded value where it cannot be read, or is a link out of
/// the folder: a report shows all that it holds.
nlohmann::json read_manifest(const std::filesystem::path& run);

void write_manifest(const nlohmann::json& manifest, const std::filesystem::path& run);

/// A manifest as the report shows it.
std::map<std::string, std::string> as_texts(const nlohmann::json& manifest);

}  // namespace sightline
