#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Attacks the program for some minutes (./dev attack): kills it and stops it at any moment, fills its
disk, cuts its memory, and gives it files that were damaged at any byte. Whatever is done to it, it ends
by itself, in time and within bounds of memory, with an exit code of its own and with words of its own;
what it had finished is continued by --resume to the bytes of an undisturbed run.

Every attack is drawn from a seed, which is printed where one succeeds: --seed repeats it alone."""

import argparse
import os
import random
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LONGEST_RUN_S = 120
STOPPED_WITHIN_S = 10  # of TERM, on a machine that does other things too
MOST_MEMORY_BYTES = 4 << 30  # of addresses: no damaged file may ask for more
OWN_EXIT_CODES = {0, 1, 3, 4}
WORDS_OF_LIBRARIES = ("terminate called", "json.exception", "std::", "Assertion", "Segmentation", "Traceback")

STUDY = ["study", "cube-noise", "--trials", "150", "--set", 'solvers=["orpe","lspe"]', "--quiet"]
RENDER = ["render", "cube", "--count", "12", "--set", "camera.width_px=96", "--set",
          "camera.height_px=96", "--quiet"]


class Succeeded(Exception):
    """An attack did: the program is not as it should be."""


class Attacker:
    def __init__(self, program, folder):
        self.program = program
        self.folder = folder
        self.study = folder / "whole_study"
        self.set = folder / "whole_set"
        self.call(STUDY + ["--jobs", "1", "--out", str(self.study)], allowed={0})
        self.call(RENDER + ["--jobs", "1", "--out", str(self.set)], allowed={0})

    # ---- one run

    def start(self, arguments, limits=()):
        def limit():
            for kind, size in limits:
                resource.setrlimit(kind, (size, size))

        return subprocess.Popen(
            [str(self.program)] + arguments, cwd=self.folder, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
            preexec_fn=limit)

    def finish(self, process, arguments, allowed, within_s=LONGEST_RUN_S):
        try:
            output = process.communicate(timeout=within_s)[0].decode(errors="replace")
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            raise Succeeded(f"did not end within {within_s} s: {arguments}")
        if process.returncode not in allowed:
            raise Succeeded(f"ended with {process.returncode}: {arguments}\n{output[-2000:]}")
        for word in WORDS_OF_LIBRARIES:
            if word in output:
                raise Succeeded(f"said '{word}': {arguments}\n{output[-2000:]}")
        return output

    def call(self, arguments, allowed=frozenset(OWN_EXIT_CODES), limits=()):
        return self.finish(self.start(arguments, limits), arguments, allowed)

    # ---- what a run has made, whatever happened to it meanwhile

    def same(self, out, whole, names):
        for name in names:
            if (out / name).read_bytes() != (whole / name).read_bytes():
                raise Succeeded(f"{name} is not what an undisturbed run makes")

    def check_study(self, out):
        self.call(STUDY + ["--jobs", "2", "--resume", "--out", str(out)], allowed={0})
        self.same(out, self.study, ["results.csv", "summary.json"])

    def check_set(self, out):
        self.call(RENDER + ["--jobs", "2", "--resume", "--out", str(out)], allowed={0})
        self.call(["render", "--quiet", "--verify", str(out)], allowed={0})

    def any_work(self, rng, out):
        """A run into a folder, and what checks that it can be continued."""
        arguments, check = rng.choice([(STUDY, self.check_study), (RENDER, self.check_set)])
        jobs = ["--jobs", str(rng.randint(1, 3)), "--resume", "--out", str(out)]
        return arguments + jobs, check

    # ---- the attacks

    def kill(self, rng, out):
        arguments, check = self.any_work(rng, out)
        for _ in range(rng.randint(1, 4)):
            process = self.start(arguments)
            time.sleep(rng.uniform(0, 1.5))
            if rng.random() < 0.5:
                os.killpg(process.pid, signal.SIGKILL)  # with its workers
            else:
                process.kill()  # its workers must die with it
            process.communicate()
        check(out)

    def stop(self, rng, out):
        arguments, check = self.any_work(rng, out)
        process = self.start(arguments)
        time.sleep(rng.uniform(0, 1.5))
        process.send_signal(rng.choice([signal.SIGTERM, signal.SIGINT, signal.SIGHUP]))
        by_signal = {-signal.SIGTERM, -signal.SIGINT, -signal.SIGHUP, 129, 130, 143}
        self.finish(process, arguments, OWN_EXIT_CODES | by_signal, STOPPED_WITHIN_S)
        check(out)

    def fill_disk(self, rng, out):
        """No file may grow beyond a size: the n-th write fails, as on a full disk."""
        arguments, check = self.any_work(rng, out)
        limits = [(resource.RLIMIT_FSIZE, rng.choice([1, 512, 4096, 20_000, 100_000, 400_000]))]
        output = self.call(arguments, limits=limits, allowed={0, 1, 4})
        if not output and not (out / "results.csv").exists() and not (out / "test").exists():
            raise Succeeded("a full disk is not told")
        check(out)

    def cut_memory(self, rng, out):
        arguments, check = self.any_work(rng, out)
        limits = [(resource.RLIMIT_AS, rng.randint(60, 700) << 20)]
        # Below some size the loader itself cannot map the program's libraries: 127.
        self.call(arguments, limits=limits, allowed={0, 1, 4, 127})
        check(out)

    def damage(self, rng, out):
        """Files of others, damaged at any byte, read by whatever reads them."""
        source, commands = rng.choice([
            (self.study, [["report", "{}"], ["compare", str(self.study), "{}"],
                          ["merge", "{}", "--out", "{}_merged"],
                          ["export", "{}", "--solver", "lspe", "--condition", "1 px", "--format", "bop"]]),
            (self.set, [["render", "--quiet", "--verify", "{}"],
                        ["evaluate", "{}", "--target", "cube", "--solvers", "lspe", "--quiet",
                         "--out", "{}_run"],
                        ["score", str(self.folder / "estimates.csv"), "--dataset", "{}", "--out",
                         "{}_scores"]]),
        ])
        shutil.copytree(source, out)
        estimates = "scene_id,im_id,obj_id,score,R,t,time\n0,0,1,1,1 0 0 0 1 0 0 0 1,0 0 1000,-1\n"
        (self.folder / "estimates.csv").write_text(estimates)
        files = sorted(f for f in out.rglob("*") if f.is_file() and f.suffix not in {".svg", ".html"})
        for _ in range(rng.randint(1, 3)):
            damage_file(rng, rng.choice(files))
        arguments = [part.replace("{}", str(out)) for part in rng.choice(commands)]
        self.call(arguments, limits=[(resource.RLIMIT_AS, MOST_MEMORY_BYTES)])

    def edit_store(self, rng, out):
        """A store whose rows say what cannot be is an input error, never a result."""
        shutil.copytree(self.study, out)
        edits = ["DELETE FROM estimates WHERE trial = 3", "UPDATE trials SET condition = 99",
                 "UPDATE estimates SET solver = 'best' WHERE trial = 5",
                 "UPDATE estimates SET geodesic_deg = 'x' WHERE trial = 5",
                 "UPDATE estimates SET geodesic_deg = -1 WHERE trial = 5",
                 "UPDATE observations SET position = position + 100 WHERE trial = 2",
                 "ALTER TABLE estimates RENAME TO e; CREATE VIEW estimates AS SELECT * FROM e"]
        with sqlite3.connect(out / "results.sqlite") as store:
            store.executescript(rng.choice(edits))
        self.call(["report", str(out)], allowed={1})
        self.call(["compare", str(self.study), str(out)], allowed={1})


    def reach_out(self, rng, out):
        """A received run that would have a file of the user's removed, overwritten or shown."""
        victim = self.folder / "victim.json"
        victim.write_text('{"token": "hunter2"}')
        shutil.copytree(self.study, out)
        way = rng.choice(["journal", "figures", "drawn", "written", "store", "begun"])
        begun = out.parent / f".{out.name}.partial"
        if way == "journal":
            (out / "results.sqlite-journal").write_bytes(journal_that_removes(victim))
        elif way == "begun":  # a run to continue, without the jobs' stores that its journals would be of
            out.rename(begun)
            (begun / ".lock").touch()
            with sqlite3.connect(begun / "results.sqlite") as store:
                for (table,) in store.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall():
                    if table != "meta":
                        store.execute(f"DELETE FROM {table}")
            for job in (0, 1):
                for ending in ("", ".partial"):
                    journal = begun / f"job-{job}.sqlite{ending}-journal"
                    journal.write_bytes(journal_that_removes(victim))
        elif way == "figures":
            shutil.rmtree(out / "figures")
            (out / "figures").symlink_to(self.study / "figures")
        else:
            links = {"drawn": sorted((out / "figures").iterdir()), "store": [out / "results.sqlite"],
                     "written": [file for file in out.iterdir() if file.is_file()
                                 and file.name != "results.sqlite"]}[way]
            for link in links:
                link.unlink()
                link.symlink_to(victim)
        before = {file: file.stat().st_mtime_ns for file in self.study.rglob("*")}
        for arguments in (["report", str(out)], ["compare", str(self.study), str(out)],
                          ["merge", str(out), "--out", str(out) + "_merged"],
                          STUDY + ["--jobs", "2", "--resume", "--out", str(out)]):
            self.call(arguments, allowed={0, 1})
        if not victim.exists() or "hunter2" not in victim.read_text():
            raise Succeeded(f"a file beyond the run is gone or another ({way})")
        if before != {file: file.stat().st_mtime_ns for file in self.study.rglob("*")}:
            raise Succeeded(f"another run was written ({way})")
        page = out / "report.html"
        if page.is_file() and not page.is_symlink() and "hunter2" in page.read_text(errors="replace"):
            raise Succeeded(f"a file beyond the run is shown ({way})")


