# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sightline: poses of meshed targets from images, and how wrong every step was.

    import sightline as sl

    estimate = sl.solve(points, pixels, camera, solver="orpe")
    run = sl.Study("cube-noise", trials=100).run(solvers=["orpe", my_solver], jobs=2)
    run.columns()["geodesic_deg"]

Frames and units are those of the program: transforms are `b_from_a`, metres and radians inside,
pixel centres at whole coordinates. What cannot be used raises InputError with the line that the
program prints; what can be expected to fail is a status. See docs/python.md.
"""

from __future__ import annotations

import pathlib as _pathlib

from sightline import _sightline
from sightline._sightline import InputError
from sightline.frames import Body, Frame, Observations, Scene, Target, render, target, targets
from sightline.guests import ExtractorQuestion, SolverQuestion, TrialName
from sightline.pose import (
    Alignment,
    Camera,
    Diagnosis,
    PoseEstimate,
    PoseMinimum,
    align,
    extractors,
    methods,
    solve,
    solve_all,
    solvers,
)
from sightline.results import Comparison, Report, Run, compare
from sightline.study import Study, studies

__version__: str = _sightline.version

__all__ = [
    "Alignment", "Body", "Camera", "Comparison", "Diagnosis", "ExtractorQuestion", "Frame",
    "InputError", "Observations", "PoseEstimate", "PoseMinimum", "Report", "Run", "Scene",
    "SolverQuestion", "Study", "Target", "TrialName", "align", "compare", "extractors", "methods",
    "render", "solve", "solve_all", "solvers", "studies", "target", "targets",
]


def _use_installed_assets() -> None:
    """Of an installed package the targets and studies lie in its prefix."""
    for folder in _pathlib.Path(__file__).resolve().parents:
        assets = folder / "share" / "sightline"
        if (assets / "targets").is_dir():
            _sightline.use_assets(str(assets))
            return


_use_installed_assets()
