// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The formats of the catalogue (set_format.cpp), each in the file of its name.
#pragma once

#include "eval/image_sets/set_format.h"

namespace sightline {

SetFormat bop_format();
SetFormat speed_format();

}  // namespace sightline
