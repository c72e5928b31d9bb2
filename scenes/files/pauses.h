// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sightline {

/// From here on `call` is called again and again while somebody's files are read and while programs
/// are waited for, and may throw to end that: so that a signal is heard in the middle of a file of
/// a gigabyte, or beside a program that hangs (eval/work/interrupt.h). Null: nothing is called.
void call_in_pauses(void (*call)());

/// Calls that, if there is one.
void take_pause();

/// The same for what reads line by line, or value by value: only once in some hundred times.
void pause_at_times();

}  // namespace sightline
