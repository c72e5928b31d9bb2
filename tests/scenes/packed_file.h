// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include <zlib.h>

namespace sightline {

/// Writes a file of these bytes as gzip packs them, and returns it.
inline std::filesystem::path write_packed(const std::filesystem::path& file,
                                          const std::string& bytes) {
  const gzFile stream = gzopen(file.c_str(), "wb");
  gzwrite(stream, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(stream);
  return file;
}

}  // namespace sightline
