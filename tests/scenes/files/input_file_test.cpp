// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/input_file.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "scenes/files/checksum.h"
#include "scenes/files/pauses.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/packed_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr uintmax_t kMiB = uintmax_t{1} << 20;

// The check value of the catalogues of CRCs.
TEST(Checksum, IsZlibs) {
  EXPECT_EQ(crc32_text("123456789"), "cbf43926");
  EXPECT_EQ(crc32_text(""), "00000000");
}

TEST(InputFiles, ThatGzipPackedAreReadAsTheOthersWhateverTheirNames) {
  const TemporaryFolder folder;
  std::string text = "one\n";
  for (int i = 0; i < 100'000; ++i) text += std::to_string(i) + "\n";  // more than a block
  EXPECT_EQ(read_input_file(folder.write("plain.txt", text), kMiB), text);
  EXPECT_EQ(read_input_file(write_packed(folder.path() / "a.gz", text), kMiB), text);
  EXPECT_EQ(read_input_file(write_packed(folder.path() / "b.txt", text), kMiB), text);
  EXPECT_EQ(read_input_file(write_packed(folder.path() / "none.gz", ""), kMiB), "");
  EXPECT_EQ(read_input_file(folder.write("empty.gz", ""), kMiB), "");
  EXPECT_EQ(read_input_file(folder.write("plain.gz", text), kMiB), text);  // a name is no proof
  std::string line;
  read_bounded_line(*open_input_file(folder.path() / "a.gz", kMiB), line);
  EXPECT_EQ(line, "one");
}

// A thousandth of what it unpacks to.
TEST(InputFiles, AreBoundedByWhatTheyUnpackTo) {
  const TemporaryFolder folder;
  const fs::path bomb = write_packed(folder.path() / "bomb.gz", std::string(3 * kMiB, ' '));
  ASSERT_LT(fs::file_size(bomb), kMiB / 100);
  EXPECT_EQ(read_input_file(bomb, 3 * kMiB).size(), 3 * kMiB);
  EXPECT_THAT(error_of([&] { read_input_file(bomb, 2 * kMiB); }),
              HasSubstr("bomb.gz: is larger than 2 MiB"));
  std::string line;
  EXPECT_THAT(error_of([&] {
                const auto stream = open_input_file(bomb, kMiB / 2);
                while (read_bounded_line(*stream, line)) continue;
              }),
              HasSubstr("bomb.gz: is larger than 0 MiB"));
}

// Blanks pack to a thousandth, as numbers and names never do.
TEST(InputFiles, ThatUnpackToAHundredTimesTheirSizeAreRefused) {
  const TemporaryFolder folder;
  const fs::path bomb = write_packed(folder.path() / "bomb.gz", std::string(20 * kMiB, ' '));
  EXPECT_THAT(error_of([&] { read_input_file(bomb, 100 * kMiB); }),
              HasSubstr("bomb.gz: unpacks to more than 100 times its size"));
}

TEST(InputFiles, ThatArePackedAndDamagedAreSaid) {
  const TemporaryFolder folder;
  const std::string whole =
      read_whole(write_packed(folder.path() / "a.gz", std::string(5000, 'a') + "b"));
  const auto error = [&](const std::string& bytes) {
    const fs::path file = folder.write("damaged.gz", bytes);
    return error_of([&] { read_input_file(file, kMiB); });
  };
  EXPECT_EQ(error(whole), "");
  EXPECT_THAT(error(whole.substr(0, whole.size() - 12)),
              HasSubstr("damaged.gz: is damaged: gzip cannot unpack it"));
  std::string wrong_sum = whole;
  wrong_sum[wrong_sum.size() - 8] ^= 1;
  EXPECT_THAT(error(wrong_sum), HasSubstr("is damaged"));
  EXPECT_THAT(error_of([&] { read_input_file(folder.path() / "no.gz", kMiB); }),
              HasSubstr("no.gz: is missing or cannot be read"));
}

// A file of a set is the one that was written, or not: what gzip packed is another.
TEST(InputFiles, AsTheyStandAreNeverUnpacked) {
  const TemporaryFolder folder;
  const fs::path file = write_packed(folder.path() / "a.gz", "text");
  EXPECT_EQ(bytes_of_file(file, kMiB), read_whole(file));
  EXPECT_EQ(bytes_of_file(folder.write("empty", ""), kMiB), "");
  EXPECT_EQ(bytes_of_file(folder.write("four", "1234"), 4), "1234");
  EXPECT_FALSE(bytes_of_file(folder.path() / "four", 3));
  EXPECT_FALSE(bytes_of_file(folder.path() / "none", kMiB));
  EXPECT_FALSE(bytes_of_file(folder.path(), kMiB));
  ASSERT_EQ(mkfifo((folder.path() / "pipe").c_str(), 0600), 0);
  EXPECT_FALSE(bytes_of_file(folder.path() / "pipe", kMiB));
}

// So that a signal is heard in the middle of a file that is one number, or one text.
TEST(InputFiles, ArePausedIn) {
  struct Paused {};
  const TemporaryFolder folder;
  const fs::path file = folder.write("long.json", "\"" + std::string(kMiB, 'a') + "\"");
  EXPECT_EQ(read_input_file(file, 2 * kMiB).size(), kMiB + 2);
  call_in_pauses([] { throw Paused(); });
  EXPECT_THROW(read_input_file(file, 2 * kMiB), Paused);
  EXPECT_THROW(bytes_of_file(file, 2 * kMiB), Paused);
  call_in_pauses(nullptr);
}

TEST(InputFiles, AreFoundByTheNameBeforeTheyWerePacked) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a.json";
  EXPECT_EQ(plain_or_packed(file), file);  // where neither is there
  write_packed(folder.path() / "a.json.gz", "{}");
  EXPECT_EQ(plain_or_packed(file), folder.path() / "a.json.gz");
  folder.write("a.json", "[]");
  EXPECT_EQ(plain_or_packed(file), file);
  EXPECT_EQ(unpacked_name("x/a.csv.GZ"), "x/a.csv");
  EXPECT_EQ(unpacked_name("x/a.csv"), "x/a.csv");
  EXPECT_EQ(input_ending("a.JSON.gz"), ".json");
  EXPECT_EQ(input_ending("a.Csv"), ".csv");
  EXPECT_EQ(input_ending("gz"), "");
}

}  // namespace
}  // namespace sightline
