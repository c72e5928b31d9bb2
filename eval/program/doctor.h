// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// What this program stands on, as text for a terminal: its version, libraries and folders, the
/// ways to OpenGL and who draws by default, and the shard that the environment names. With
/// `measures_renderer` also how far edges and vertices lie from their places with every number of
/// samples, beside what is promised, and what a frame costs. Nothing that is missing is an error.
std::string doctor(bool measures_renderer);

/// The libraries that the program is made of, each with its package and licence (by SPDX).
std::string library_licences();

/// The same two as JSON.
std::string doctor_json(bool measures_renderer);
std::string licences_json();

}  // namespace sightline