def journal_that_removes(victim):
    """Of several databases: SQLite removes the file that it names."""
    name = str(victim).encode()
    magic = bytes.fromhex("d9d505f920a163d7")
    tail = bytes(4) + name + len(name).to_bytes(4, "big") + sum(name).to_bytes(4, "big")
    return magic + bytes(504) + tail + magic


def damage_file(rng, file):
    bytes_ = bytearray(file.read_bytes())
    way = rng.choice(["flip", "cut", "repeat", "digits", "empty", "folder"])
    if way == "folder":
        file.unlink()
        file.mkdir()
        return
    at = rng.randrange(len(bytes_) + 1)
    if way == "flip":
        for _ in range(rng.randint(1, 20)):
            if bytes_:
                bytes_[rng.randrange(len(bytes_))] = rng.randrange(256)
    elif way == "cut":
        del bytes_[at:]
    elif way == "repeat":
        bytes_[at:at] = bytes_[max(0, at - 200):at] * rng.randint(1, 50)
    elif way == "digits":
        bytes_[at:at] = rng.choice([b"9" * 400, b"-1e308", b"NaN", b"[" * 5000, b"\x1b]0;x\x07"])
    else:
        bytes_.clear()
    file.write_bytes(bytes_)


def play(attacker, seed):
    rng = random.Random(seed)
    attacks = [attacker.kill, attacker.stop, attacker.fill_disk, attacker.cut_memory,
               attacker.damage, attacker.damage, attacker.edit_store, attacker.reach_out]
    attack = rng.choice(attacks)
    out = attacker.folder / "attacked"
    try:
        attack(rng, out)
        return attack.__name__, ""
    except Succeeded as success:
        return attack.__name__, f"seed {seed}, {attack.__name__}: {success}"
    finally:
        for left in attacker.folder.glob("*attacked*"):
            shutil.rmtree(left, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, help="of one attack, to see it again")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="sightline_attack_") as folder:
        attacker = Attacker(arguments.program.resolve(), Path(folder))
        if arguments.seed is not None:
            problem = play(attacker, arguments.seed)[1]
            print(problem or "withstood")
            return 1 if problem else 0
        end = time.monotonic() + arguments.seconds
        counts, problems, seed = {}, [], 0
        while time.monotonic() < end:
            name, problem = play(attacker, seed)
            counts[name] = counts.get(name, 0) + 1
            if problem:
                problems.append(problem)
                print(problem, flush=True)
            seed += 1
    told = ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))
    print(f"{seed} attacks ({told}): {len(problems)} succeeded")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
