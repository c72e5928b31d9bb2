# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What runs leave, as arrays, and how two runs compare."""

from __future__ import annotations

import csv
import dataclasses
import html
import json
import os
import pathlib
import sqlite3
import sys
from typing import Any, Optional, Sequence, Union

import numpy as np

from sightline import _checks, _sightline
from sightline._sightline import InputError

# What a column holds does not depend on the run: a text may look like a number, or be nowhere.
_TEXTS = {"condition", "extractor", "image", "solver", "method", "status", "removed", "feature",
          "label"}
_WHOLES = {"trial", "position", "scene_id", "im_id", "gt_id", "found", "outliers", "redraws",
           "copies", "failures", "false_removals", "missed_outliers"}
_ERRORS = "errors.log"


def _column(name: str, fields: Sequence[Any]) -> np.ndarray:
    """Whole numbers, numbers with NaN for nothing, or texts."""
    is_number = name not in _TEXTS or any(isinstance(field, int) for field in fields)
    if not is_number:
        return np.array(["" if field is None else field for field in fields], dtype=object)
    try:
        if name in _WHOLES:
            return np.array([int(field) for field in fields], dtype=np.int64)
        return np.array([np.nan if f in ("", None) else f for f in fields], dtype=np.float64)
    except (TypeError, ValueError):  # words that a study sweeps, and what the store holds as bytes
        return np.array(fields, dtype=object)


class Run:
    """A run in its folder, be it of this module or of the program.

    Raises InputError where there is none.
    """

    def __init__(self, folder: Union[str, os.PathLike]) -> None:
        self.path = pathlib.Path(os.fspath(folder)).absolute()
        for name in ("results.csv", "summary.json"):
            if not (self.path / name).is_file():
                raise InputError(f"{self.path}: holds no {name}; must be the folder of a run")
        self.note: str = ""  #: one line where figures/ lacks its .svg
        self.resumed_trials: int = 0  #: what was there when the run began

    @classmethod
    def _made(cls, folder: pathlib.Path, result: tuple, log: str) -> Run:
        run = cls(folder)
        _, run.resumed_trials, _, run.note = result
        if log:
            run._keep_errors(pathlib.Path(log))
        return run

    def _keep_errors(self, log: pathlib.Path) -> None:
        # The report asks again about the frames that it shows.
        lines = list(dict.fromkeys(log.read_text(encoding="utf-8").splitlines()))
        if not lines:
            return
        with open(self.path / _ERRORS, "a", encoding="utf-8") as file:
            file.writelines(line + "\n" for line in lines)
        print(f"sightline: {len(lines)} failed answers of callables, the first: {lines[0]} "
              f"(see {self.path / _ERRORS})", file=sys.stderr)

    def __repr__(self) -> str:
        return f"<sightline.Run {self.path}>"

    @property
    def report(self) -> Report:
        """The report, a page in one file."""
        return Report(self)

    @property
    def summary(self) -> dict[str, Any]:
        """summary.json: means with intervals, medians, failures and more of every cell."""
        return json.loads((self.path / "summary.json").read_text(encoding="utf-8"))

    @property
    def manifest(self) -> dict[str, Any]:
        """How, where and when the run was made."""
        return json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))

    @property
    def errors(self) -> list[str]:
        """Why callables failed, one line a trial; empty where none did."""
        file = self.path / _ERRORS
        return file.read_text(encoding="utf-8").splitlines() if file.is_file() else []

    def columns(self) -> dict[str, np.ndarray]:
        """results.csv by columns (docs/columns.md says what they are), a row a trial and solver.

        Numbers are float64, NaN where the row has none, or int64 where all rows have whole ones;
        texts are objects. pandas.DataFrame(run.columns()) is the table.
        """
        with open(self.path / "results.csv", newline="", encoding="utf-8") as file:
            rows = csv.reader(file)
            names = next(rows)
            fields = list(zip(*rows)) or [()] * len(names)
        return {name: _column(name, of_name) for name, of_name in zip(names, fields)}

    def observations(self) -> dict[str, np.ndarray]:
        """What became of every feature in every trial, by columns (docs/columns.md)."""
        return self._table("observations", "trial, position")

    def trials(self) -> dict[str, np.ndarray]:
        """The trials with their true and prior poses, by columns (docs/columns.md)."""
        return self._table("trials", "trial")

    def _table(self, table: str, order: str) -> dict[str, np.ndarray]:
        store = self.path / "results.sqlite"
        if not store.is_file():
            raise InputError(f"{self.path}: holds no results.sqlite")
        connection = sqlite3.connect(f"{store.as_uri()}?mode=ro", uri=True)
        try:
            cursor = connection.execute(f"SELECT * FROM {table} ORDER BY {order}")
            names = [description[0] for description in cursor.description]
            fields = list(zip(*cursor)) or [()] * len(names)
        finally:
            connection.close()
        return {name: _column(name, of_name) for name, of_name in zip(names, fields)}


