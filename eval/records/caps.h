// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace sightline {

/// A trial's errors count as at most these when means and RMS are taken, and a failed trial counts
/// as exactly these, so that one wrong pose does not decide a mean of a thousand trials.
inline constexpr double kAngleCapDeg = 20;
inline constexpr double kTranslationCapPercent = 20;

}  // namespace sightline
