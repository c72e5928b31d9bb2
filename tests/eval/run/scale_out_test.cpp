// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A study in the shards of engines that start processes, and its merge: as one process has it.
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string kJobs = std::string(SIGHTLINE_SOURCE_DIR) + "/eval/jobs/";
const std::string kOptions = "--trials 30 --set 'solvers=[\"orpe\", \"lspe\"]' --quiet";

bool is_there(const std::string& program) {
  return run_shell("command -v " + program).exit_code == 0;
}

class ScaleOut : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  void expect_merges_to_one_process() const {
    const Outcome merged = run("merge " + path("shard-*") + " --out " + path("merged"));
    ASSERT_EQ(merged.exit_code, 0) << merged.output;
    ASSERT_EQ(run("study cube-noise " + kOptions + " --out " + path("one")).exit_code, 0);
    for (const char* file : {"results.csv", "summary.json"}) {
      const std::string of_one = read_whole(folder_.path() / "one" / file);
      EXPECT_FALSE(of_one.empty());
      EXPECT_EQ(of_one, read_whole(folder_.path() / "merged" / file)) << file;
    }
  }

  // The shell's search path with the program in it.
  static std::string with_program() {
    return "PATH=" + fs::path(SIGHTLINE_PROGRAM).parent_path().string() + ":$PATH ";
  }

  TemporaryFolder folder_;
};

TEST_F(ScaleOut, FourRanksOfMpirunMergeToOneProcess) {
  if (!is_there("mpirun")) GTEST_SKIP() << "no mpirun (Debian's openmpi-bin)";
  const std::string rank =
      fmt::format("exec {} study cube-noise {} --shard auto --out {}", SIGHTLINE_PROGRAM, kOptions,
                  path("shard-$OMPI_COMM_WORLD_RANK"));
  folder_.write("rank.sh", rank);
  const std::string as_root =
      run_shell("test $(id -u) = 0").exit_code == 0 ? "--allow-run-as-root" : "";
  const Outcome outcome =
      run_shell(fmt::format("mpirun {} --oversubscribe -n 4 sh {}", as_root, path("rank.sh")));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(fs::exists(path("shard-3")));
  EXPECT_FALSE(fs::exists(path("shard-4")));
  expect_merges_to_one_process();
  // Without one of the ranks it is no study.
  fs::remove_all(path("shard-2"));
  const Outcome missing = run("merge " + path("shard-*") + " --out " + path("x"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("shard 2 of 4 is missing"));
}

TEST_F(ScaleOut, TheSlurmArrayScriptRunsAShardATask) {
  for (int task = 10; task < 13; ++task) {
    const Outcome outcome = run_shell(fmt::format(
        "{} SLURM_ARRAY_TASK_ID={} SLURM_ARRAY_TASK_MIN=10 SLURM_ARRAY_TASK_COUNT=3 bash {} "
        "cube-noise {} {}",
        with_program(), task, kJobs + "slurm-array.sbatch", folder_.path().string(), kOptions));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  expect_merges_to_one_process();
  EXPECT_EQ(run_shell("bash " + kJobs + "slurm-array.sbatch cube-noise").exit_code, 2);
}

TEST_F(ScaleOut, TheSlurmStepScriptIsOfBashAndSaysItsUsage) {
  EXPECT_EQ(run_shell("bash -n " + kJobs + "slurm-step.sbatch").exit_code, 0);
  EXPECT_EQ(run_shell("bash " + kJobs + "slurm-step.sbatch cube-noise").exit_code, 2);
}

TEST_F(ScaleOut, TheKubernetesJobsAreValidAndRunAShardAPod) {
  if (run_shell("python3 -c 'import yaml'").exit_code != 0) {
    GTEST_SKIP() << "no python3-yaml to read the files with";
  }
  // Prints the container's shell script, with the volume where the test has it.
  const std::string script_of = folder_.write("script_of.py", R"(
import sys, yaml
job = yaml.safe_load(open(sys.argv[1]))
assert job["apiVersion"] == "batch/v1" and job["kind"] == "Job", job
container, = job["spec"]["template"]["spec"]["containers"]
assert container["command"][:2] == ["/bin/sh", "-ec"], container
mounts = {m["name"]: m["mountPath"] for m in container["volumeMounts"]}
assert mounts == {"results": "/results"}, mounts
if "completionMode" in job["spec"]:
    env = {e["name"]: e["value"] for e in container["env"]}
    assert job["spec"]["completionMode"] == "Indexed"
    assert env["SHARDS"] == str(job["spec"]["completions"])
print(container["command"][2].replace("/results/", sys.argv[2] + "/"))
)");
  for (const char* file : {"kubernetes-indexed-job.yaml", "kubernetes-merge-job.yaml"}) {
    const Outcome script =
        run_shell(fmt::format("python3 {} {} {}", script_of, kJobs + file, path("volume")));
    ASSERT_EQ(script.exit_code, 0) << script.output;
    folder_.write(std::string(file) + ".sh", script.output);
  }
  const std::string variables = with_program() + "STUDY=cube-noise TRIALS=30 SHARDS=2 ";
  for (int pod = 0; pod < 2; ++pod) {
    const Outcome outcome = run_shell(fmt::format("{} JOB_COMPLETION_INDEX={} sh -e {}", variables,
                                                  pod, path("kubernetes-indexed-job.yaml.sh")));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  const Outcome merged = run_shell(variables + "sh -e " + path("kubernetes-merge-job.yaml.sh"));
  ASSERT_EQ(merged.exit_code, 0) << merged.output;
  EXPECT_TRUE(fs::exists(path("volume/cube-noise/all/summary.json")));
}

}  // namespace
}  // namespace sightline
