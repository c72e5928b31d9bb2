// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/processors.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

#include <sched.h>

namespace sightline {
namespace {

int allowed_by_affinity() {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) return CPU_COUNT(&allowed);
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

int allowed_by_quota(std::istream& cpu_max) {
  double quota_us = 0, period_us = 0;  // "max 100000" where there is none
  if (!(cpu_max >> quota_us >> period_us) || quota_us <= 0 || period_us <= 0) return 0;
  return std::max(1, static_cast<int>(std::ceil(std::min(1e4, quota_us / period_us))));
}

int usable_processors() {
  std::ifstream cpu_max("/sys/fs/cgroup/cpu.max");
  const int by_quota = allowed_by_quota(cpu_max);
  const int by_affinity = std::max(1, allowed_by_affinity());
  return by_quota > 0 ? std::min(by_quota, by_affinity) : by_affinity;
}

}  // namespace sightline
