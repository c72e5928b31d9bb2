// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output_folder.h"

#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "scenes/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

void require_free(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!fs::is_directory(folder, error)) {
    throw InputError(fmt::format("--out {}: exists and is not a folder", folder.string()));
  }
  if (!fs::is_empty(folder, error) || error) {
    throw InputError(fmt::format(
        "--out {}: exists and is not empty; remove it or name another folder", folder.string()));
  }
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder) : folder_(fs::absolute(folder)) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();  // "results/x/"
  require_free(folder_);
  staging_ =
      folder_.parent_path() / fmt::format(".{}.partial-{}", folder_.filename().string(), getpid());
  std::error_code error;
  fs::create_directories(staging_, error);
  if (error || access(staging_.c_str(), W_OK) != 0) {
    throw InputError(fmt::format("--out {}: cannot be written ({})", folder.string(),
                                 error ? error.message() : "permission denied"));
  }
}

OutputFolder::~OutputFolder() {
  if (is_committed_) return;
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
}

void OutputFolder::commit() {
  std::error_code error;
  require_free(folder_);
  fs::rename(staging_, folder_, error);  // over an empty folder as well
  if (error) {
    throw InputError(
        fmt::format("--out {}: cannot be written ({})", folder_.string(), error.message()));
  }
  is_committed_ = true;
}

void write_file(const fs::path& file, std::string_view text) {
  const fs::path partial = file.string() + ".partial";
  std::ofstream out(partial, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) fs::rename(partial, file, error);
  if (!out || error) {
    fs::remove(partial, error);
    throw InputError(fmt::format("{}: cannot be written", file.string()));
  }
}

}  // namespace sightline
