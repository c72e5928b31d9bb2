// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sightline {

/// The bytes that this process and its children can still take: the least of what the machine has
/// available, what the limit of addresses (ulimit -v) leaves and what the control group leaves.
/// None where nobody says.
std::optional<double> free_memory_bytes();

/// Why images of so many pixels cannot be drawn by so many processes at once, from the least that
/// a frame takes (its image, depth and ids); empty where they can, or where nobody knows. To be
/// asked before work begins: the system would end a process that takes more without a word.
std::string why_no_memory(int64_t width_px, int64_t height_px, int processes,
                          std::optional<double> free_bytes);

}  // namespace sightline
