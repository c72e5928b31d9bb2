// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/shard.h"

#include <map>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

Environment environment(std::map<std::string, std::string> variables) {
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

  const ShardChoice step = read("auto", {{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "2"}});
  EXPECT_EQ(step.source, "Slurm step");

  const ShardChoice job = read("auto/6", {{"JOB_COMPLETION_INDEX", "5"}});
  EXPECT_EQ(job.shard.index, 5);
  EXPECT_EQ(job.shard.count, 6);
}

TEST(Shard, AutoWithoutACountOrOutOfRangeIsAnInputError) {
  EXPECT_THROW(read("auto", {{"JOB_COMPLETION_INDEX", "5"}}), InputError);
  EXPECT_THROW(read("auto/4", {{"JOB_COMPLETION_INDEX", "5"}}), InputError);
  EXPECT_THROW(read("auto", {{"PMI_RANK", "x"}, {"PMI_SIZE", "2"}}), InputError);
}

}  // namespace
}  // namespace sightline
