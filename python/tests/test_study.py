# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time

import pytest

import sightline as sl

# A study of a second, which has solvers of several kinds and conditions.
SMALL = dict(trials=5, set={"solvers": ["orpe", "lspe", "oracle"]})


def read(folder, name="results.csv"):
    return (pathlib.Path(folder) / name).read_bytes()


@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("study, trials", [
    ("cube-noise", 5), ("boeing-random", 3), ("orientation-noise", 4)])
def test_a_run_is_the_programs_byte_for_byte(here, program, study, trials, jobs):
    run = sl.Study(study, trials=trials, seed=7).run("ours", jobs=jobs)
    outcome = program("study", study, "--trials", trials, "--seed", 7, "--out", "theirs", "--quiet")
    assert outcome.returncode == 0, outcome.stderr
    for name in ("results.csv", "summary.json", "study.toml"):
        assert read("ours", name) == read("theirs", name)
    assert run.path == here / "ours" and run.report.path.is_file()
    other = sl.Study(study, trials=trials, seed=8).run("other")
    assert read(other.path) != read("ours")


def test_a_study_says_what_it_is():
    study = sl.Study("cube-noise", **SMALL, seed=3)
    assert (study.name, study.kind, study.seed) == ("cube-noise", "numeric", 3)
    assert study.solvers == ["orpe", "lspe", "oracle"]
    assert len(study) == 5 * len(study.conditions)
    assert "trials = 5" in study.toml
    assert "cube-noise" in sl.studies() and study.question == sl.studies()["cube-noise"]


def test_names_of_solvers_at_the_run_take_the_place_of_the_files(here):
    study = sl.Study("cube-noise", **SMALL)
    run = study.run("a", solvers=["lspe"])
    assert set(run.columns()["solver"]) == {"lspe"}
    assert study.solvers == ["orpe", "lspe", "oracle"]
    assert set(study.run("b").columns()["solver"]) == {"orpe", "lspe", "oracle"}


def test_without_a_name_a_folder_is_found(here):
    study = sl.Study("cube-noise", trials=1, set={"solvers": ["lspe"]})
    assert study.run().path == here / "results" / "cube-noise"
    assert study.run().path == here / "results" / "cube-noise-2"


def test_shards_from_here_are_joined_by_the_program(here, program):
    study = sl.Study("cube-noise", **SMALL)
    study.run("whole")
    for i in (0, 1):
        study.run(f"shard{i}", shard=f"{i}/2")
    outcome = program("merge", "shard0", "shard1", "--out", "joined")
    assert outcome.returncode == 0, outcome.stderr
    assert read("joined") == read("whole")
    again = study.run("whole", resume=True)
    assert again.resumed_trials == len(study)


@pytest.mark.parametrize("arguments, options", [
    (["cube-noise", "--set", "noise.scal=2"], dict(name="cube-noise", set={"noise.scal": 2})),
    (["cube-nois"], dict(name="cube-nois")),
    (["cube-noise", "--set", 'solvers=["orpee"]'],
     dict(name="cube-noise", set={"solvers": ["orpee"]})),
    (["absent.toml"], dict(name="absent.toml")),
])
def test_errors_are_the_programs_lines(here, program, arguments, options):
    printed = program("study", *arguments, "--out", "x").stderr
    with pytest.raises(sl.InputError) as refusal:
        sl.Study(**options)
    assert f"sightline: {refusal.value}\n" == printed


def test_what_cannot_be_run_is_refused_and_leaves_nothing(here):
    study = sl.Study("cube-noise", **SMALL)
    (here / "full").mkdir()
    (here / "full" / "file").write_text("mine")
    with pytest.raises(sl.InputError, match="exists and is not empty"):
        study.run("full")
    with pytest.raises(sl.InputError, match="run: jobs: is 0, must be a whole number from 1"):
        study.run("x", jobs=0)
    with pytest.raises(sl.InputError, match="trials: is 0, must be"):
        sl.Study("cube-noise", trials=0)
    with pytest.raises(sl.InputError, match="shard 3/2"):
        study.run("x", shard="3/2")
    with pytest.raises(sl.InputError, match="which a file cannot hold"):
        sl.Study("cube-noise", set={"noise.scale": object()})
    assert os.listdir(here) == ["full"] and os.listdir(here / "full") == ["file"]


def test_other_threads_go_on_meanwhile(here):
    steps = 0
    is_over = threading.Event()

    def count():
        nonlocal steps
        while not is_over.is_set():
            steps += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    sl.Study("boeing-random", trials=3).run("run")
    is_over.set()
    counter.join()
    assert steps > 20  # with the lock held it would be a handful


LONG_RUN = """
import signal, sys
import sightline as sl
# A shell that starts a job in the background lets it ignore this signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
study = sl.Study("cube-noise", trials=1000000, set={"solvers": ["lspe"]})
print("begin", flush=True)
try:
    study.run("long", jobs=int(sys.argv[1]))
except KeyboardInterrupt as interrupt:
    print("interrupted:", interrupt)
run = sl.Study("cube-noise", trials=2, set={"solvers": ["lspe"]}).run("after")
print("after:", len(run.columns()["trial"]) > 0)
"""


@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_ends_a_run_and_not_the_session(here, jobs):
    process = subprocess.Popen([sys.executable, "-c", LONG_RUN, str(jobs)], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == "begin\n"
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    said = r"interrupted: interrupted; \d+ finished trials are kept for --resume\nafter: True\n"
    assert re.fullmatch(said, output), output + errors
    assert sorted(os.listdir(here)) == [".long.partial", "after"]
