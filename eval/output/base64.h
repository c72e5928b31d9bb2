// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// The bytes as letters and digits (RFC 4648), padded with "=".
std::string base64(std::string_view bytes);

}  // namespace sightline
