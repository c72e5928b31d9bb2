// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Written before a function, it compiles that function and all that it calls once for each level
/// of x86-64 (v4 has AVX-512, v3 AVX2 and fused multiply-add); which version runs is chosen at the
/// program's start, by what the processor has. Only for files that include no Eigen: Eigen chooses
/// its alignment when it is compiled, and two versions of it in one program do not go together.
/// With a sanitizer the macro is empty, because sanitizers are not yet awake when the choice is
/// made; on other processors and with other compilers it is empty too: the plain version runs.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SIGHTLINE_MULTIVERSION \
  [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"), gnu::flatten]]
#else
#define SIGHTLINE_MULTIVERSION
#endif
