# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Callables as solvers and extractors of a study: what they are asked, and what they may answer."""

from __future__ import annotations

import dataclasses
import os
import re
import sys
from typing import Any, Callable, Mapping, Optional

import numpy as np

from sightline import _checks, _sightline
from sightline._sightline import InputError
from sightline.pose import Camera, PoseEstimate

_NAME = re.compile(r"[A-Za-z0-9_.-]+")
_RAISED = "raised an error"
_UNREADABLE = "answer unreadable"
_NONE = "no estimate"


@dataclasses.dataclass(frozen=True)
class TrialName:
    """The picture that a trial shows, as BOP numbers pictures; of rendered ones scene_id is 0."""

    trial: int
    scene_id: int
    im_id: int
    gt_id: int


@dataclasses.dataclass(frozen=True)
class SolverQuestion:
    """What a solver is asked: the pose of a target from n points.

    It may answer a PoseEstimate (as solve() returns), a 4 x 4 matrix cam_from_target, a pair
    (rotation 3 x 3, translation 3), or None: it has no pose.
    """

    points: np.ndarray  #: n x 3, metres, in the target's frame
    pixels: np.ndarray  #: n x 2
    camera: Camera
    covariance: Optional[np.ndarray]  #: n x 2 x 2, px^2, as the extractor states it
    sigma: Optional[float]  #: of the noise, px, where the study tells it
    initial: Optional[np.ndarray]  #: 4 x 4, the prior, where the study starts there
    features: list[str]  #: the points' names
    trial: TrialName


@dataclasses.dataclass(frozen=True)
class ExtractorQuestion:
    """What an extractor is asked: where n features are in one image.

    It may answer a mapping from a feature's name to (u, v), (u, v, sigma) or (u, v, covariance 2 x
    2), or an array n x 2 or n x 3 (u, v, sigma), NaN of what is not found; or None: it failed.
    Without a stated sigma it is one pixel.
    """

    image: np.ndarray  #: height x width, 8 or 16 bit, not to be written to
    white: float  #: the greatest value that the image can have
    camera: Camera
    prior_cam_from_target: np.ndarray  #: 4 x 4
    features: list[str]
    kinds: list[str]  #: "line_intersection", "corner" or "contour" each
    points: np.ndarray  #: n x 3, metres, in the target's frame
    predicted: np.ndarray  #: n x 2, where the prior expects each
    predicted_covariance: np.ndarray  #: n x 2 x 2, px^2, that the prior's error leaves
    is_hidden: list[bool]  #: by the target itself, at the prior
    trial: TrialName


def name_of(where: str, guest: Any) -> tuple[str, Callable]:
    """A callable and its name, which a pair (name, callable) says, or else the callable itself."""
    if isinstance(guest, tuple) and len(guest) == 2:
        name, function = guest
    else:
        name, function = getattr(guest, "__name__", type(guest).__name__), guest
    if not callable(function):
        raise InputError(f"{where}: {guest!r} is neither a name nor a callable")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise InputError(f"{where}: name is {name!r}, must be letters, digits, '-', '_' and '.'; "
                         "give a pair (name, callable)")
    return name, function


class _Adapter:
    """Stands between a study and a callable: what that raises is a failed trial with its reason."""

    def __init__(self, kind: str, name: str, function: Callable, log: str) -> None:
        self._who = f"{kind} {name}"
        self._function = function
        self._log = log
        self._process = os.getpid()

    def _ask(self, question: Any, read: Callable[[Any], tuple], trial: int) -> tuple:
        try:
            answer = self._function(question)
        except Exception as error:  # not KeyboardInterrupt and SystemExit, which are meant
            return self._failed(_RAISED, trial, error)
        finally:
            if os.getpid() != self._process:  # a worker ends without a last flush
                sys.stdout.flush()
        try:
            return read(answer)
        except Exception as error:
            return self._failed(_UNREADABLE, trial, error)

    def _failed(self, outcome: str, trial: int, error: Exception) -> tuple:
        text = " ".join(f"{type(error).__name__}: {error}".split())
        with open(self._log, "a", encoding="utf-8") as log:  # one write each: processes share it
            log.write(f"{self._who}: trial {trial}: {outcome}: {text}\n")
        return (outcome,)


class SolverAdapter(_Adapter):
    """Called by the extension module with bare arrays."""

    def __call__(self, points, pixels, camera, sigma, covariance, initial, features, trial):
        question = SolverQuestion(points, pixels, Camera._from_numbers(camera), covariance,
                                  sigma if sigma > 0 else None, initial, features,
                                  TrialName(*trial))
        return self._ask(question, lambda answer: _read_pose(answer, len(points)), trial[0])


