// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/memory.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

namespace sightline {
namespace {

// What stands behind a word in a file of the kernel, in kB.
std::optional<double> kilobytes_behind(const char* file, const std::string& word) {
  std::ifstream stream(file);
  for (std::string read; stream >> read;) {
    double value = 0;
    if (read == word && stream >> value) return value;
  }
  return std::nullopt;
}

// The number in a file; none where there is none, as where it says "max".
std::optional<double> number_in_file(const char* file) {
  double value = 0;
  if (std::ifstream(file) >> value) return value;
  return std::nullopt;
}

// What is mapped already, in bytes.
double mapped_bytes() {
  return number_in_file("/proc/self/statm").value_or(0) * static_cast<double>(getpagesize());
}

void lower(std::optional<double>& least, std::optional<double> other) {
  if (other) least = least ? std::min(*least, *other) : *other;
}

}  // namespace

std::optional<double> free_memory_bytes() {
  constexpr double kBytesAKilobyte = 1024;
  std::optional<double> least;
  if (const auto available = kilobytes_behind("/proc/meminfo", "MemAvailable:")) {
    least = kBytesAKilobyte * *available;
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    lower(least, static_cast<double>(limit.rlim_cur) - mapped_bytes());
  }
  const auto most = number_in_file("/sys/fs/cgroup/memory.max");
  const auto used = number_in_file("/sys/fs/cgroup/memory.current");
  if (most && used) lower(least, *most - *used);
  return least;
}

std::string why_no_memory(int64_t width_px, int64_t height_px, int processes,
                          std::optional<double> free_bytes) {
  constexpr double kBytesAPixel = 16;  // grey levels 2, depth 8, ids 2, and copies for a while
  constexpr double kBytesAGigabyte = 1e9;
  const double needed = kBytesAPixel * static_cast<double>(width_px) *
                        static_cast<double>(height_px) * std::max(1, processes);
  if (!free_bytes || needed <= *free_bytes) return "";
  const std::string by = processes > 1 ? fmt::format(" in {} processes", processes) : "";
  return fmt::format("images of {} x {} pixels take {:.1f} GB at least{}, and {:.1f} GB are free",
                     width_px, height_px, needed / kBytesAGigabyte, by,
                     std::max(0.0, *free_bytes) / kBytesAGigabyte);
}

}  // namespace sightline
