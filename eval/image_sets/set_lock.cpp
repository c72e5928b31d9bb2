// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Byte ranges of one file, each locked for a meaning. The locks belong to the open file, so that
// workers share them (open file description locks, fcntl(2)).
#include "eval/image_sets/set_lock.h"

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

constexpr int64_t kAloneByte = 0;
constexpr int64_t kShardBytes = int64_t{1} << 33;     // plus the shard's index: held by one
constexpr int64_t kDivisionBytes = int64_t{1} << 34;  // plus the count of shards: shared by all
constexpr int64_t kEnd = int64_t{1} << 35;

struct flock range(short type, int64_t begin, int64_t end) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = begin;
  lock.l_len = end - begin;
  return lock;
}

bool try_lock(int file, short type, int64_t byte) {
  struct flock lock = range(type, byte, byte + 1);
  return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

bool is_held_by_another(int file, int64_t begin, int64_t end) {
  if (begin == end) return false;
  struct flock lock = range(F_WRLCK, begin, end);
  return fcntl(file, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool try_shard(int file, const Shard& shard) {
  const int64_t division = kDivisionBytes + shard.count;
  return !is_held_by_another(file, kDivisionBytes, division) &&
         !is_held_by_another(file, division + 1, kEnd) &&
         try_lock(file, F_WRLCK, kShardBytes + shard.index) && try_lock(file, F_RDLCK, division);
}

}  // namespace

SetLock::SetLock(const std::filesystem::path& folder, const Shard& shard) {
  file_ = open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file_ < 0) {
    throw InputError(
        fmt::format("--out {}: cannot be written ({})", folder.string(), std::strerror(errno)));
  }
  // The workers of a process that has just been killed may take a moment to end.
  constexpr int kTries = 20;
  constexpr auto kPause = std::chrono::milliseconds(50);
  for (int i = 0; i < kTries; ++i) {
    {
      const Alone alone(*this);
      if (try_shard(file_, shard)) return;
    }
    std::this_thread::sleep_for(kPause);
  }
  close(file_);
  throw InputError(fmt::format("--out {}: another run is writing it", folder.string()));
}

SetLock::~SetLock() {
  close(file_);
}

SetLock::Alone::Alone(const SetLock& lock) : file_(lock.file_) {
  struct flock byte = range(F_WRLCK, kAloneByte, kAloneByte + 1);
  while (fcntl(file_, F_OFD_SETLKW, &byte) != 0) {
    if (errno == EINTR) continue;
    throw InputError(fmt::format("the set's folder cannot be locked ({})", std::strerror(errno)));
  }
}

SetLock::Alone::~Alone() {
  struct flock byte = range(F_UNLCK, kAloneByte, kAloneByte + 1);
  fcntl(file_, F_OFD_SETLK, &byte);
}

}  // namespace sightline
