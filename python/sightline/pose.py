# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses from points: cameras, solvers, and the absolute orientation."""

from __future__ import annotations

import dataclasses
import os
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from sightline import _checks, _sightline
from sightline._sightline import InputError

_MOST_PIXELS = 1_000_000  # a side

# How many coefficients a lens may have, by its model; those that are not given are 0.
_COEFFICIENTS: dict[str, tuple[int, ...]] = _sightline.lens_coefficient_counts()


@dataclasses.dataclass(frozen=True)
class Camera:
    """A camera with a lens.

    The camera frame is x right, y down, z forward, in metres. Pixel centres are at whole
    coordinates: (0, 0) is the centre of the top-left pixel, and a centred principal point is
    ((width_px - 1) / 2, (height_px - 1) / 2), which is the default.

    A ray (x/z, y/z) that the lens bends to (a, b) is seen at the pixel
    (fx_px a + skew_px b + cx_px, fy_px b + cy_px). `lens` says which model `distortion` is of, with
    OpenCV's names and signs:

    - "brown_conrady": k1, k2, p1, p2 and perhaps k3,
    - "rational": k1, k2, p1, p2, k3, k4, k5, k6 and perhaps s1, s2, s3, s4,
    - "fisheye" (Kannala and Brandt): k1, k2, k3, k4; sees up to 90 degrees from its axis.

    Raises InputError for a side or a focal length that is not positive, an unknown model, or a number
    of coefficients that the model has not.
    """

    width_px: int
    height_px: int
    fx_px: float
    fy_px: Optional[float] = None  #: default: fx_px
    cx_px: Optional[float] = None
    cy_px: Optional[float] = None
    distortion: tuple[float, ...] = ()  #: default: zeros
    lens: str = "brown_conrady"
    skew_px: float = 0.0

    def __post_init__(self) -> None:
        def put(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        for name in ("width_px", "height_px"):
            put(name, _checks.whole(f"Camera: {name}", getattr(self, name), 1, _MOST_PIXELS))
        defaults = {
            "fx_px": None,
            "fy_px": self.fx_px,
            "cx_px": (self.width_px - 1) / 2,
            "cy_px": (self.height_px - 1) / 2,
        }
        for name, default in defaults.items():
            given = getattr(self, name)
            number = _checks.array(f"Camera: {name}", default if given is None else given, ())
            put(name, float(number))
        for name in ("fx_px", "fy_px"):
            if getattr(self, name) <= 0:
                raise InputError(f"Camera: {name} is {getattr(self, name)}, must be positive")
        put("skew_px", float(_checks.array("Camera: skew_px", self.skew_px, ())))
        counts = _COEFFICIENTS.get(self.lens)
        if counts is None:
            raise InputError(f"Camera: lens is {self.lens!r}, must be one of "
                             f"{', '.join(_COEFFICIENTS)}")
        lens = _checks.array("Camera: distortion", self.distortion, (None,))
        if len(lens) not in (0, *counts):
            raise InputError(f"Camera: distortion: has {len(lens)} numbers, must have "
                             f"{' or '.join(map(str, counts))} of a {self.lens} lens")
        missing = counts[-1] - len(lens)
        put("distortion", tuple(lens.tolist()) + (0.0,) * missing)

    @staticmethod
    def read(file: Union[str, os.PathLike[str]]) -> Camera:
        """The camera of a calibration file: OpenCV's or Kalibr's (.yaml, .json, .xml), COLMAP's
        cameras.txt, or a .toml with [camera]. FILE#NAME is one of several cameras in a file.
        Raises InputError, whose text names the file and what of it cannot be used."""
        return Camera._from_numbers(_sightline.read_camera(os.fspath(file)))

    @property
    def matrix(self) -> np.ndarray:
        """The 3 x 3 matrix that OpenCV calls the camera matrix."""
        return np.array([[self.fx_px, self.skew_px, self.cx_px],
                         [0, self.fy_px, self.cy_px], [0, 0, 1]])

    def project(self, points_in_cam: npt.ArrayLike) -> np.ndarray:
        """The pixels, n x 2, of n x 3 points in metres; NaN of one at or behind the camera."""
        points = _checks.array("Camera.project: points_in_cam", points_in_cam, (None, 3))
        return _sightline.project(self._numbers(), points)

    def _numbers(self) -> tuple:
        return (self.width_px, self.height_px, self.fx_px, self.fy_px, self.cx_px, self.cy_px,
                self.skew_px, self.lens, *self.distortion)

    @staticmethod
    def _from_numbers(numbers: tuple) -> Camera:
        return Camera(*numbers[:6], distortion=numbers[8:], lens=numbers[7], skew_px=numbers[6])


@dataclasses.dataclass(frozen=True)
class Diagnosis:
    """How far a solver trusts its own estimate; None where it has nothing to say."""

    is_ambiguous: Optional[bool] = None  #: another, clearly different pose explains nearly as much
    removed_probability: Optional[float] = None  #: that exactly `removed` are the outliers
    is_removal_limit_reached: Optional[bool] = None  #: it could remove no more
    is_test_failed: Optional[bool] = None  #: what is kept does not look like noise
    #: least squares without `removed`, 4 x 4, of a solver whose pose is a mean over several sets
    most_probable_cam_from_target: Optional[np.ndarray] = None
    is_significant: Optional[bool] = None  #: more points agree than chance explains


@dataclasses.dataclass(frozen=True)
class PoseEstimate:
    """What a solver answers. Of a failed one only the status means anything."""

    #: "ok", "too_few_points", "too_many_points", "degenerate", "behind_camera" or "diverged"
    status: str
    cam_from_target: Optional[np.ndarray] = None  #: 4 x 4, x_in_cam = cam_from_target * x_in_target
    removed: tuple[int, ...] = ()  #: places of the points judged outliers, ascending
    #: 6 x 6, of (w, dt) with cam_from_target = (Exp(w) R, t + dt), radians and metres: the solver's
    #: own or, with sigma known, that of the noise; None where neither is
    covariance: Optional[np.ndarray] = None
    unit_covariance: Optional[np.ndarray] = None  #: the same for noise of one pixel
    diagnosis: Optional[Diagnosis] = None
    iterations: int = 0
    #: places of the points that could not be used, ascending; also of a failed estimate
    ignored: tuple[int, ...] = ()
    #: of the kept points, px in u and in v; with covariances in their unit
    residual_rms: Optional[float] = None
    #: 4 x 4: another pose that explains the points nearly as well, where it is ambiguous
    second_cam_from_target: Optional[np.ndarray] = None
    #: standard deviation of the noise, px, as the solver was told or found it
    noise: Optional[float] = None
    #: of each point, 0 to 1; only from consensus
    inlier_probabilities: Optional[np.ndarray] = None
    removed_lines: tuple[int, ...] = ()  #: places of the lines judged outliers, ascending
    ignored_lines: tuple[int, ...] = ()  #: places of the lines that could not be used, ascending

    @property
    def is_ok(self) -> bool:
        return self.status == "ok"

    @property
    def rotation(self) -> Optional[np.ndarray]:
        """3 x 3; None of a failed estimate."""
        return None if self.cam_from_target is None else self.cam_from_target[:3, :3]

    @property
    def translation(self) -> Optional[np.ndarray]:
        """Metres, in the camera frame; None of a failed estimate."""
        return None if self.cam_from_target is None else self.cam_from_target[:3, 3]


def _estimate_from(answer: tuple, sigma: float) -> PoseEstimate:
    (status, pose, removed, covariance, unit, diagnosis, iterations, ignored, rms, second, noise,
     probabilities, removed_lines, ignored_lines) = answer
    if status != "ok":
        return PoseEstimate(status, iterations=iterations, ignored=tuple(ignored),
                            ignored_lines=tuple(ignored_lines))
    if covariance is None and sigma > 0 and unit.any():
        covariance = sigma**2 * unit
    return PoseEstimate(
        status, pose, tuple(removed), covariance, unit,
        None if diagnosis is None else Diagnosis(*diagnosis), iterations, tuple(ignored), rms,
        second, noise, None if probabilities is None else np.array(probabilities),
        tuple(removed_lines), tuple(ignored_lines))


def solve(
    points: npt.ArrayLike,
    pixels: npt.ArrayLike,
    camera: Camera,
    solver: str = "orpe_weighed",
    *,
    sigma: Optional[float] = None,
    covariance: Optional[npt.ArrayLike] = None,
    initial: Optional[npt.ArrayLike] = None,
    options: Optional[Mapping[str, Any]] = None,
    true_inliers: Optional[npt.ArrayLike] = None,
    lines: Optional[npt.ArrayLike] = None,
) -> PoseEstimate:
    """The pose of a target from n of its points and where the camera saw them, or edges as lines.

    points        n x 3, metres, in the target's frame
    pixels        n x 2; pixel centres at whole coordinates (see Camera)
    solver        a name of solvers()
    sigma         standard deviation of an inlier's noise, px, each coordinate; None: not known
    covariance    n x 2 x 2 of the pixels (or 2 x 2, of each), px^2, for solvers that weigh
    initial       4 x 4, where to start; None: the solver finds starts of its own
    options       keys of a study's table [solver], such as {"rho": 10, "max_removed": 2}
    true_inliers  n flags, for the solver "oracle" alone, which exists to judge others by
    lines         m x 11, straight edges of the target seen as lines, for the solvers consensus and
                  lspe: two points of the edge (6 numbers, metres), two pixels of the line, anywhere
                  along it (4), and the standard deviation across it at either pixel

    Points that cannot be used (a number that is not finite, a pixel that the lens model cannot
    undo, a covariance that is not positive definite) are left out and listed in `ignored`. What can
    be expected to fail (too few points, collinear ones) is a status of the answer. Raises InputError
    for what cannot be used at all: a shape, an unknown solver or option.
    """
    of_points, of_pixels, noise, covariance, initial = _problem(
        "solve", points, pixels, camera, sigma, covariance, initial)
    count = len(of_points)
    if true_inliers is not None:
        true_inliers = _checks.array("solve: true_inliers", true_inliers, (count,)).astype(bool)
        true_inliers = true_inliers.tolist()
    of_lines = None
    if lines is not None:
        of_lines = _checks.array("solve: lines", lines, (None, 11), finite=False)
        if (of_lines[:, 10] <= 0).any():
            raise InputError("solve: lines: the sigma of a line is not above 0")
    settings = _checks.settings("solve: options", options, "solver.")
    answer = _sightline.solve(of_points, of_pixels, camera._numbers(), solver, noise, covariance,
                              initial, true_inliers, settings, of_lines)
    return _estimate_from(answer, noise)


def _require_covariance(where: str, matrix: np.ndarray) -> None:
    """Symmetric and positive definite: what is said of every point must be right."""
    off = matrix[0, 1]
    is_symmetric = abs(off - matrix[1, 0]) <= 1e-9 * (1 + abs(off))
    is_positive = matrix[0, 0] > 0 and matrix[0, 0] * matrix[1, 1] > off * matrix[1, 0]
    if not (is_symmetric and is_positive):
        raise InputError(f"{where}: is not symmetric and positive definite")


def _problem(where: str, points: Any, pixels: Any, camera: Any, sigma: Any, covariance: Any,
             initial: Any) -> tuple:
    """What a question about a pose is given, as arrays of the right shapes."""
    of_points = _checks.array(f"{where}: points", points, (None, 3), finite=False)
    count = len(of_points)
    of_pixels = _checks.array(f"{where}: pixels", pixels, (None, 2), finite=False)
    if len(of_pixels) != count:
        raise InputError(f"{where}: pixels has {len(of_pixels)} rows, points has {count}")
    if not isinstance(camera, Camera):
        raise InputError(f"{where}: camera is of type {type(camera).__name__}, must be a Camera")
    noise = 0.0 if sigma is None else float(_checks.array(f"{where}: sigma", sigma, ()))
    if sigma is not None and noise <= 0:
        raise InputError(f"{where}: sigma is {noise}, must be positive, or None")
    if covariance is not None:
        covariance = np.asarray(covariance)
        if covariance.shape == (2, 2):
            _require_covariance(f"{where}: covariance", _checks.array(
                f"{where}: covariance", covariance, (2, 2)))
            covariance = np.broadcast_to(covariance, (count, 2, 2))
        covariance = _checks.array(f"{where}: covariance", covariance, (count, 2, 2), finite=False)
    if initial is not None:
        initial = _checks.array(f"{where}: initial", initial, (4, 4))
    return of_points, of_pixels, noise, covariance, initial


@dataclasses.dataclass(frozen=True)
class PoseMinimum:
    """A pose at which the sum of squared reprojection errors is least among those near it."""

    cam_from_target: np.ndarray  #: 4 x 4
    cost: float  #: the sum, px^2; with covariances that of whitened errors
    unit_covariance: np.ndarray  #: 6 x 6, as of PoseEstimate


def solve_all(
    points: npt.ArrayLike,
    pixels: npt.ArrayLike,
    camera: Camera,
    *,
    sigma: Optional[float] = None,
    covariance: Optional[npt.ArrayLike] = None,
    initial: Optional[npt.ArrayLike] = None,
    left_out: Sequence[int] = (),
) -> list[PoseMinimum]:
    """Every pose that explains the points: the minima of least squares, the best first.

    A plane has two, three points have up to four. Arguments as of solve(); `left_out` are places of
    points that take no part, such as those that a solver removed. Points that cannot be used take
    none either. Empty where there is no pose: fewer than three points, or collinear ones.
    """
    of_points, of_pixels, noise, covariance, initial = _problem(
        "solve_all", points, pixels, camera, sigma, covariance, initial)
    most = len(of_points) - 1
    places = sorted({_checks.whole("solve_all: left_out", i, 0, most) for i in left_out})
    _, minima, _ = _sightline.solve_all(of_points, of_pixels, camera._numbers(), noise, covariance,
                                        initial, places)
    return [PoseMinimum(*minimum) for minimum in minima]


@dataclasses.dataclass(frozen=True)
class Alignment:
    """What a method of absolute orientation answers: x_b = scale R x_a + t."""

    status: str  #: "ok", or why there is none: "degenerate", "reflection", ...
    b_from_a: Optional[np.ndarray] = None  #: 4 x 4, rigid: the scale is not in it
    scale: float = 1.0  #: other than 1 only of methods that estimate it

    @property
    def is_ok(self) -> bool:
        return self.status == "ok"

    @property
    def rotation(self) -> Optional[np.ndarray]:
        """3 x 3; None of a failed one."""
        return None if self.b_from_a is None else self.b_from_a[:3, :3]

    @property
    def translation(self) -> Optional[np.ndarray]:
        """Metres; None of a failed one."""
        return None if self.b_from_a is None else self.b_from_a[:3, 3]


def align(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    method: str = "fast",
    *,
    weights: Optional[npt.ArrayLike] = None,
) -> Alignment:
    """The pose b_from_a of matched points: the least sum of w |x_b - (R x_a + t)|^2.

    a, b     n x 3, metres, the same points in two frames
    method   a name of methods()
    weights  n numbers that are not negative; None: all 1

    What can be expected to fail is a status of the answer. Raises InputError for a shape that is
    wrong or a method that is not known.
    """
    of_a = _checks.array("align: a", a, (None, 3), finite=False)
    of_b = _checks.array("align: b", b, (len(of_a), 3), finite=False)
    of_weights = [] if weights is None else _checks.array("align: weights", weights, (len(of_a),))
    status, matrix, scale = _sightline.align(of_a, of_b, method, list(of_weights))
    return Alignment(status, matrix, scale) if status == "ok" else Alignment(status)


def solvers() -> dict[str, str]:
    """The pose solvers: their names, and a line about each."""
    return _sightline.solvers()


def methods() -> dict[str, str]:
    """The methods of absolute orientation: their names, and a line about each."""
    return _sightline.methods()


def extractors() -> dict[str, str]:
    """The feature extractors: their names, and a line about each."""
    return _sightline.extractors()
