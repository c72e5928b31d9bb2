// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output_folder.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
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

// The topmost folder on the way to `folder` that does not exist yet; empty if all do.
fs::path first_missing(const fs::path& folder) {
  fs::path missing;
  for (fs::path at = folder; !fs::exists(at) && at.has_relative_path(); at = at.parent_path()) {
    missing = at;
  }
  return missing;
}

// What runs that were killed left beside this folder: their processes are gone.
void sweep_stale(const fs::path& parent, const std::string& prefix) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(parent, error)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(prefix)) continue;
    const pid_t process = std::atoi(name.c_str() + prefix.size());
    if (process > 0 && kill(process, 0) != 0 && errno == ESRCH) fs::remove_all(entry.path(), error);
  }
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder)
    : folder_(fs::weakly_canonical(fs::absolute(folder))) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();  // "results/x/"
  require_free(folder_);
  std::error_code error;
  if (fs::equivalent(folder_, fs::current_path(error), error)) {
    throw InputError(
        fmt::format("--out {}: is the current folder; name a new one in it", folder.string()));
  }
  const std::string prefix = fmt::format(".{}.partial-", folder_.filename().string());
  sweep_stale(folder_.parent_path(), prefix);
  made_parent_ = first_missing(folder_.parent_path());
  staging_ = folder_.parent_path() / fmt::format("{}{}", prefix, getpid());
  fs::create_directories(staging_, error);
  if (error || access(staging_.c_str(), W_OK) != 0) {
    const std::string reason = error ? error.message() : "permission denied";
    remove_all();
    throw InputError(fmt::format("--out {}: cannot be written ({})", folder.string(), reason));
  }
}

OutputFolder::~OutputFolder() {
  if (!is_committed_) remove_all();
}

void OutputFolder::remove_all() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  if (made_parent_.empty()) return;
  // Only what is empty: another run may have put something there.
  for (fs::path at = staging_.parent_path();; at = at.parent_path()) {
    if (!fs::remove(at, ignored) || at == made_parent_) return;
  }
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
