// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/output_folder.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <ostream>
#include <system_error>
#include <thread>

#include <ext/stdio_filebuf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "eval/output/output_error.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLockFile = ".lock";

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

// The folder by its whole name, whatever of it exists.
fs::path whole_name(const fs::path& folder) {
  if (folder.empty()) throw InputError("--out: is empty, must name a folder");
  return fs::weakly_canonical(fs::absolute(folder));
}

// The topmost folder on the way to `folder` that does not exist yet; empty if all do.
fs::path first_missing(const fs::path& folder) {
  fs::path missing;
  for (fs::path at = folder; !fs::exists(at) && at.has_relative_path(); at = at.parent_path()) {
    missing = at;
  }
  return missing;
}

[[noreturn]] void throw_unwritable(const fs::path& asked, const std::string& reason) {
  throw InputError(fmt::format("--out {}: cannot be written ({})", asked.string(), reason));
}

// Whether the path still leads to the open file: another process may have taken it away.
bool is_still_at(int file, const fs::path& path) {
  struct stat of_file {};
  struct stat of_path {};
  return fstat(file, &of_file) == 0 && stat(path.c_str(), &of_path) == 0 &&
         of_file.st_dev == of_path.st_dev && of_file.st_ino == of_path.st_ino;
}

// A folder of the staging's name that another program or a user has made is not touched: ours has a
// lock file, or nothing at all where we have just begun, and is no link.
void require_ours(const fs::path& staging, const fs::path& asked) {
  std::error_code error;
  const fs::file_status there = fs::symlink_status(staging, error);
  if (there.type() == fs::file_type::not_found) return;
  const bool is_folder = there.type() == fs::file_type::directory;
  const bool has_lock =
      is_folder && fs::symlink_status(staging / kLockFile, error).type() == fs::file_type::regular;
  if (has_lock || (is_folder && fs::is_empty(staging, error))) return;
  throw InputError(fmt::format("--out {}: needs the place of {}, which is not ours; move it away",
                               asked.string(), staging.string()));
}

// Makes the folder where it is not there, and locks it; returns the open file that holds the lock.
// The workers of a process that has just been killed may take a moment to end.
int lock_folder(const fs::path& staging, const fs::path& asked) {
  constexpr int kTries = 20;
  constexpr auto kPause = std::chrono::milliseconds(50);
  const fs::path path = staging / kLockFile;
  require_ours(staging, asked);
  for (int i = 0; i < kTries; ++i) {
    if (i > 0) std::this_thread::sleep_for(kPause);
    std::error_code error;
    fs::create_directories(staging, error);
    if (error) throw_unwritable(asked, error.message());
    const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0 && errno == ENOENT) continue;  // the folder has taken its name
    if (file < 0) throw_unwritable(asked, std::strerror(errno));
    const bool is_locked = flock(file, LOCK_EX | LOCK_NB) == 0;
    const int reason = errno;
    if (is_locked && is_still_at(file, path)) return file;
    close(file);
    if (!is_locked && reason != EWOULDBLOCK) throw_unwritable(asked, std::strerror(reason));
  }
  throw InputError(fmt::format("--out {}: another run is writing it", asked.string()));
}

}  // namespace

OutputFolder::OutputFolder(const fs::path& folder, Leftovers leftovers)
    : folder_(whole_name(folder)) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();  // "results/x/"
  if (fs::is_symlink(folder_)) {
    throw InputError(fmt::format("--out {}: is a link to nothing", folder.string()));
  }
  require_free(folder_);
  std::error_code error;
  if (fs::equivalent(folder_, fs::current_path(error), error)) {
    throw InputError(
        fmt::format("--out {}: is the current folder; name a new one in it", folder.string()));
  }
  made_parent_ = first_missing(folder_.parent_path());
  staging_ = staging_folder(folder_);
  try {
    lock_ = lock_folder(staging_, folder);
    require_free(folder_);  // another run may have ended meanwhile
  } catch (const InputError&) {
    if (lock_ >= 0) close(lock_);
    fs::remove(staging_, error);  // only where it is empty
    remove_empty_parents();
    throw;
  }
  if (leftovers == Leftovers::kRemove) clear();
}

OutputFolder::~OutputFolder() {
  if (!is_committed_ && !is_kept_) remove_all();
  close(lock_);
}

void OutputFolder::clear() {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(staging_, ignored)) {
    if (entry.path().filename() != kLockFile) fs::remove_all(entry.path(), ignored);
  }
}

void OutputFolder::remove_all() {
  std::error_code ignored;
  fs::remove_all(staging_, ignored);
  remove_empty_parents();
}

void OutputFolder::remove_empty_parents() {
  if (made_parent_.empty()) return;
  std::error_code ignored;
  // Only what is empty: another run may have put something there.
  for (fs::path at = staging_.parent_path();; at = at.parent_path()) {
    if (!fs::remove(at, ignored) || at == made_parent_) return;
  }
}

void OutputFolder::commit() {
  std::error_code error;
  require_free(folder_);
  fs::rename(staging_, folder_, error);  // over an empty folder as well
  if (error) throw_unwritable(folder_, error.message());
  is_committed_ = true;
  // Not before: without it another run could begin where this one has not ended.
  fs::remove(folder_ / kLockFile, error);
}

fs::path staging_folder(const fs::path& folder) {
  return folder.parent_path() / fmt::format(".{}.partial", folder.filename().string());
}

void write_file(const fs::path& file, std::string_view text) {
  write_file(file, [text](std::ostream& out) { out << text; });
}

void write_file(const fs::path& file, const std::function<void(std::ostream&)>& write) {
  const fs::path partial = file.string() + ".partial";
  std::error_code error;
  fs::remove(partial, error);  // what a killed writer left, or a link: never what it leads to
  const int descriptor =
      open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    throw OutputError(
        fmt::format("{}: cannot be written ({})", file.string(), std::strerror(errno)));
  }
  __gnu_cxx::stdio_filebuf<char> buffer(descriptor, std::ios::out | std::ios::binary);
  std::ostream out(&buffer);
  errno = 0;
  write(out);
  out.flush();
  const bool is_whole = out.good() && buffer.close() != nullptr;
  if (!is_whole) error.assign(errno != 0 ? errno : EIO, std::generic_category());
  if (is_whole) fs::rename(partial, file, error);
  if (error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw OutputError(fmt::format("{}: cannot be written ({})", file.string(), error.message()));
  }
}

}  // namespace sightline
