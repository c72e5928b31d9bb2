// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sightline {

/// The CRC-32 of bytes, as zlib, gzip and PNG have it. It tells bytes that were exchanged or
/// damaged, not those that somebody forged.
uint32_t crc32(std::string_view bytes);
/// The same in eight hexadecimal digits.
std::string crc32_text(std::string_view bytes);

}  // namespace sightline
