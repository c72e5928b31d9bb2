# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets, and rendered frames with all that is true of them."""

from __future__ import annotations

import dataclasses
import os
from typing import Any, Mapping, Optional, Union

import numpy as np
import numpy.typing as npt

from sightline import _checks, _sightline
from sightline.pose import Camera

_MOST_IMAGES = 10**9


@dataclasses.dataclass(frozen=True)
class Target:
    """A mesh and its features, in the target's frame: x forward, y starboard, z down, metres."""

    name: str
    description: str
    features: list[str]
    kinds: list[str]  #: "line_intersection", "corner" or "contour" each
    points: np.ndarray  #: n x 3, where the features are
    vertices: np.ndarray  #: of the mesh, v x 3
    triangles: np.ndarray  #: t x 3, places among the vertices, counter-clockwise from outside
    parts: list[str]  #: of the mesh; a frame's part_ids are their places plus one
    diameter_m: float  #: the greatest distance of two vertices


def target(name: Union[str, os.PathLike]) -> Target:
    """A target by its name (see targets()), a target.toml, or any mesh file (without features).

    Raises InputError for whatever is missing, misspelt, out of range or unreadable.
    """
    return Target(**_sightline.target(os.fspath(name)))


def targets() -> dict[str, str]:
    """The targets that ship: their names, and a line about each."""
    return _sightline.targets()


@dataclasses.dataclass(frozen=True)
class Body:
    """What is true of one body in a frame."""

    target: str
    cam_from_target: np.ndarray  #: 4 x 4, at mid-exposure
    is_occluder: bool  #: it hides and shades, but nobody asks for its pose
    features: list[str]
    pixels: np.ndarray  #: n x 2, where the features are, seen or not
    is_visible: np.ndarray  #: n flags: inside the image, and hidden by nothing
    box: tuple[int, int, int, int]  #: x, y, width, height of the pixels that see the body
    visible_fraction: float  #: of what would be seen if it were alone


@dataclasses.dataclass(frozen=True)
class Observations:
    """What a study's extractors found in a frame."""

    features: list[str]
    status: list[str]  #: "found", or why not
    pixels: np.ndarray  #: n x 2, meaningful where found
    covariances: np.ndarray  #: n x 2 x 2, px^2


@dataclasses.dataclass(frozen=True)
class Frame:
    """An image and its truth. The images are the renderer's own memory, not copies of it, and
    cannot be written to; they stay as long as the arrays do.
    """

    camera: Camera
    bits: int  #: of the image's grey levels
    cam_from_target: np.ndarray  #: 4 x 4, the true pose
    image: Optional[np.ndarray] = None  #: height x width, uint8, or uint16 for more than 8 bits
    colour: Optional[np.ndarray] = None  #: height x width x 3, red first, of a scene in colour
    depth_m: Optional[np.ndarray] = None  #: float64, z of what the pixel's centre sees; 0: nothing
    part_ids: Optional[np.ndarray] = None  #: uint16, place in the body's parts plus one; 0: nothing
    body_ids: Optional[np.ndarray] = None  #: uint8, place in `bodies` plus one; 0: nothing
    bodies: tuple[Body, ...] = ()  #: the target first
    trial: Optional[int] = None  #: of a study's frame
    condition: Optional[str] = None  #: of a study's frame
    prior_cam_from_target: Optional[np.ndarray] = None  #: of a study's frame, 4 x 4
    observations: Optional[Observations] = None  #: of a study's frame

    @property
    def features(self) -> list[str]:
        """The target's features."""
        return self.bodies[0].features if self.bodies else []

    @property
    def pixels(self) -> np.ndarray:
        """n x 2: where the target's features truly are."""
        return self.bodies[0].pixels if self.bodies else np.empty((0, 2))

    @property
    def is_visible(self) -> np.ndarray:
        """n flags of the target's features."""
        return self.bodies[0].is_visible if self.bodies else np.empty(0, dtype=bool)

    @staticmethod
    def _from_dict(frame: dict[str, Any]) -> Frame:
        out = dict(frame)
        out["camera"] = Camera._from_numbers(out["camera"])
        bodies = []
        for body in out.get("bodies", ()):
            bodies.append(Body(**{**body, "is_visible": np.array(body["is_visible"], dtype=bool)}))
        out["bodies"] = tuple(bodies)
        if "observations" in out:
            out["observations"] = Observations(**out["observations"])
        return Frame(**out)


class Scene:
    """What is to be rendered: a target's name (with its default scene), a study's, or a file.

    set   keys over the file's, such as {"image.bits": 12}; see docs/keys.md
    seed  of all random draws

    Raises InputError for whatever is missing, misspelt or out of range.
    """

    def __init__(
        self,
        source: Union[str, os.PathLike],
        set: Optional[Mapping[str, Any]] = None,
        seed: Optional[int] = None,
    ) -> None:
        settings = _checks.settings("Scene: set", set)
        number = None if seed is None else _checks.whole("Scene: seed", seed, 0, 9 * 10**15)
        self._handle = _sightline.read_scene(os.fspath(source), settings, number)

    @property
    def toml(self) -> str:
        """The scene's file as it would be rendered."""
        return self._handle.toml


def render(
    scene: Union[Scene, str, os.PathLike],
    index: int = 0,
    *,
    cam_from_target: Optional[npt.ArrayLike] = None,
    set: Optional[Mapping[str, Any]] = None,
    seed: Optional[int] = None,
) -> Frame:
    """Image number `index` of the set that `sightline render` would write of that scene.

    scene            a Scene (which is read once for many images), or what a Scene is made of,
                     with `set` and `seed`
    cam_from_target  4 x 4: this pose instead of the drawn one

    Raises InputError for a scene that cannot be imaged.
    """
    if not isinstance(scene, Scene):
        scene = Scene(scene, set, seed)
    elif set is not None or seed is not None:
        raise _sightline.InputError("render: set and seed are said to the Scene")
    number = _checks.whole("render: index", index, 0, _MOST_IMAGES)
    pose = None
    if cam_from_target is not None:
        pose = _checks.array("render: cam_from_target", cam_from_target, (4, 4))
    return Frame._from_dict(_sightline.render(scene._handle, number, pose))