def _read_pose(answer: Any, count: int) -> tuple:
    """An outcome, a pose, the places removed, own and unit covariance, diagnosis."""
    if answer is None:
        return (_NONE,)
    if isinstance(answer, PoseEstimate):
        return _read_estimate(answer, count)
    if isinstance(answer, tuple) and len(answer) == 2:
        matrix = np.eye(4)
        matrix[:3, :3] = _checks.array("rotation", answer[0], (3, 3), finite=False)
        translation = np.asarray(answer[1], dtype=np.float64).reshape(-1)
        matrix[:3, 3] = _checks.array("translation", translation, (3,), finite=False)
    else:
        matrix = _checks.array("cam_from_target", answer, (4, 4), finite=False)
        if not np.array_equal(matrix[3], (0, 0, 0, 1)):
            raise InputError("cam_from_target: its last row is not 0 0 0 1")
    return ("ok", matrix, [], None, None, None)


def _read_estimate(answer: PoseEstimate, count: int) -> tuple:
    if not answer.is_ok:
        if answer.status not in _sightline.outcomes():
            raise InputError(f"status: is {answer.status!r}, must be one of "
                             + ", ".join(_sightline.outcomes()))
        return (answer.status,)
    matrix = _checks.array("cam_from_target", answer.cam_from_target, (4, 4), finite=False)
    removed = sorted({_checks.whole("removed", i, 0, count - 1) for i in answer.removed})
    covariances = [
        None if given is None else _checks.array("covariance", given, (6, 6))
        for given in (answer.covariance, answer.unit_covariance)
    ]
    diagnosis = answer.diagnosis and (
        answer.diagnosis.is_ambiguous, answer.diagnosis.removed_probability,
        answer.diagnosis.is_removal_limit_reached, answer.diagnosis.is_test_failed)
    return ("ok", matrix, removed, *covariances, diagnosis)


class ExtractorAdapter(_Adapter):
    """Called by the extension module with bare arrays."""

    def __call__(self, image, white, camera, prior, features, kinds, points, predicted, covariance,
                 is_hidden, trial):
        question = ExtractorQuestion(image, white, Camera._from_numbers(camera), prior, features,
                                     kinds, points, predicted, covariance, is_hidden,
                                     TrialName(*trial))
        return self._ask(question, lambda answer: _read_observations(answer, features), trial[0])


def _read_observations(answer: Any, features: list[str]) -> tuple:
    """A problem or None, pixels n x 2 (NaN of what is not found), covariances n x 2 x 2."""
    if answer is None:
        return (_NONE,)
    count = len(features)
    pixels = np.full((count, 2), np.nan)
    covariances = np.tile(np.eye(2), (count, 1, 1))
    if isinstance(answer, Mapping):
        places = {name: i for i, name in enumerate(features)}
        for name, found in answer.items():
            if name not in places:
                raise InputError(f"feature {name!r} is none of " + ", ".join(features))
            _read_found(name, found, places[name], pixels, covariances)
    else:
        rows = np.asarray(answer, dtype=np.float64)
        if rows.shape not in ((count, 2), (count, 3)):
            raise InputError(f"has shape {rows.shape}, must be ({count}, 2) or ({count}, 3)")
        for i, row in enumerate(rows):
            if np.isfinite(row[:2]).all():
                _read_found(features[i], tuple(row), i, pixels, covariances)
    return (None, pixels, covariances)


def _read_found(name: str, found: Any, place: int, pixels: np.ndarray,
                covariances: np.ndarray) -> None:
    if len(found) not in (2, 3):
        raise InputError(f"feature {name!r}: must be (u, v), (u, v, sigma) or (u, v, covariance)")
    pixels[place] = _checks.array(f"feature {name!r}", found[:2], (2,))
    if len(found) == 2:
        return
    spread = np.asarray(found[2], dtype=np.float64)
    covariance = spread**2 * np.eye(2) if spread.ndim == 0 else spread
    covariance = _checks.array(f"feature {name!r}: covariance", covariance, (2, 2))
    if not np.allclose(covariance, covariance.T) or np.linalg.eigvalsh(covariance)[0] <= 0:
        raise InputError(f"feature {name!r}: its covariance is not symmetric and positive definite")
    covariances[place] = covariance
