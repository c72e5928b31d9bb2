// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/checksum.h"

#include <fmt/format.h>
#include <isa-l/crc.h>

namespace sightline {

uint32_t crc32(std::string_view bytes) {
  return crc32_gzip_refl(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

std::string crc32_text(std::string_view bytes) {
  return fmt::format("{:08x}", crc32(bytes));
}

}  // namespace sightline
