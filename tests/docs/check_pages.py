#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs what README.md and docs/*.md tell their readers to type, and compares what they show.

    check_pages.py PROGRAM FOLDER [--long] [PAGE...]

Each page has a folder of its own below FOLDER, in which its commands are run in their order, so that
a command finds what those before it made. Run are the lines of fenced blocks that begin with
`sightline`, and such words within a text that name no placeholder (`sightline list keys noise`). A
block that is introduced by "Write this as `FILE`:" is written into FILE. Numbers of trials, images and
repeats are cut, since the question is here whether the command works (`--trials=N` is not);
--long runs all as they stand.

HTML comments, which readers of the page do not see, say what else is so. They stand before the block
or table that they are about (docs/extending.md describes them too):

    <!-- before: COMMAND -->              run first, as the reader has done; of several lines, each
    <!-- not run: REASON -->              the block is a form to be filled in, or needs what is not here
    <!-- exit code N -->                  with which the block's commands end, instead of 0
    <!-- printed by: COMMAND -->          the block is in what the command prints; `...` leaves some out.
    <!-- printed by (long): COMMAND -->   the same, in --long alone
    <!-- measured DATE by: COMMAND -->    the table's figures come of the command, or of each line of it,
                                          which is run cut and, in --long, whole: then each figure must
                                          be in what it prints or in its summary.json. Of what is no
                                          `sightline`, such as a benchmark, date and command are told alone
    <!-- measured DATE by (long): ... --> the same, in --long alone

A table of which most cells are figures must have "measured" or "not run". Links must lead somewhere, and
a key that is named with its table (`image.bits`) must stand in docs/keys.md.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GENERATED = {"keys.md", "columns.md"}  # `ctest` compares these with the program
TIMEOUT_S = 600
CUTS = {"--trials": 1, "--count": 3, "--repeats": 2, "--scenes": 1}
# Of these, words within a text are run too: they need no file that is the reader's.
RUN_IN_TEXT = {"study", "coverage", "bound", "list", "doctor", "target"}


class Piece:
    """A fenced block, a table or a command within a text, with the comments that stand before it."""

    def __init__(self, kind, line, lines, comments, intro=""):
        self.kind, self.line, self.lines, self.comments, self.intro = kind, line, lines, comments, intro

    def said(self, form):
        """What the comments say in this form: a pair of date and text, or None."""
        for comment in self.comments:
            found = re.fullmatch(form, comment, re.DOTALL)
            if found:
                return found
        return None


def pieces_of(text):
    """The page's pieces in their order."""
    pieces, comments, intro = [], [], ""
    lines = text.split("\n")
    i = 0
    while i < len(lines):
        line, begin = lines[i], i + 1
        i += 1
        if line.startswith("<!--"):
            comment = [line]
            while "-->" not in comment[-1]:
                comment.append(lines[i])
                i += 1
            comments.append("\n".join(comment)[4:].split("-->")[0].strip())
        elif line.lstrip().startswith("```"):
            block = []
            while not lines[i].lstrip().startswith("```"):
                block.append(lines[i])
                i += 1
            i += 1
            pieces.append(Piece("block", begin, block, comments, intro))
            comments, intro = [], ""
        elif line.startswith("|"):
            table = [line]
            while i < len(lines) and lines[i].startswith("|"):
                table.append(lines[i])
                i += 1
            pieces.append(Piece("table", begin, table, comments))
            pieces += in_text("\n".join(table), begin)
            comments = []
        elif line:
            paragraph = [line]
            while i < len(lines) and lines[i] and not lines[i].lstrip().startswith(("```", "|", "<!--")):
                paragraph.append(lines[i])
                i += 1
            intro = paragraph[-1]
            found = in_text("\n".join(paragraph), begin)
            for piece in found:
                piece.comments = comments
            if found:
                comments = []
            pieces += found
    return pieces


def in_text(text, line):
    """Commands within a text, between backquotes."""
    found = []
    for quoted in re.findall(r"`(sightline [^`]+)`", text):
        command = " ".join(quoted.split())
        words = command.split()
        if len(words) < 3 or words[1] not in RUN_IN_TEXT:
            continue
        if "..." in command or re.search(r"(?<![\w\"'])[A-Z][A-Z,]*(?![\w\"'])", command):
            continue
        found.append(Piece("words", line, [command], []))
    return found


