// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/shard.h"

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/work/memory.h"
#include "scenes/files/input_error.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;

ProcessVariables environment(std::map<std::string, std::string> variables) {
  auto kept = std::make_shared<std::map<std::string, std::string>>(std::move(variables));
  return [kept](const char* name) -> const char* {
    const auto found = kept->find(name);
    return found == kept->end() ? nullptr : found->second.c_str();
  };
}

ShardChoice read(const std::string& text, std::map<std::string, std::string> variables = {}) {
  return read_shard(text, environment(std::move(variables)));
}

TEST(Shard, IsReadAsGiven) {
  const ShardChoice choice = read("2/5", {{"PMI_RANK", "0"}, {"PMI_SIZE", "2"}});
  EXPECT_EQ(choice.shard.index, 2);
  EXPECT_EQ(choice.shard.count, 5);
  EXPECT_EQ(choice.source, "given");
}

TEST(Shard, NonsenseIsAnInputError) {
  for (const char* text : {"", "3", "/", "1/", "/4", "5/5", "-1/4", "1/0", "a/b", "1/4/2", "1.5/4",
                           "auto", "auto/x", "automatic"}) {
    EXPECT_THROW(read(text), InputError) << text;
  }
}

TEST(Shard, AShardOfALargeShardDoesNotOverflow) {
  const Shard shard = read("1073741824/2000000000").shard;
  EXPECT_EQ(shard.count * 1024, 2048000000000);
}

TEST(Shard, AutoAsksTheEngine) {
  const ShardChoice mpi =
      read("auto", {{"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "4"}});
  EXPECT_EQ(mpi.shard.index, 3);
  EXPECT_EQ(mpi.shard.count, 4);
  EXPECT_EQ(mpi.source, "Open MPI");

  const ShardChoice array = read("auto", {{"SLURM_ARRAY_TASK_ID", "12"},
                                          {"SLURM_ARRAY_TASK_MIN", "10"},
                                          {"SLURM_ARRAY_TASK_COUNT", "5"}});
  EXPECT_EQ(array.shard.index, 2);
  EXPECT_EQ(array.shard.count, 5);

  // With gaps, submitted again alone, and a part of what --shard says.
  const std::vector<std::array<std::string, 4>> parts = {
      {"auto", "1", "5", "3"}, {"auto", "2", "2", "1"}, {"auto/8", "2", "3", "2"}};
  for (const auto& [text, first, last, tasks] : parts) {
    EXPECT_THAT(error_of([&, text = text, first = first, last = last, tasks = tasks] {
                  read(text, {{"SLURM_ARRAY_TASK_ID", last},
                              {"SLURM_ARRAY_TASK_MIN", first},
                              {"SLURM_ARRAY_TASK_MAX", last},
                              {"SLURM_ARRAY_TASK_COUNT", tasks}});
                }),
                HasSubstr("give I/N"))
        << first;
  }
  EXPECT_EQ(read("auto", {{"SLURM_ARRAY_TASK_ID", "3"},
                          {"SLURM_ARRAY_TASK_MIN", "1"},
                          {"SLURM_ARRAY_TASK_MAX", "4"},
                          {"SLURM_ARRAY_TASK_COUNT", "4"}})
                .shard.index,
            2);
  const ShardChoice step = read("auto", {{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "2"}});
  EXPECT_EQ(step.source, "Slurm step");

  const ShardChoice job = read("auto/6", {{"JOB_COMPLETION_INDEX", "5"}});
  EXPECT_EQ(job.shard.index, 5);
  EXPECT_EQ(job.shard.count, 6);
}

TEST(Shard, AutoWithoutACountOrOutOfRangeIsAnInputError) {
  EXPECT_THROW(read("auto", {{"JOB_COMPLETION_INDEX", "5"}}), InputError);
  EXPECT_THROW(read("auto/4", {{"JOB_COMPLETION_INDEX", "5"}}), InputError);
  EXPECT_THAT(error_of([] {
                read("auto", {{"PMI_RANK", "x"}, {"PMI_SIZE", "2"}});
              }),
              HasSubstr("PMI_RANK is 'x', must be a whole number"));
  const std::string most = "2147483647", least = "-2147483648";
  EXPECT_THAT(error_of([&] {
                read("auto", {{"SLURM_ARRAY_TASK_ID", most},
                              {"SLURM_ARRAY_TASK_MIN", least},
                              {"SLURM_ARRAY_TASK_MAX", most},
                              {"SLURM_ARRAY_TASK_COUNT", "0"}});
              }),
              HasSubstr("has 0 of the ids -2147483648 to 2147483647, which do not say"));
}

// 16 bytes a pixel: 16384 x 16384 take 4.3 GB, in two processes 8.6.
TEST(Memory, RefusesImagesThatCannotFit) {
  EXPECT_EQ(why_no_memory(16384, 16384, 1, 5e9), "");
  EXPECT_EQ(why_no_memory(16384, 16384, 1, std::nullopt), "") << "nobody knows";
  EXPECT_EQ(why_no_memory(16384, 16384, 1, 3e9),
            "images of 16384 x 16384 pixels take 4.3 GB at least, and 3.0 GB are free");
  EXPECT_THAT(why_no_memory(16384, 16384, 2, 5e9), HasSubstr("8.6 GB at least in 2 processes"));
  ASSERT_TRUE(free_memory_bytes());
  EXPECT_GT(*free_memory_bytes(), 1e6);
}

}  // namespace
}  // namespace sightline
