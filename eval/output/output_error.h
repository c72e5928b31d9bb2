// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/files/input_error.h"

namespace sightline {

/// A file cannot be written, as on a full disk: nothing is wrong with what was read.
class OutputError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace sightline