def commands_of(block):
    """The block's commands: continued lines joined, remarks left out."""
    joined = re.sub(r"\\\n\s*", "", "\n".join(block))
    commands = [re.sub(r"\s{2,}# .*| # .*", "", line).strip() for line in joined.split("\n")]
    return [command for command in commands if command.startswith("sightline ")]


def cut(command):
    """The command with few trials."""
    for option, most in CUTS.items():
        command = re.sub(option + r" (\d+)", lambda m: f"{option} {min(int(m[1]), most)}", command)
    verb = command.split()[1]
    if verb == "study" and "--trials" not in command and "--plan" not in command:
        command += f" --trials {CUTS['--trials']}"
    if verb == "coverage" and "--trials" not in command:
        command += f" --trials {CUTS['--trials']}"
    if verb == "bound" and "--scenes" not in command:
        command += f" --scenes {CUTS['--scenes']}"
    return command


def is_figures(table):
    """Whether most of the table's cells are figures."""
    cells = [cell.strip(" *") for row in table[2:] for cell in row.strip("|").split("|")[1:]]
    figures = [cell for cell in cells if re.match(r"-?\d[\d.,]*", cell)]
    return len(cells) > 3 and len(figures) * 2 > len(cells)


def figures_in(text):
    return [(float(number), len(number.partition(".")[2]))
            for number in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.]*\w)", text)]


def numbers_below(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers_below(item)]
    return [float(value)] if isinstance(value, (int, float)) and not isinstance(value, bool) else []


def is_shown_in(block, output):
    """Whether the block's lines stand in the output one after the other; `...` leaves some out."""
    form = ".*?".join(re.escape(part) for part in "\n".join(l.rstrip() for l in block).strip().split("..."))
    return re.search(form, output, re.DOTALL) is not None