class Report:
    """The report of a run: one page in one file. A notebook shows it where it is the last value.

    It is a path to whatever takes one: open(report), shutil.copy(report, ...). Raises InputError
    where there is no run.
    """

    def __init__(self, run: Union[Run, str, os.PathLike]) -> None:
        self._run = run if isinstance(run, Run) else Run(run)
        self.path = self._run.path / "report.html"

    def __fspath__(self) -> str:
        return str(self.path)

    def __repr__(self) -> str:
        return f"<sightline.Report {self.path}>"

    @property
    def html(self) -> str:
        """The page."""
        return self.path.read_text(encoding="utf-8")

    def rewrite(self) -> Report:
        """Writes results.csv, summary.json and the page anew, as `sightline report` does."""
        self._run.note = _sightline.rewrite_report(str(self._run.path))
        return self

    def _repr_html_(self) -> str:
        page = html.escape(self.html, quote=True)
        return (f'<iframe srcdoc="{page}" width="100%" height="800" sandbox="allow-scripts">'
                "</iframe>")


@dataclasses.dataclass(frozen=True)
class Comparison:
    """What `sightline compare` says of two runs of one study."""

    study: str
    how: str  #: paired on which trials or, if not, why
    is_worse: bool  #: a cell is worse or missing: what the program's exit code 3 means
    text: str  #: what the program prints
    markdown: str
    junit: str  #: XML, a test case a cell
    _rows: Sequence[tuple] = dataclasses.field(repr=False, default=())

    def columns(self) -> dict[str, np.ndarray]:
        """A row a number that was compared: cell, quantity, base, now, interval, p, verdict."""
        names = ("condition", "solver", "cell_verdict", "quantity", "trials", "base", "now",
                 "ci95_low", "ci95_high", "p", "verdict")
        texts = {"condition", "solver", "cell_verdict", "quantity", "verdict"}
        empty = [("" if name in texts else np.nan) for name in names]
        rows = [tuple(row) + tuple(empty[len(row):]) for row in self._rows]
        fields = list(zip(*rows)) or [()] * len(names)
        return {name: np.array(of_name, dtype=object if name in texts else np.float64)
                for name, of_name in zip(names, fields)}

    def __str__(self) -> str:
        return self.text


def compare(
    base: Union[Run, str, os.PathLike],
    new: Union[Run, str, os.PathLike],
    tolerance: float = 0.0,
    measures: Sequence[str] = (),
) -> Comparison:
    """Says of every cell whether `new` is better, worse or unchanged against `base`.

    Each is a Run, a run's folder, a summary.json alone, or what `sightline score` left. `tolerance`
    is what errors may change by as a part of the base's, rates as a part of the trials. `measures`
    are what is judged by, as `sightline list measures` names them; none: mean and middle of
    geodesic_deg and t_error_percent, and failure_rate. Raises InputError for what cannot be read,
    and for runs of different studies.
    """
    part = float(_checks.array("compare: tolerance", tolerance, ()))
    if not 0 <= part <= 1:
        raise InputError(f"compare: tolerance is {part}, must be from 0 to 1")
    folders = [os.fspath(run.path if isinstance(run, Run) else run) for run in (base, new)]
    out = _sightline.compare(*folders, part, list(measures))
    return Comparison(out["study"], out["how"], out["is_worse"], out["text"], out["markdown"],
                      out["junit"], out["rows"])
