# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: read, run, and looked at frame by frame."""

from __future__ import annotations

import os
import pathlib
import tempfile
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Union

from sightline import _checks, _sightline
from sightline._sightline import InputError
from sightline.frames import Frame
from sightline.guests import ExtractorAdapter, SolverAdapter, name_of
from sightline.results import Run

#: A built-in's name; a callable, which is known by its __name__; or a pair (name, callable).
Guest = Union[str, Callable, tuple[str, Callable]]

_MOST_TRIALS = 10_000_000
_MOST_JOBS = 1024
_BY_KIND = "by_kind"  # the extractors that a study's file names for each kind of feature


def studies() -> dict[str, str]:
    """The studies that ship: their names, and what each asks."""
    return _sightline.studies()


class Study:
    """A study by its name (see studies()) or its file, checked.

    set     keys over the file's, such as {"noise.scale": 2, "solvers": ["orpe", "lspe"]}; see
            docs/keys.md
    trials  of each condition
    seed    of all random draws

    Raises InputError for whatever is missing, misspelt, out of range or cannot be imaged.
    """

    def __init__(
        self,
        name: Union[str, os.PathLike],
        set: Optional[Mapping[str, Any]] = None,
        trials: Optional[int] = None,
        seed: Optional[int] = None,
    ) -> None:
        self._source = os.fspath(name)
        self._settings = _checks.settings("Study: set", set)
        self._trials = None if trials is None else _checks.whole("trials", trials, 1, _MOST_TRIALS)
        self._seed = None if seed is None else _checks.whole("seed", seed, 0, 9 * 10**15)
        self._handle = self._read([], [], [])

    def _read(self, settings: list[str], solvers: list, extractors: list):
        return _sightline.read_study(self._source, self._settings + settings, self._trials,
                                     self._seed, solvers, extractors)

    @property
    def name(self) -> str:
        return self._handle.name

    @property
    def title(self) -> str:
        return self._handle.title

    @property
    def question(self) -> str:
        """What the study asks."""
        return self._handle.question

    @property
    def kind(self) -> str:
        """Where its trials begin: "images", "numeric" or "orientation"."""
        return self._handle.kind

    @property
    def seed(self) -> int:
        return self._handle.seed

    @property
    def solvers(self) -> list[str]:
        """The names under which a trial's estimates are kept; of an orientation study, methods."""
        return self._handle.solvers

    @property
    def conditions(self) -> list[str]:
        return self._handle.conditions

    @property
    def toml(self) -> str:
        """The study's file as it would be run."""
        return self._handle.toml

    def __len__(self) -> int:
        """Trials, all conditions together."""
        return self._handle.trial_count

    def __repr__(self) -> str:
        return f"<sightline.Study {self.name}: {len(self)} trials>"

    def frames(self, begin: int = 0, end: Optional[int] = None) -> Iterator[Frame]:
        """The frames of the trials from number `begin` up to `end`, as a run would make them.

        Each has its truth, its prior, and what the study's own extractors find in it. A trial
        whose scene cannot be imaged has a frame without an image. Raises InputError for a study
        without images.
        """
        last = len(self) if end is None else min(end, len(self))
        for trial in range(_checks.whole("frames: begin", begin, 0, len(self)), last):
            yield Frame._from_dict(_sightline.trial_frame(self._handle, trial))

    def run(
        self,
        out: Optional[Union[str, os.PathLike]] = None,
        *,
        solvers: Optional[Sequence[Guest]] = None,
        extractor: Optional[Union[Guest, Sequence[Guest]]] = None,
        jobs: int = 1,
        shard: str = "",
        resume: bool = False,
        progress: bool = True,
    ) -> Run:
        """Runs the study and leaves the folder that `sightline study` would leave.

        out        must not exist, or be empty; default results/NAME, or -2, -3 ... if that exists
        solvers    instead of the study's: names and callables, which get a SolverQuestion
        extractor  instead of the study's: a name ("by_kind": those of the study's file), a
                   callable, which gets an ExtractorQuestion, or several, a cell each
        jobs       processes; callables are called in them, so that what a callable keeps for
                   itself stays in its process
        shard      "I/N": only trials with number mod N = I
        resume     continue what an ended run left in `out`
        progress   a bar on stderr, where that is a terminal

        A callable that raises makes a failed trial, counted as such; the reasons are in
        Run.errors. Ctrl-C raises KeyboardInterrupt and leaves nothing half-written. Raises
        InputError for whatever cannot be used.
        """
        folder = self._free_folder() if out is None else pathlib.Path(os.fspath(out))
        count = _checks.whole("run: jobs", jobs, 1, _MOST_JOBS)
        handle, log = self._handle, ""
        if solvers is not None or extractor is not None:
            descriptor, log = tempfile.mkstemp(prefix="sightline-", suffix=".log")
            os.close(descriptor)
        try:
            if log:
                handle = self._with_guests(solvers, extractor, log)
            result = _sightline.run(handle, os.fspath(folder), count, shard, resume, progress,
                                    f"sightline.Study({self._source!r}).run()")
            return Run._made(folder, result, log)
        finally:
            if log:
                os.remove(log)

    def _with_guests(self, solvers, extractor, log: str):
        settings: list[str] = []
        of_solvers, of_extractors = _Guests("solver"), _Guests("extractor")
        if solvers is not None:
            if isinstance(solvers, (str, tuple)) or callable(solvers):
                solvers = [solvers]
            of_solvers.take(solvers, SolverAdapter, set(_sightline.solvers()), log)
            settings += of_solvers.settings("solvers")
        if extractor is not None:
            if not isinstance(extractor, list):
                extractor = [extractor]
            taken = set(_sightline.extractors()) | {_BY_KIND}
            of_extractors.take(extractor, ExtractorAdapter, taken, log)
            settings += of_extractors.settings("extractors")
        return self._read(settings, of_solvers.adapters, of_extractors.adapters)

    def _free_folder(self) -> pathlib.Path:
        first = pathlib.Path("results") / self.name
        folder, i = first, 2
        while folder.exists() or folder.with_name(f".{folder.name}.partial").exists():
            folder, i = first.with_name(f"{first.name}-{i}"), i + 1
        return folder


class _Guests:
    """Names and callables as a user gives them: what the study's file says, and the adapters."""

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._names: list[str] = []
        self.adapters: list[tuple[str, Callable]] = []

    def take(self, given: Sequence[Guest], adapter: Callable, taken: set[str], log: str) -> None:
        for guest in given:
            if isinstance(guest, str):
                self._names.append(guest)
                continue
            name, function = name_of(f"run: {self._kind}", guest)
            if name in taken:
                raise InputError(f"run: {self._kind}: the name '{name}' is another's already; "
                                 "give a pair (name, callable)")
            taken.add(name)
            self._names.append(name)
            self.adapters.append((name, adapter(self._kind, name, function, log)))

    def settings(self, key: str) -> list[str]:
        out = [f"{key}={_checks.toml(key, self._names)}"]
        if self.adapters:
            functions = [name for name, _ in self.adapters]
            out.append(f"functions.{key}={_checks.toml(key, functions)}")
        return out
