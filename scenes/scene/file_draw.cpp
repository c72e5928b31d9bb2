// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/file_draw.h"

#include <algorithm>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

namespace fs = std::filesystem;

const fs::path& FileDraw::draw(RandomStream& stream) const {
  return files[static_cast<size_t>(stream.uniform() * static_cast<double>(files.size()))];
}

std::string FileDraw::stated(const fs::path& file) const {
  return (fs::path(given) / file.filename()).string();
}

void FileDraw::fail(const fs::path& file, std::string_view problem) const {
  throw InputError(
      fmt::format("{} is \"{}\", whose {} {}", key, given, file.filename().string(), problem));
}

fs::path named_path(const TomlTable& table, std::string_view given) {
  const fs::path beside = table.file().parent_path() / given;
  std::error_code error;  // a name too long is one of no file
  return fs::exists(beside, error) ? beside : fs::path(given);
}

FileDraw files_of(const TomlTable& table, const std::string& table_name, std::string_view key,
                  const fs::path& found, const std::string& given,
                  const std::function<bool(const fs::path&)>& is_one, std::string_view kind) {
  FileDraw draw{.key = fmt::format("{}: {}.{}", table.file().string(), table_name, key),
                .given = given,
                .files = {}};
  std::error_code error;
  for (auto entry = fs::directory_iterator(found, error); !error && entry != fs::end(entry);
       entry.increment(error)) {
    std::error_code of_entry;
    if (entry->is_regular_file(of_entry) && is_one(entry->path())) {
      draw.files.push_back(entry->path());
    }
  }
  if (draw.files.empty()) {
    table.fail(key, fmt::format("is \"{}\", a folder without {}", given, kind));
  }
  std::sort(draw.files.begin(), draw.files.end());
  return draw;
}

}  // namespace sightline