class Checker:
    def __init__(self, program, folder, is_long):
        self.program, self.folder, self.is_long = program, folder, is_long
        self.failures, self.printed, self.slow = [], {}, []

    def fail(self, page, piece, text):
        self.failures.append(f"{name_of(page)}:{piece.line}: {text}")
        print(f"  {self.failures[-1]}", flush=True)

    def run(self, command, place):
        """Exit code and what the command prints."""
        shutil.rmtree(place / "results", ignore_errors=True)
        environment = dict(os.environ, PATH=f"{self.program.parent}:{os.environ['PATH']}", COLUMNS="100")
        begin = time.monotonic()
        try:
            done = subprocess.run(command, shell=True, cwd=place, env=environment, timeout=TIMEOUT_S
                                  if not self.is_long else None, text=True, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        except subprocess.TimeoutExpired:
            return 124, "", f"took over {TIMEOUT_S} s"
        self.slow.append((time.monotonic() - begin, command))
        return done.returncode, done.stdout, done.stderr

    def run_all(self, page, piece, commands, place, expected):
        for command in commands:
            shown = command if self.is_long else cut(command) if command.startswith("sightline ") else command
            code, out, err = self.run(shown, place)
            if code != expected:
                self.fail(page, piece, f"exit code {code}, not {expected}: {shown}\n{(out + err)[-1000:]}")

    def block(self, page, piece, place):
        if found := re.search(r"[Ww]rite this as `([\w.]+)`:$", piece.intro):
            (place / found[1]).write_text("\n".join(piece.lines) + "\n")
            return
        if found := piece.said(r"printed by( \(long\))?: (.*)"):
            if found[1] and not self.is_long:
                return
            if found[2] not in self.printed:
                self.printed[found[2]] = self.run(found[2], place)
            code, out, err = self.printed[found[2]]
            if not is_shown_in(piece.lines, out + err):
                self.fail(page, piece, f"`{found[2]}` (exit code {code}) does not print this, but:\n"
                                       f"{(out + err)[:6000]}")
            return
        if piece.said("not run: .*"):
            return
        expected = int(found[1]) if (found := piece.said(r"exit code (\d+)")) else 0
        self.run_all(page, piece, commands_of(piece.lines), place, expected)

    def table(self, page, piece, place):
        if page.name in GENERATED:
            return
        measured = piece.said(r"measured \d{4}-\d\d-\d\d by( \(long\))?:\s*(.*)")
        if not measured:
            if is_figures(piece.lines) and not piece.said("not run: .*"):
                self.fail(page, piece, "a table of figures that does not say of which command they are")
            return
        if measured[1] and not self.is_long:
            return
        numbers, is_whole = [], True
        commands = [line for line in measured[2].split("\n") if line.startswith("sightline ")]
        for command in commands:
            out_folder = place / "measured"
            shutil.rmtree(out_folder, ignore_errors=True)
            if command.split()[1] == "study":
                command += " --out measured"
            shown = command if self.is_long else cut(command)
            is_whole = is_whole and shown == command
            code, out, err = self.run(shown, place)
            if code != 0:
                self.fail(page, piece, f"exit code {code}: {command}\n{err[-1000:]}")
            numbers += [number for number, _ in figures_in(out)]
            if (out_folder / "summary.json").exists():
                numbers += numbers_below(json.loads((out_folder / "summary.json").read_text()))
        if not commands or not is_whole:
            return
        known = {round(scale * number, digits) for number in numbers for scale in (1, 100)
                 for digits in range(5)}
        gone = [f"{number:.{digits}f}" for number, digits in figures_in("\n".join(piece.lines[2:]))
                if round(number, digits) not in known]
        if gone:
            self.fail(page, piece, f"not in what `{measured[2]}` gives: {', '.join(gone)}")

    def links(self, page, text):
        text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
        for match in re.finditer(r"\]\(([^)\s]+)\)", text):
            target, _, anchor = match[1].partition("#")
            if "://" in target:
                continue
            file = page.parent / target if target else page
            piece = Piece("link", text[:match.start()].count("\n") + 1, [], [])
            if not file.exists():
                self.fail(page, piece, f"leads nowhere: {match[1]}")
            elif anchor and file.suffix == ".md" and anchor not in anchors_of(file):
                self.fail(page, piece, f"no such heading: {match[1]}")

    def keys(self, page, text):
        known = keys_of(ROOT / "docs/keys.md")
        for match in re.finditer(r"`([a-z]+)\.([a-z_0-9]+)( = [^`]*)?`", text):
            is_file = match[2] in ("csv", "json", "toml", "txt")
            if not is_file and match[1] in known and match[2] not in known[match[1]]:
                piece = Piece("key", text[:match.start()].count("\n") + 1, [], [])
                self.fail(page, piece, f"no such key: {match[1]}.{match[2]}")

    def page(self, page):
        place = self.folder / page.stem
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        for name in ("docs", "tests/example", "assets"):  # a reader's folder may be a clone
            shutil.copytree(ROOT / name, place / name)
        text = page.read_text()
        self.links(page, text)
        self.keys(page, text)
        begin, ran = time.monotonic(), len(self.slow)
        for piece in pieces_of(text):
            if before := piece.said("before:(.*)"):
                self.run_all(page, piece, [l.strip() for l in before[1].strip().split("\n")], place, 0)
            if piece.kind == "block":
                self.block(page, piece, place)
            elif piece.kind == "table":
                self.table(page, piece, place)
            elif not piece.said("not run: .*"):
                self.run_all(page, piece, piece.lines, place, 0)
        print(f"{name_of(page)}: {len(self.slow) - ran} commands, "
              f"{time.monotonic() - begin:.0f} s", flush=True)


def name_of(page):
    return os.path.relpath(page, ROOT)


def anchors_of(file):
    anchors = set()
    for heading in re.findall(r"^#+ (.*)$", file.read_text(), re.MULTILINE):
        anchors.add(re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip()))
    return anchors


def keys_of(page):
    """The keys of each table of the page that lists them."""
    keys, table = {}, ""
    for line in page.read_text().split("\n"):
        if line.startswith("## "):
            found = re.search(r"\[([a-z]+)\]", line)
            table = found[1] if found else ""
        elif table and (found := re.match(r"\| `(\w+)", line)):
            keys.setdefault(table, set()).add(found[1])
    return keys


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("pages", nargs="*", type=Path)
    parser.add_argument("--long", action="store_true")
    arguments = parser.parse_args()
    checker = Checker(arguments.program.resolve(), arguments.folder.resolve(), arguments.long)
    pages = [page.resolve() for page in arguments.pages]
    for page in pages or [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        checker.page(page)
    print("slowest: " + "; ".join(f"{seconds:.0f} s {command}" for seconds, command in
                                  sorted(checker.slow, reverse=True)[:5]))
    print(f"{len(checker.slow)} commands run, {len(checker.failures)} failures")
    sys.exit(1 if checker.failures else 0)


if __name__ == "__main__":
    main()
