// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The table of [bound].
#include "eval/study/key_tables.h"

namespace sightline {

std::vector<Key> bound_keys(bool& has_image_bound) {
  return {{"bound",
           "image",
           &has_image_bound,
           {},
           "",
           "of an image study: whether errors of the Cramér-Rao bound of each image stand beside "
           "the solvers', as image_bound and outline_bound"}};
}

}  // namespace sightline
