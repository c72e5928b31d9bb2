// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/page_text.h"

#include <filesystem>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(SIGHTLINE_SOURCE_DIR) / "assets" / "report";

TEST(PageText, TheProgramHoldsEveryPartOfThePageAsItsFileHasIt) {
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(kFolder)) {
    EXPECT_EQ(page_text(entry.path().filename().string()), read_whole(entry.path()))
        << entry.path();
    ++files;
  }
  EXPECT_EQ(page_texts().size(), files + 1) << "those and Chart.js";
  EXPECT_NE(page_text("chart.js").find("Chart.js v"), std::string::npos);
}

TEST(PageText, ANameThatIsNoneOfThemIsAnError) {
  EXPECT_THROW(page_text("no-such.mustache"), std::logic_error);
}

}  // namespace
}  // namespace sightline
