// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// Text as it may stand between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// JSON as it may stand in a <script> element: no "<", which might end it.
std::string script_json(std::string json);

}  // namespace sightline
