// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/builders/boeing707.h"

namespace sightline {

/// The Boeing 707 with a livery of our own as a texture: the triangles, parts, albedos and features
/// are those of build_boeing707_target, so that depth, ids, masks and features of a pose are too.
BuiltTarget build_boeing707_livery_target(const Boeing707& dimensions = {});

}  // namespace sightline
