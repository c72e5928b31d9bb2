// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>

namespace sightline {

/// The user pressed Ctrl-C or the system asked the program to end.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// From here on SIGINT and SIGTERM are remembered instead of ending the process, so that long work
/// can stop between two steps and leave nothing half-written.
void remember_interrupts();

/// Throws Interrupted once a signal has come.
void stop_if_interrupted();

}  // namespace sightline
