// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>

namespace sightline {

/// How many processors this process may use, as its affinity and, in a container, its quota say; at
/// least 1.
int usable_processors();

/// The same of a quota as Linux's control groups (version 2) state it in cpu.max, "150000 100000"
/// (microseconds in a period): rounded up. 0 where it states none.
int allowed_by_quota(std::istream& cpu_max);

}  // namespace sightline
