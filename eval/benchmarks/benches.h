// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The families of benchmarks. To add one: write eval/benchmarks/<family>_bench.cpp with a function
// that registers `<family>/<method>/<size>` and says what to compare, declare it here, call it in
// main.cpp, and list the file in CMakeLists.txt.
#pragma once

#include "eval/benchmarks/ratios.h"

namespace sightline {

PeerComparison register_absolute_orientation();
PeerComparison register_alignment();
PeerComparison register_outlier();
PeerComparison register_pnp();
PeerComparison register_render();
/// These compare with nothing.
void register_pipeline();
void register_door();
void register_lines();
void register_registration();

}  // namespace sightline
