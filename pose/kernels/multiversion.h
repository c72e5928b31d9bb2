// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Compiles a function, and all it calls, once for each level of x86-64 and picks at the program's
/// start what the processor has. For files of this folder, which include no Eigen: Eigen chooses
/// its alignment when it is compiled, and must not be compiled twice. Sanitizers are not yet awake
/// when the choice is made: they get the plain version, as other processors do.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SIGHTLINE_MULTIVERSION \
  [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"), gnu::flatten]]
#else
#define SIGHTLINE_MULTIVERSION
#endif
