// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <malloc.h>

namespace sightline {

/// Frames come and go: memory that was once fetched from the system, page by page, is kept for the
/// next. A fifth of the time of an image set. For programs alone: it changes the whole process.
inline void keep_freed_memory() {
  constexpr int kMebibyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMebibyte);
  mallopt(M_TRIM_THRESHOLD, 512 * kMebibyte);
}

}  // namespace sightline
