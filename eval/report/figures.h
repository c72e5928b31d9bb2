// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/report/chart.h"
#include "eval/report/report.h"

namespace sightline {

/// The functions in the catalogue of report figures, one a file in this folder.
std::string answer_figure(const ReportInput& input);
std::string sweep_figure(const ReportInput& input);
std::string table_figure(const ReportInput& input);
std::string ladder_figure(const ReportInput& input);
std::string diagnosis_figure(const ReportInput& input);
std::string extraction_figure(const ReportInput& input);
std::string silhouette_figure(const ReportInput& input);
std::string frames_figure(const ReportInput& input);
std::string provenance_figure(const ReportInput& input);

std::vector<Chart> sweep_charts(const ReportInput& input);
std::vector<Chart> cumulative_charts(const ReportInput& input);
std::vector<Chart> boxes_charts(const ReportInput& input);
std::vector<Chart> paired_charts(const ReportInput& input);
std::vector<Chart> angles_charts(const ReportInput& input);

/// The answer of a study without images, which the answer figure shows.
std::string sweep_answer(const ReportInput& input);

}  // namespace sightline
